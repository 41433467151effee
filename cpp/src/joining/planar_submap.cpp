#include "ssjs/joining/planar_submap.hpp"

namespace ssjs {

Submap planar_submap_of(const LevelledSubmap& submap, std::int64_t first_track) {
  std::vector<Eigen::Index> kept{0, 1, 2};
  for (Eigen::Index i = 0; i < submap.landmark_count(); ++i) {
    kept.push_back(submap.landmark_offset(i));
    kept.push_back(submap.landmark_offset(i) + 1);
  }
  Submap planar;
  planar.index = submap.index;
  planar.start_time_s = submap.start_time_s;
  planar.end_time_s = submap.end_time_s;
  planar.closed_because = submap.closed_because;
  planar.state.mean = submap.mean(kept);  // (U-1)
  planar.state.covariance = submap.covariance(kept, kept);
  for (const MapLandmark& landmark : submap.landmarks) {
    planar.landmarks.push_back({landmark.times_seen, landmark.source_id, {first_track++}, landmark.of_camera, landmark.descriptor});
  }
  return planar;
}

}  // namespace ssjs
