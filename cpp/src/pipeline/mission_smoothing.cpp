#include "ssjs/pipeline/mission_smoothing.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <map>
#include <utility>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

/// Standard deviation (m, rad) added where the noise of a motion leaves a direction exactly known: a single command without side slip.
/// (B-12)
constexpr double kLeastMotionSigma = 1e-5;

Eigen::Matrix3d positive_definite(const Eigen::Matrix3d& covariance) {
  constexpr double kLeastVariance = kLeastMotionSigma * kLeastMotionSigma;
  if (covariance.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff() > kLeastVariance) return covariance;
  return covariance + kLeastVariance * Eigen::Matrix3d::Identity();
}

/// One entry for every known identity: its surest copy. Says what became of every track.
std::map<std::int64_t, int> merge_known(std::vector<LandmarkEstimate>& landmarks, bool identities_known) {
  std::vector<LandmarkEstimate> kept;
  std::map<std::int64_t, std::size_t> place_of;
  std::map<std::int64_t, int> landmark_of_track;
  for (LandmarkEstimate& landmark : landmarks) {
    std::size_t place = kept.size();
    const std::vector<std::int64_t> tracks = landmark.landmark.tracks;
    if (identities_known && landmark.landmark.source_id) place = place_of.emplace(*landmark.landmark.source_id, place).first->second;
    if (place == kept.size()) {
      kept.push_back(std::move(landmark));
    } else {
      LandmarkEstimate& same = kept[place];
      same.landmark.take(landmark.landmark);
      if (landmark.position.covariance.trace() < same.position.covariance.trace()) {
        same.position = landmark.position;
        same.base = landmark.base;
      }
    }
    for (const std::int64_t track : tracks) landmark_of_track[track] = static_cast<int>(place);
  }
  landmarks = std::move(kept);
  return landmark_of_track;
}

}  // namespace

MissionSmoothing::MissionSmoothing(const SlamConfig& config) : config_(config), motion_(config.vehicle) {}

void MissionSmoothing::feed(const Event& event, const std::optional<ScanResult>& scan) {
  motion_.take(event);
  Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
  if (const auto& increment = motion_.increment()) {
    const MotionPrediction motion = predict_increment(pose_T_vehicle_.mean, *increment);
    F = motion.F;
    pose_T_vehicle_ = {motion.submap_T_vehicle, F * pose_T_vehicle_.covariance * F.transpose() + motion.Q};  // (B-11)
  }
  transitions_.push_back(F);
  SubmapStep step;
  step.time_s = event.time_s;
  step.base_T_vehicle = pose_T_vehicle_.mean;
  step.covariance = step.conditional_covariance = pose_T_vehicle_.covariance;
  step.exit_gain.setZero();
  steps_.push_back(step);

  const bool is_needed = std::holds_alternative<OdometryIncrement>(event.record) || (scan && !scan->used.empty());
  const bool stands = pose_T_vehicle_.covariance.isZero(0.0) && pose_T_vehicle_.mean.vector().isZero(0.0);
  if (is_needed && !stands) begin_pose();
  if (!scan) return;
  for (const UsedObservation& observation : scan->used) sightings_.push_back({static_cast<int>(motions_.size()), observation});
}

/// The last step becomes a pose of the problem; the steps since the pose before are conditioned on it (B-13).
void MissionSmoothing::begin_pose() {
  const auto from = static_cast<int>(motions_.size());
  const Eigen::Matrix3d P = positive_definite(pose_T_vehicle_.covariance);
  motions_.push_back({from, from + 1, {pose_T_vehicle_.mean, P}});
  const Eigen::LLT<Eigen::Matrix3d> llt(P);
  Eigen::Matrix3d A = transitions_.back();
  for (std::size_t i = steps_.size() - 1; i-- > first_step_.back(); A = A * transitions_[i]) {
    SubmapStep& step = steps_[i];
    const Eigen::Matrix3d A_P = A * step.covariance;
    step.exit_gain = llt.solve(A_P).transpose();
    step.conditional_covariance = step.covariance - step.exit_gain * A_P;
  }
  first_step_.push_back(steps_.size() - 1);
  pose_T_vehicle_ = {};
  SubmapStep& here = steps_.back();
  here.base_T_vehicle = {};
  here.covariance.setZero();
  here.conditional_covariance.setZero();
}

