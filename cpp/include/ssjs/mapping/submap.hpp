/// A finished local map: immutable, in its own base frame. docs/math/submaps.md.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "ssjs/base/archive.hpp"
#include "ssjs/filter/map_state.hpp"
#include "ssjs/sensors/camera_frame.hpp"

namespace ssjs {

struct MapLandmark {
  int times_seen = 0;
  std::optional<std::int64_t> source_id;  ///< identity given by the source of its first sighting, where it gives one
  std::vector<std::int64_t> tracks{};     ///< every track of observations that was found to be this landmark
  bool of_camera = false;                 ///< seen by the camera; the sonar's are others
  Descriptor descriptor{};                ///< of a camera's: what it looks like, the mean of its sightings; empty: not known

  void archive(Archive& a) {
    a("times_seen", times_seen);
    a("source_id", source_id);
    a("tracks", tracks);
    a("of_camera", of_camera);
    archive_descriptor(a, descriptor);
  }

  /// `other` was found to be the same landmark.
  void take(const MapLandmark& other) {
    times_seen += other.times_seen;
    tracks.insert(tracks.end(), other.tracks.begin(), other.tracks.end());
    if (descriptor.size() == 0) descriptor = other.descriptor;
  }
};

/// The vehicle at one fed event. Given the true exit pose s of the submap, the pose is
/// base_T_vehicle + exit_gain * (s - exit estimate) with covariance conditional_covariance (C-4).
struct SubmapStep {
  double time_s = 0.0;
  Se2 base_T_vehicle;          ///< the filter's estimate at that time
  Eigen::Matrix3d covariance;  ///< of that estimate
  Eigen::Matrix3d exit_gain;
  Eigen::Matrix3d conditional_covariance;
};

struct Submap {
  int index = 0;
  double start_time_s = 0.0;
  double end_time_s = 0.0;
  std::string closed_because;
  MapState state;                      ///< vehicle block = exit pose, base_T_next_base
  std::vector<MapLandmark> landmarks;  ///< in the order of the state
  std::vector<SubmapStep> steps;
  /// The steps are in the world frame, as filtered (a method with one frame for all): base_T_vehicle is global_T_vehicle, with
  /// `covariance`.
  bool steps_are_global = false;
};

}  // namespace ssjs
