// What a LevelledBuilder does with the frames of a camera. docs/math/camera.md (I-8..I-14).
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "ssjs/mapping/levelled_builder.hpp"

namespace ssjs {
namespace {

using Layout = VehicleLayout;

constexpr double kMostTiltSigma = 0.1;  // rad: a direction known worse gives no ray

std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

}  // namespace

/// The pairs of the frame become rows of the tick's update.
void LevelledBuilder::gate_frame(const CameraFrame& frame, TickResult& result) {
  statistics_[at(static_cast<Eigen::Index>(NavigationSensor::kCamera))].refused += frame_->refused;
  result.refused += frame_->refused;
  for (const Pair& pair : frame_->pairs) {
    const PredictedPixel& predicted = frame_->predicted[at(pair.prediction)];
    const CameraSighting& sighting = frame.sightings[at(pair.observation)];
    MapLandmark& landmark = landmarks_[at(predicted.landmark)];
    const Eigen::Vector2d residual = sighting.pixel - predicted.pixel;
    StateRows block = predicted.rows;
    block.vehicle.residual = residual;
    gated_.distances.push_back(residual.dot(predicted.S.llt().solve(residual)));
    gated_.sensors.push_back(NavigationSensor::kCamera);
    gated_.rows.push_back(std::move(block));
    result.frame.push_back({time_s_, index_, landmark.tracks.front(), sighting.pixel, predicted.pixel, predicted.S});
    ++landmark.times_seen;
    if (landmark.descriptor.size() == 0) {
      landmark.descriptor = sighting.descriptor;
    } else if (sighting.descriptor.size() > 0) {
      landmark.descriptor += (sighting.descriptor - landmark.descriptor) / static_cast<float>(landmark.times_seen);
    }
    seen_.push_back({predicted.landmark, time_s_});
  }
  for (int& missed : missed_) ++missed;
  for (const Pair& pair : frame_->pairs) missed_[at(frame_->predicted[at(pair.prediction)].landmark)] = 0;
}

/// The distance of a new ray is that of the seabed: before the vehicle is level and knows its altitude there is none. (I-5)
bool LevelledBuilder::knows_seabed() const {
  const VehicleVector x = filter_.vehicle();
  const VehicleMatrix P = filter_.vehicle_covariance();
  constexpr Eigen::Index kDepth = Layout::kPosition + 2;
  const double height_m = x(Layout::kSeabed) - x(kDepth);
  const double variance = P(Layout::kSeabed, Layout::kSeabed) + P(kDepth, kDepth) - 2.0 * P(Layout::kSeabed, kDepth);
  const double tilt_variance = std::max(P(Layout::kAttitude, Layout::kAttitude), P(Layout::kAttitude + 1, Layout::kAttitude + 1));
  return height_m > 0.0 && std::sqrt(std::max(variance, 0.0)) <= config_.camera.relief * height_m &&
         tilt_variance <= kMostTiltSigma * kMostTiltSigma;
}

void LevelledBuilder::add_rays(const CameraFrame& frame, TickResult& result) {
  if (!knows_seabed()) return;
  for (const Eigen::Index i : frame_->fresh) {
    const std::optional<int>& most = config_.split.policy.max_landmarks;
    if (most && static_cast<int>(landmarks_.size()) > config_.camera_association.max_landmarks)
      return;  // full: closed at the next velocity
    const CameraSighting& sighting = frame.sightings[at(i)];
    const std::optional<NewRay> ray = ray_from_pixel(filter_.vehicle(), sighting.pixel, *camera_, config_.camera);
    if (!ray) continue;
    filter_.add_landmark(*ray);
    landmarks_.push_back({1, sighting.landmark_id, {tracks_++}, true, sighting.descriptor});
    missed_.push_back(0);
    seen_.push_back({filter_.landmarks() - 1, time_s_});
    ++result.added;
  }
}

bool LevelledBuilder::is_point(Eigen::Index ray) const {
  const InverseDepth y = filter_.ray(ray);
  if (!(y(5) > 0.0)) return false;
  const Eigen::Vector3d map_p_camera = map_T_vehicle(filter_.vehicle()) * vehicle_T_camera(config_.camera).translation;
  return linearity_index(y, filter_.inverse_depth_sigma(ray), map_p_camera) < config_.camera_association.max_linearity;  // (I-7)
}

/// After a frame: rays that are as good as points become points; what was seen too seldom and is seen no more goes, and a point behind
/// infinity.
void LevelledBuilder::settle_rays() {
  for (Eigen::Index i = filter_.landmarks(); i-- > 0;) {
    const MapLandmark& landmark = landmarks_[at(i)];
    if (!landmark.of_camera) continue;
    const bool is_clutter =
        landmark.times_seen < config_.camera_association.min_sightings && missed_[at(i)] >= config_.camera_association.missed_frames;
    if (is_clutter || (filter_.is_ray(i) && !(filter_.ray(i)(5) > 0.0))) {
      drop_landmark(i);
    } else if (filter_.is_ray(i) && is_point(i)) {
      filter_.convert_to_point(i);
    }
  }
}

/// No ray crosses the border of a map, and no clutter. (I-14)
void LevelledBuilder::settle_map() {
  for (Eigen::Index i = filter_.landmarks(); i-- > 0;) {
    if (!landmarks_[at(i)].of_camera) continue;
    if (landmarks_[at(i)].times_seen < config_.camera_association.min_sightings || (filter_.is_ray(i) && !is_point(i))) {
      drop_landmark(i);
    } else if (filter_.is_ray(i)) {
      filter_.convert_to_point(i);
    }
  }
}

void LevelledBuilder::drop_landmark(Eigen::Index landmark) {
  filter_.drop_landmark(landmark);
  landmarks_.erase(landmarks_.begin() + landmark);
  missed_.erase(missed_.begin() + landmark);
  seen_.erase(std::remove_if(seen_.begin(), seen_.end(), [&](const Seen& seen) { return seen.landmark == landmark; }), seen_.end());
  for (Seen& seen : seen_) {
    if (seen.landmark > landmark) --seen.landmark;
  }
}

}  // namespace ssjs