SmoothingProblem MissionSmoothing::problem(const std::vector<TrajectoryPoint>& trajectory, std::vector<LandmarkEstimate>& landmarks) const {
  SmoothingProblem problem;
  problem.poses.push_back({});  // where the mission begins is the global frame
  for (std::size_t k = 1; k < first_step_.size(); ++k) problem.poses.push_back(trajectory.at(first_step_[k]).global_T_vehicle.mean);
  problem.motions = motions_;
  const std::map<std::int64_t, int> landmark_of_track = merge_known(landmarks, config_.association.method == AssociationMethod::kKnown);
  for (const LandmarkEstimate& landmark : landmarks) problem.landmarks.push_back(landmark.position.mean);
  std::vector<bool> is_seen(landmarks.size(), false);
  for (const Sighting& sighting : sightings_) {
    const auto found = landmark_of_track.find(sighting.observation.track);
    if (found == landmark_of_track.end()) continue;  // of a tentative landmark that was given up
    const Feature& feature = sighting.observation.feature;
    problem.sightings.push_back({sighting.pose, found->second, feature.range_bearing, feature.covariance});
    is_seen[static_cast<std::size_t>(found->second)] = true;
  }
  for (const bool seen : is_seen) {
    if (!seen) throw InvalidArgument("smoothing.enabled", "true", "this method does not say which observations its landmarks were made of");
  }
  return problem;
}

SmoothedMission MissionSmoothing::smooth(const std::vector<TrajectoryPoint>& trajectory, std::vector<LandmarkEstimate> landmarks) const {
  Smoother smoother(problem(trajectory, landmarks), config_.smoothing);
  SmoothedMission smoothed;
  smoothed.report = smoother.optimize();
  if (config_.smoothing.covariance) smoother.find_covariances();
  smoothed.trajectory = between(smoother, trajectory);
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    landmarks[i].position.mean = smoother.landmarks()[i];
    if (config_.smoothing.covariance) landmarks[i].position.covariance = smoother.landmark_covariance(static_cast<int>(i));
  }
  smoothed.landmarks = std::move(landmarks);
  return smoothed;
}

/// Every event between two poses of the problem (B-13), and those after the last one (B-14).
std::vector<TrajectoryPoint> MissionSmoothing::between(const Smoother& smoother, const std::vector<TrajectoryPoint>& before) const {
  const bool with_covariance = config_.smoothing.covariance;
  const auto poses = static_cast<int>(first_step_.size());
  std::vector<TrajectoryPoint> trajectory;
  for (int pose = 0; pose < poses; ++pose) {
    const bool is_last = pose + 1 == poses;
    const auto k = static_cast<std::size_t>(pose);
    const Se2& global_T_pose = smoother.poses()[k];
    const std::size_t end = is_last ? steps_.size() : first_step_[k + 1];
    RelativePose exit;
    Eigen::Vector3d shift = Eigen::Vector3d::Zero();
    Matrix6d P = Matrix6d::Zero();
    if (!is_last) {
      exit = relative_pose(global_T_pose, smoother.poses()[k + 1]);
      shift = additive_difference(exit.i_T_j, motions_[k].from_T_to.mean);
      if (with_covariance) P = smoother.joint_covariance(pose, pose + 1);
    }
    for (std::size_t i = first_step_[k]; i < end; ++i) {
      const SubmapStep& step = steps_[i];
      GaussianSe2 at_step;
      if (is_last) {
        const Eigen::Matrix3d P_last = with_covariance ? smoother.pose_covariance(pose) : Eigen::Matrix3d::Zero();
        at_step = compose_independent({global_T_pose, P_last}, {step.base_T_vehicle, step.covariance});
      } else {
        at_step = between_borders(step, global_T_pose, exit, shift, P);
      }
      if (!with_covariance) at_step.covariance = before.at(i).global_T_vehicle.covariance;
      trajectory.push_back({step.time_s, at_step});
    }
  }
  return trajectory;
}

}  // namespace ssjs
