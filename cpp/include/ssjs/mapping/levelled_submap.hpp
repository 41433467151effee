/// A finished local map of an underwater vehicle: immutable, in its own levelled base frame. docs/math/ports.md (P-1, P-2).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "ssjs/base/archive.hpp"
#include "ssjs/geometry/gaussian.hpp"
#include "ssjs/geometry/se2.hpp"
#include "ssjs/mapping/base_fix.hpp"
#include "ssjs/mapping/submap.hpp"

namespace ssjs {

/// What a map knows of the compass offset c (compass reading minus heading in the map, rad).
enum class CompassPorts {
  kNone,      ///< nothing: no compass in the map, or a heading taken for exact
  kConstant,  ///< one scalar: the offset does not drift
  kBorders,   ///< two scalars, c_s when the map started and c_e when it ended: the drift between them is inside the map
};

/// Mean of (compass reading - heading in the map) over the samples of a map whose filter does not use the compass.
struct CompassMean {
  double offset_rad = 0.0;  ///< in [-pi, pi)
  double variance = 0.0;    ///< rad^2: samples, heading drift and offset drift within the map
  double time_s = 0.0;      ///< the middle of the samples

  void archive(Archive& a) {
    a("offset_rad", offset_rad);
    a("variance", variance);
    a("time_s", time_s);
  }
};

/// The vehicle at one time, x y z (m, z = depth, positive down) roll pitch yaw (rad): x, y, yaw in the base frame of the map, z, roll and
/// pitch absolute. Given the true values x of the first gain.cols() entries of the map's state, the pose is
/// base_T_vehicle + gain * (x - mean), yaw wrapped, with conditional_covariance. (P-14)
struct LevelledStep {
  double time_s = 0.0;
  Eigen::Matrix<double, 6, 1> base_T_vehicle = Eigen::Matrix<double, 6, 1>::Zero();  ///< by all that the map measured (A-24)
  Matrix6d covariance = Matrix6d::Zero();                                            ///< of that estimate
  Eigen::Matrix<double, 6, Eigen::Dynamic> gain;                                     ///< at least 3 columns, at most the whole state
  Matrix6d conditional_covariance = Matrix6d::Zero();

  void archive(Archive& a) {
    a("time_s", time_s);
    a("base_T_vehicle", base_T_vehicle);
    a("covariance", covariance);
    a("gain", gain);
    a("conditional_covariance", conditional_covariance);
  }
};

/// The base is level: z = 0 at the sea surface, x, y and heading those of the vehicle when the map started (exactly 0). A map does not
/// depend on any other map nor on any heading datum. State, mean and covariance (additive coordinates) in this order:
///   t = (x m, y m, heading rad) of the vehicle when the map ended: base_T_next_base
///   c (kConstant) or c_s, c_e (kBorders), rad in [-pi, pi)
///   landmarks, 3 each: x, y in the base frame, z absolute depth, m
///   in a map that was joined: poses of other bases that loop closures claimed, 3 each as t (docs/math/closures.md C-10)
struct LevelledSubmap {
  int index = 0;
  double start_time_s = 0.0;
  double end_time_s = 0.0;
  std::string closed_because;
  CompassPorts compass = CompassPorts::kNone;
  std::optional<CompassMean> compass_mean;  ///< only with kNone
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
  std::vector<MapLandmark> landmarks;         ///< in the order of the state
  std::vector<std::vector<double>> seen_s{};  ///< when each landmark was, ascending; empty where nobody remembers
  std::vector<LevelledStep> steps;            ///< ascending time
  std::optional<BaseFix> start_fix{};         ///< of the base at which the map starts: only of the first map
  std::optional<BaseFix> exit_fix{};          ///< of the base at which it ends

  [[nodiscard]] static auto exit() { return Eigen::seqN(0, Eigen::fix<3>); }
  [[nodiscard]] Se2 base_T_exit() const { return Se2::from_vector(mean.head<3>()); }
  [[nodiscard]] Eigen::Index compass_rows() const {
    return compass == CompassPorts::kBorders ? 2 : compass == CompassPorts::kConstant ? 1 : 0;
  }
  [[nodiscard]] static Eigen::Index compass_offset() { return 3; }
  [[nodiscard]] std::vector<double> times_seen_s(Eigen::Index nth) const {
    return seen_s.empty() ? std::vector<double>{} : seen_s[static_cast<std::size_t>(nth)];
  }
  [[nodiscard]] Eigen::Index landmark_count() const { return static_cast<Eigen::Index>(landmarks.size()); }
  [[nodiscard]] Eigen::Index landmark_offset(Eigen::Index nth) const { return 3 + compass_rows() + 3 * nth; }
  [[nodiscard]] auto landmark(Eigen::Index nth) const { return Eigen::seqN(landmark_offset(nth), Eigen::fix<3>); }

  void archive(Archive& a) {
    a("index", index);
    a("start_time_s", start_time_s);
    a("end_time_s", end_time_s);
    a("closed_because", closed_because);
    a.choice("compass", compass, CompassPorts::kBorders);
    a("compass_mean", compass_mean);
    a("mean", mean);
    a("covariance", covariance);
    a("landmarks", landmarks);
    a("seen_s", seen_s);
    a("steps", steps);
    a("start_fix", start_fix);
    a("exit_fix", exit_fix);
    const Eigen::Index further = mean.size() - landmark_offset(landmark_count());
    a.require(further >= 0 && further % 3 == 0 && covariance.rows() == mean.size() && covariance.cols() == mean.size(),
              "has a mean, a covariance and landmarks that do not fit each other");
    for (const LevelledStep& step : steps) {
      a.require(step.gain.cols() >= 3 && step.gain.cols() <= mean.size(), "has a step with a gain of the wrong shape");
    }
    a.require(seen_s.empty() || seen_s.size() == landmarks.size(), "has sighting times of more or fewer landmarks than it has");
  }
};

}  // namespace ssjs
