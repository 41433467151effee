/// What a survey knows at the end: landmarks in the world, the way of the vehicle in six degrees of freedom. docs/math/ports.md
/// (P-13..P-15).
#pragma once

#include <Eigen/Core>
#include <deque>
#include <vector>

#include "ssjs/joining/port_level.hpp"

namespace ssjs {

struct SurveyLandmark {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< world frame, m; z depth
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  MapLandmark landmark;          ///< of all maps that saw it
  std::vector<int> maps;         ///< that saw it, ascending; a landmark of one map alone was never met again
  std::vector<double> seen_s{};  ///< by whichever map, ascending; empty where the maps do not remember
  // What judge_existence() makes of that (P-22); until then nothing speaks against the landmark.
  int passes_seen = 0, passes_expected = 0;
  double existence = 1.0;
  bool confirmed = true;
};

/// Every landmark of every map once: first the shared ones in the order of their unknowns, then the others map by map. (P-13)
[[nodiscard]] std::vector<SurveyLandmark> landmarks_in_world(const std::deque<PortMap>& maps, const PortLevel& level);
/// Covariance of all of them together, 3 rows each (x, y, depth), in that order. (P-13)
[[nodiscard]] Eigen::MatrixXd joint_landmark_covariance(const std::deque<PortMap>& maps, const PortLevel& level);

/// The vehicle at one time: global x, y (m), depth (m), roll, pitch, yaw (rad, in [-pi, pi)), additive covariance.
struct SurveyStep {
  double time_s = 0.0;
  Eigen::Matrix<double, 6, 1> global_T_vehicle = Eigen::Matrix<double, 6, 1>::Zero();
  Matrix6d covariance = Matrix6d::Zero();
};

/// The steps of one map, corrected by all that the survey knows of its ports. (P-14, P-15)
[[nodiscard]] std::vector<SurveyStep> steps_in_world(const PortMap& map, const PortKnowledge& level);

}  // namespace ssjs
