/// The whole map of a filter that works on a region of it. [guivant2001], docs/math/single_map.md (G-6, G-10).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "ssjs/filter/compression.hpp"
#include "ssjs/filter/ekf.hpp"

namespace ssjs {

/// Joint Gaussian of [vehicle | landmarks], one slot a landmark. Between enter() and update_from() the filter is ahead of it: the
/// filter holds the landmarks of the region, a Compression watches it, and this map waits.
class CompressedMap {
 public:
  /// A vehicle without landmarks, known exactly.
  CompressedMap();

  /// Gives the filter the vehicle and the landmarks of `slots`, in this order, and starts the compression.
  void enter(const std::vector<Eigen::Index>& slots, Ekf& filter, Compression& compression);

  /// Brings everything up to date (G-10): O(n^2 a), n the size of the map, a that of the region. slots: by landmark of the filter,
  /// negative for those that are new since enter(); they are given a slot. Slots of landmarks that the filter dropped become free.
  void update_from(const MapState& active, const Compression& compression, std::vector<Eigen::Index>& slots);

  [[nodiscard]] Eigen::Index slots() const { return slots_; }  ///< free ones included
  [[nodiscard]] bool is_free(Eigen::Index slot) const { return free_[static_cast<std::size_t>(slot)]; }
  [[nodiscard]] Eigen::Vector2d landmark_position(Eigen::Index slot) const { return mean_.segment<2>(StateLayout().offset(slot)); }
  [[nodiscard]] Eigen::Matrix2d landmark_covariance(Eigen::Index slot) const;
  /// The state of `slots`, both triangles.
  [[nodiscard]] MapState state(const std::vector<Eigen::Index>& slots) const;

 private:
  Eigen::Index take_slot();
  /// Rows of the state for [vehicle | slots].
  [[nodiscard]] static std::vector<Eigen::Index> rows_of(const std::vector<Eigen::Index>& slots);

  Eigen::Index slots_ = 0;
  std::vector<bool> free_;
  Eigen::VectorXd mean_;
  Eigen::MatrixXd P_;                  ///< lower triangle
  std::vector<Eigen::Index> entered_;  ///< slots given to the filter
  SymmetricDowndate downdate_;
};

}  // namespace ssjs
