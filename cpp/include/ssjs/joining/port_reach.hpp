/// Which maps of a survey may show the landmarks of another. docs/math/ports.md (P-28), ssjs.md (J-6).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "ssjs/joining/port_level.hpp"

namespace ssjs {

/// Landmarks of one map around their centroid, base frame.
struct MapExtent {
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();
  double radius_m = 0.0;
  double reach_m = 0.0;  ///< within which they may be: three standard deviations of each further
  Eigen::Index landmarks = 0;

  void archive(Archive& a) {
    a("centroid", centroid);
    a("radius_m", radius_m);
    a("reach_m", reach_m);
    a("landmarks", landmarks);
  }
};
[[nodiscard]] MapExtent extent_of(const LevelledSubmap& submap);

/// A base is never known worse than when its map came, so that most maps are out of reach without a look at the joint covariance; those
/// that are left are judged by it, all at once.
class PortReach {
 public:
  /// The map whose base is the next one, once `level` knows that base.
  void add(const MapExtent& extent, const PortKnowledge& level);
  /// The maps before the newest that it may have landmarks in common with (J-6), ascending.
  [[nodiscard]] std::vector<int> of_newest(const PortKnowledge& level) const { return before(static_cast<int>(maps()) - 1, level); }
  /// The same of an older map, as if it were the newest.
  [[nodiscard]] std::vector<int> before(int newest, const PortKnowledge& level) const;

  [[nodiscard]] const MapExtent& extent(int map) const { return extents_[static_cast<std::size_t>(map)]; }

 private:
  std::vector<MapExtent> extents_;
  std::vector<Eigen::Matrix3d> base_covariances_;  ///< when the map came

 public:
  void archive(Archive& a) {
    a("extents", extents_);
    a("base_covariances", base_covariances_);
    a.require(extents_.size() == base_covariances_.size(), "has more or fewer covariances than extents");
  }
  [[nodiscard]] std::size_t maps() const { return extents_.size(); }
};

}  // namespace ssjs
