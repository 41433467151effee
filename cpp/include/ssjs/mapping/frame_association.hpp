/// Which sighting of a camera frame is of which landmark of a levelled map: by the map, then by the looks, then jointly.
/// docs/math/camera.md (I-11..I-13), association.md.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "ssjs/association/hypothesis.hpp"
#include "ssjs/base/config_field.hpp"
#include "ssjs/filter/levelled_filter.hpp"
#include "ssjs/mapping/scan_association.hpp"
#include "ssjs/mapping/submap.hpp"
#include "ssjs/sensors/camera_frame.hpp"

namespace ssjs {

struct FrameAssociationConfig {
  double max_descriptor_distance = 0.35;
  double descriptor_ratio = 0.8;
  int new_per_frame = 12;
  int landmarks_in_view = 30;
  int max_landmarks = 60;
  double spacing_px = 20.0;
  int min_sightings = 3;
  int missed_frames = 3;
  double max_linearity = 0.1;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("max_descriptor_distance", max_descriptor_distance, Rule::positive(),
            "distance between the directions of two descriptors, a keypoint's and a landmark's, beyond which they are not one: 0 alike, "
            "1.41 nothing "
            "in common");
    v.field("descriptor_ratio", descriptor_ratio, Rule{0, 1, true, false},
            "of the landmarks that may be a keypoint's, the nearest by descriptor is the only one if the next is farther by this factor");
    v.field("new_per_frame", new_per_frame, Rule::not_negative(), "new landmarks of one frame at most");
    v.field("landmarks_in_view", landmarks_in_view, Rule::at_least(1), "no new landmarks while the frame shows so many");
    v.field("max_landmarks", max_landmarks, Rule::at_least(3),
            "a frame that would exceed so many landmarks closes the submap, in the place of split's max_landmarks where there is a camera");
    v.field("spacing_px", spacing_px, Rule::not_negative(),
            "least distance of a new landmark from the others in the frame, so that they spread");
    v.field("min_sightings", min_sightings, Rule::at_least(1), "landmarks seen in fewer frames are dropped as clutter");
    v.field("missed_frames", missed_frames, Rule::at_least(1), "... once so many frames in a row did not show them, or the submap ends");
    v.field("max_linearity", max_linearity, Rule::positive(),
            "linearity index below which a ray becomes a point; others end with the submap");
  }
};

/// Where the frame should show a landmark.
struct PredictedPixel {
  Eigen::Index landmark;
  Eigen::Vector2d pixel;
  StateRows rows;     ///< of the landmark; a residual of zero
  Eigen::Matrix2d S;  ///< covariance of the innovation
};

/// What a frame showed of a landmark beside what the map expected, both before the frame was used.
struct FrameSighting {
  double time_s = 0.0;
  int submap = 0;
  std::int64_t track = 0;  ///< of the landmark, see MapLandmark::tracks
  Eigen::Vector2d measured, predicted;
  Eigen::Matrix2d S;  ///< covariance of their difference
};

struct FrameAssociation {
  std::vector<PredictedPixel> predicted;  ///< landmarks of the camera that lie within the frame, ascending
  std::vector<Pair> pairs;                ///< observation = sighting, prediction = place in `predicted`
  std::vector<Eigen::Index> fresh;        ///< sightings that become new landmarks
  int refused = 0;                        ///< pairs that their gates or the joint gate of the frame did not let through
  int wrong_pairs = 0;                    ///< pairs whose source identities differ, where both are known
  bool budget_exhausted = false;
};

/// Each landmark's pixel with the covariance that the map gives it decides which sightings can be it (`camera.gate_probability`); among
/// them the descriptors, where both have one; among what is left joint compatibility. kKnown pairs by identity, inside the same gate.
[[nodiscard]] FrameAssociation associate_frame(const CameraFrame& frame, const LevelledFilter& filter,
                                               const std::vector<MapLandmark>& landmarks, const PinholeCamera& camera,
                                               const CameraConfig& of_camera, const FrameAssociationConfig& config,
                                               const ScanAssociationConfig& method);

}  // namespace ssjs
