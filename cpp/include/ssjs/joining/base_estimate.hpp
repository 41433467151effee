/// Where every base of a mission is, those included that have left the global level. docs/math/ssjs.md (J-17, J-18).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "ssjs/joining/conditional_map.hpp"
#include "ssjs/joining/global_map.hpp"
#include "ssjs/joining/map_joiner.hpp"

namespace ssjs {

/// A base frame that left the state of its map: its pose in the frame of another base as it was known then (J-18).
struct FrozenBase {
  int base;
  int reference;
  GaussianSe2 reference_T_base;
};

/// Live bases stand in the global map; what is inside a live map, or frozen, follows them: d(base) = J d[live] + n. Give all maps first,
/// then the frozen bases, a reference before what hangs on it.
class BaseEstimate {
 public:
  /// bases: how many the mission has.
  BaseEstimate(const GlobalMap& global, int bases);

  void add(const LiveMap& map, const WorldMap& in_world);
  void add(const FrozenBase& frozen);

  [[nodiscard]] const std::vector<Se2>& global_T_base() const { return global_T_base_; }
  /// Joint covariance of bases k and k + 1.
  [[nodiscard]] Matrix6d border_covariance(int k) const;
  /// Joint covariance of all bases, 3 each.
  [[nodiscard]] Eigen::MatrixXd joint_covariance() const;

 private:
  /// Bases that follow the same live ones; n is correlated within a family only.
  struct Family {
    std::vector<int> live;
    Eigen::MatrixXd J;      ///< 3 rows a follower, 3 columns a live base
    Eigen::MatrixXd noise;  ///< covariance of n
  };
  /// family < 0: a live base, which follows itself.
  struct Place {
    int family = -1;
    Eigen::Index row = 0;
  };
  [[nodiscard]] std::vector<int> followed_by(int base) const;
  /// Adds the derivative of `base` to the columns of `live` (3 each).
  void add_derivative(int base, const std::vector<int>& live, Eigen::Ref<Eigen::Matrix<double, 3, Eigen::Dynamic>> J) const;
  [[nodiscard]] Eigen::Matrix3d noise(int a, int b) const;

  const GlobalMap& global_;
  std::vector<Se2> global_T_base_;
  std::vector<Place> places_;  ///< by base
  std::vector<Family> families_;
};

}  // namespace ssjs
