/// Maps in one frame that are independent given what they share with their successor: a chain of conditionals, from the first map to
/// the one that the filter works on. [pinies2009], docs/math/conditionally_independent.md (I-1..I-7).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "ssjs/joining/map_joiner.hpp"
#include "ssjs/mapping/landmark_map.hpp"

namespace ssjs {

/// A closed map: own variables a = [base pose | landmarks that no later map holds], shared ones s = [exit pose | landmarks that the
/// next map holds too].   a = own_mean + K (s - shared_mean) + e, e ~ N(0, C), independent of everything later (I-2). K and C are
/// touched only when a landmark of a is recalled.
struct ClosedMap {
  std::vector<TrackedLandmark> own;
  std::vector<int> shared;  ///< labels
  Eigen::VectorXd own_mean, shared_mean;
  Eigen::MatrixXd K, C;
};

/// Landmarks go by their labels, which the owner counts from 0. All positions and covariances are in the world frame.
class ConditionalChain {
 public:
  /// Closes the present map, `state` = [vehicle | base pose | landmarks]; the landmarks at positions `shared` go on. Returns the state
  /// that the next map starts with: its frozen pose is the vehicle, its landmarks are the shared ones, in this order. (I-1, I-2)
  [[nodiscard]] MapState close(const MapState& state, const std::vector<TrackedLandmark>& landmarks,
                               const std::vector<Eigen::Index>& shared);

  /// Whether a closed map holds the landmark and the present one does not.
  [[nodiscard]] bool is_past(int label) const;
  [[nodiscard]] int holder(int label) const { return holder_[static_cast<std::size_t>(label)]; }  ///< the map, where is_past
  [[nodiscard]] int size() const { return static_cast<int>(maps_.size()); }                       ///< closed maps

  /// Carries a past landmark through all maps after its own into `present` (I-4, I-5), where it is the last landmark then. Costs
  /// O(own x shared) a map on the way.
  void recall(int label, LandmarkMap& present);

  /// Means of all past landmarks given the present map (I-3): by label, of those with is_past.
  struct PastLandmark {
    int label;
    Eigen::Vector2d position;
    double variance;  ///< trace of the covariance when its map was closed: never less than the present one
  };
  [[nodiscard]] std::vector<PastLandmark> past_landmarks(const LandmarkMap& present) const;

  /// Back-propagation through the whole chain (I-3, I-6).
  [[nodiscard]] WorldEstimate estimate(const MapState& present, const std::vector<TrackedLandmark>& landmarks,
                                       BaseCovariance covariance) const;

 private:
  using PairRows = Eigen::Matrix<double, 2, Eigen::Dynamic>;
  /// A landmark on its way: mean + k (s - reference) + e, over the shared variables s of the map it comes from.
  struct Traveller {
    Eigen::Vector2d mean;
    PairRows k;
    Eigen::Matrix2d variance;
  };
  [[nodiscard]] Traveller take_out(ClosedMap& map, std::size_t own, TrackedLandmark& landmark);
  void pass_through(ClosedMap& map, const ClosedMap& before, Traveller& traveller, int label);
  static void share(ClosedMap& map, const Traveller& traveller, const PairRows& with_own, int label);
  /// Notes in row_of_ where the map's landmarks stand in [own | shared].
  void note_rows(const ClosedMap& map) const;

  std::vector<ClosedMap> maps_;
  std::vector<int> holder_;                   ///< by label: the latest map that holds it; size() for the present one
  std::vector<double> variance_;              ///< by label, at the closing of its map
  mutable std::vector<Eigen::Index> row_of_;  ///< by label, scratch
};

/// The map that closes, in the frame of its base (frozen) pose, [exit pose | landmarks].
[[nodiscard]] MapState in_base_frame(const MapState& state);

}  // namespace ssjs
