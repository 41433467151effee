/// What a joining method does with the levelled maps of an underwater survey. docs/math/underwater_methods.md.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <deque>
#include <vector>

#include "ssjs/joining/map_joiner.hpp"
#include "ssjs/joining/port_estimate.hpp"

namespace ssjs {

/// Everything in the world frame: that of the first base, or aligned to north.
struct SurveyEstimate {
  std::vector<GaussianSe2> global_T_base;  ///< by map: where it starts
  Eigen::MatrixXd base_covariance;         ///< of these together, 3 each, additive; empty where it is not known or would be too large
  std::vector<SurveyLandmark> landmarks;
  Eigen::MatrixXd landmark_covariance;     ///< of these together, 3 each; empty where it is not known or would be too large
  std::vector<SurveyStep> steps;           ///< ascending time
  std::vector<LiveMapEstimate> live_maps;  ///< maps left, of one submap or of several
};

class SurveyJoiner {
 public:
  SurveyJoiner() = default;
  SurveyJoiner(const SurveyJoiner&) = delete;
  SurveyJoiner& operator=(const SurveyJoiner&) = delete;
  virtual ~SurveyJoiner() = default;

  /// Takes map number k, which starts at base k and ends at base k + 1.
  virtual JoinReport take(LevelledSubmap submap) = 0;
  /// Called once, after the last map.
  virtual JoinReport finish() = 0;

  /// Where the next map starts.
  [[nodiscard]] virtual GaussianSe2 global_T_newest_base() const = 0;
  [[nodiscard]] virtual const std::deque<PortMap>& maps() const = 0;
  /// After finish(). Of more bases than max_joint_bases no joint covariance is made.
  [[nodiscard]] virtual SurveyEstimate estimate(std::size_t max_joint_bases) const = 0;
  /// Borders at which the compass offset was not what the map before had; 0 where a method does not hand it on.
  [[nodiscard]] virtual int compass_jumps() const = 0;
  /// Landmarks that were found to be another one after both had stood in the survey; 0 where such a find is a join like any other.
  [[nodiscard]] virtual int merged() const = 0;
};

}  // namespace ssjs
