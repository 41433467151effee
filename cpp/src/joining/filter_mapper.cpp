#include "ssjs/joining/filter_mapper.hpp"

#include <utility>

namespace ssjs {

FilterMapper::FilterMapper(const SubmapBuilderConfig& config, const ScanAssociationConfig& association, std::uint64_t seed,
                           StateLayout layout)
    : map_(config, association, seed, ErrorForm::kAdditive, layout) {}

void FilterMapper::touch(double time_s) {
  if (!started_) start_time_s_ = time_s;
  started_ = true;
  time_s_ = time_s;
}

void FilterMapper::predict(double time_s, const MotionPrediction& motion) {
  touch(time_s);
  map_.predict(motion);
}

void FilterMapper::record_step(double time_s) {
  touch(time_s);
  const Eigen::Matrix3d covariance = map_.filter().vehicle_covariance();
  steps_.push_back({time_s, map_.filter().vehicle_pose(), covariance, Eigen::Matrix3d::Zero(), covariance});
}

void FilterMapper::close(const std::string& reason, MapState state, std::vector<MapLandmark> landmarks) {
  Submap submap;
  submap.index = static_cast<int>(submaps_.size());
  submap.start_time_s = start_time_s_;
  submap.end_time_s = time_s_;
  submap.closed_because = reason;
  submap.state = std::move(state);
  submap.landmarks = std::move(landmarks);
  submap.steps = std::exchange(steps_, {});
  submap.steps_are_global = true;
  submaps_.push_back(std::move(submap));
  start_time_s_ = time_s_;
}

void FilterMapper::close_last(MapState state, std::vector<MapLandmark> landmarks) {
  close("end of the mission", std::move(state), std::move(landmarks));
  finished_ = true;
}

WorldEstimate single_map_estimate(const MapState& state, const std::vector<MapLandmark>& landmarks, BaseCovariance covariance) {
  WorldEstimate world;
  const GaussianSe2 vehicle = state.vehicle();
  world.global_T_base = {Se2{}, vehicle.mean};
  world.border_covariance.assign(1, Matrix6d::Zero());
  world.border_covariance[0].bottomRightCorner<3, 3>() = vehicle.covariance;
  if (covariance == BaseCovariance::kJoint) world.base_covariance = world.border_covariance[0];
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    world.landmarks.push_back({state.landmark(static_cast<Eigen::Index>(i)), landmarks[i], 0});
  }
  world.maps = {{0, {0}, static_cast<int>(landmarks.size())}};
  return world;
}

}  // namespace ssjs
