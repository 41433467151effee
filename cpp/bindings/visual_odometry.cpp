// Planar motion from frames alone: tracks of keypoints, lengths of pixels, increments, frames that may show the same ground.
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <array>
#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

#include "columns.hpp"
#include "config.hpp"
#include "parts.hpp"
#include "ssjs/optical/keypoint_tracks.hpp"
#include "ssjs/optical/mosaic_points.hpp"
#include "ssjs/survey/frame_overlap.hpp"
#include "ssjs/survey/ground_projection.hpp"
#include "ssjs/survey/visual_odometry.hpp"

namespace ssjs::bindings {
namespace {

using PointRows = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

enum class LandmarkSource { kKeypoints, kMosaicPoints };

/// What becomes a landmark of a survey with frames alone.
struct FrameLandmarkConfig {
  LandmarkSource landmarks = LandmarkSource::kKeypoints;
  int landmarks_per_frame = 10;
  int mosaic_points = 1000;
  double least_range = 0.12;
  bool estimate_lens = true;
  int rounds = 5;
  template <class Visitor>
  void visit(Visitor& v) {
    v.choice("landmarks", landmarks,
             Choices<LandmarkSource>{{"keypoints", LandmarkSource::kKeypoints}, {"mosaic-points", LandmarkSource::kMosaicPoints}},
             "keypoints that are met again; or random points of the mosaic, referred back to the frames by their registrations");
    v.field("landmarks_per_frame", landmarks_per_frame, Rule::at_least(3), "keypoints followed as landmarks, about so many a frame");
    v.field("mosaic_points", mosaic_points, Rule::at_least(3), "random points of the mosaic");
    v.field("least_range", least_range, Rule::open(0, 0.4),
            "points nearer than this part of the frame's width to its middle are left out: their bearing says nothing");
    v.field("estimate_lens", estimate_lens, "the radial lens of a camera without a calibration, from its frames");
    v.field("rounds", rounds, Rule::at_least(1), "times that the track is estimated and looked along for frames that show the same ground");
  }
};

/// Keys as a configuration file of the command line has them, beside those of the frames.
struct VisualOdometrySettings {
  VisualOdometryConfig odometry;
  FrameOverlapConfig overlap;
  FrameLandmarkConfig landmarks;
  template <class Visitor>
  void visit(Visitor& v) {
    v.section("frames", odometry, "motion from frames alone");
    v.section("frames", overlap, "frames that may show the same ground");
    v.section("frames", landmarks, "landmarks from frames alone");
  }
};

VisualOdometrySettings checked_settings(const py::dict& values) {
  auto settings = config_from<VisualOdometrySettings>(values);
  throw_if_any(violations(settings));
  return settings;
}

VisualOdometryConfig checked_config(const py::dict& values) { return checked_settings(values).odometry; }

cv::Matx33d homography_from(const Eigen::Matrix3d& H) {
  return {H(0, 0), H(0, 1), H(0, 2), H(1, 0), H(1, 1), H(1, 2), H(2, 0), H(2, 1), H(2, 2)};
}

py::dict mosaic_point_table(const std::vector<Eigen::Matrix3d>& map_H_frame, int width_px, int height_px,
                            const std::vector<std::tuple<int, int, Eigen::Matrix3d>>& links, int count, std::uint64_t seed) {
  std::vector<cv::Matx33d> placed;
  for (const Eigen::Matrix3d& H : map_H_frame) placed.push_back(homography_from(H));
  std::vector<FrameHomography> registered;
  for (const auto& [first, second, H] : links) registered.push_back({first, second, homography_from(H)});
  const std::vector<MosaicPointSighting> sightings = mosaic_points(placed, {width_px, height_px}, registered, count, seed);
  PointRows pixel(static_cast<Eigen::Index>(sightings.size()), 2);
  std::vector<std::int64_t> frame, point;
  for (const MosaicPointSighting& sighting : sightings) {
    pixel.row(static_cast<Eigen::Index>(frame.size())) << sighting.pixel.x, sighting.pixel.y;
    frame.push_back(sighting.frame);
    point.push_back(sighting.point);
  }
  py::dict table;
  table["frame"] = array_of(frame);
  table["point"] = array_of(point);
  table["pixel"] = pixel;
  return table;
}

py::object ground_homography(const Vector6d& pose, double ground_depth_m, const py::dict& camera, const py::dict& mount) {
  const auto number = [&](const char* key) { return camera[key].cast<double>(); };
  const PinholeCamera pinhole{camera["width_px"].cast<int>(), camera["height_px"].cast<int>(), number("focal_x_px"),
                              number("focal_y_px"),           number("centre_x_px"),           number("centre_y_px")};
  const auto H = ground_H_frame(Se3::from_vector(pose), ground_depth_m, pinhole, config_from<CameraConfig>(mount));
  return H ? py::cast(Eigen::Matrix3d(*H)) : py::none();
}

/// Frames (first, second) and their matched pixels (n, 2) in whole-frame coordinates -> columns from the middle of the frame.
std::vector<MatchedFrames> matched_frames(const std::vector<std::tuple<int, int, PointRows, PointRows>>& pairs, int frames, int width_px,
                                          int height_px) {
  const Eigen::Vector2d middle(0.5 * (width_px - 1), 0.5 * (height_px - 1));
  std::vector<MatchedFrames> matched;
  for (const auto& [first, second, first_px, second_px] : pairs) {
    if (first < 0 || second < 0 || first >= frames || second >= frames || first == second) {
      throw InvalidArgument("pairs", second, "must be of two of the frames");
    }
    if (first_px.rows() != second_px.rows()) {
      throw InvalidArgument("second_px", static_cast<int>(second_px.rows()), "must be as many as in the first");
    }
    matched.push_back({first, second, first_px.transpose().colwise() - middle, second_px.transpose().colwise() - middle});
  }
  return matched;
}

py::dict increments_table(const std::vector<GaussianSe2>& increments, const std::vector<std::optional<GaussianSe2>>& motions) {
  const auto n = static_cast<Eigen::Index>(increments.size());
  RowMatrix motion(n, 3), covariance(n, 6);
  std::vector<bool> registered;
  for (Eigen::Index i = 0; i < n; ++i) {
    const GaussianSe2& increment = increments[static_cast<std::size_t>(i)];
    const Eigen::Matrix3d& P = increment.covariance;
    motion.row(i) = increment.mean.vector();
    covariance.row(i) << P(0, 0), P(0, 1), P(0, 2), P(1, 1), P(1, 2), P(2, 2);
    registered.push_back(motions[static_cast<std::size_t>(i)].has_value());
  }
  py::dict table;
  table["motion"] = motion;
  table["covariance"] = covariance;
  table["registered"] = registered;
  return table;
}

}  // namespace

void add_visual_odometry(py::module_& module) {
  module.def(
      "visual_odometry_fields", [] { return fields_of<VisualOdometrySettings>(); },
      "Settings of the motion from frames alone, as config_fields() lists those of the estimator.");
  module.def(
      "validate_visual_odometry", [](const py::dict& values) { return violations(config_from<VisualOdometrySettings>(values)); },
      py::arg("values"), "Every violation of them, as text; unknown keys raise ValueError.");
  module.def(
      "keypoint_tracks",
      [](const std::vector<int>& counts, const std::vector<std::tuple<int, int, std::vector<std::array<int, 2>>>>& links) {
        std::vector<FrameLink> matched;
        for (const auto& [first, second, rows] : links) matched.push_back({first, second, rows});
        return keypoint_tracks(counts, matched);
      },
      py::arg("counts"), py::arg("links"),
      "By frame and keypoint the number of its track, -1 where it has none. links: (first, second, rows).");
  module.def(
      "overlapping_frames",
      [](const py::dict& config, const Eigen::MatrixX3d& pose, const Eigen::VectorXd& variance, double frame_width) {
        return overlapping_frames(pose, variance, frame_width, checked_settings(config).overlap);
      },
      py::arg("config"), py::arg("pose"), py::arg("variance"), py::arg("frame_width"),
      "Pairs (earlier, later) of frames that may show the same ground. pose: (n, 3); variance: (n,) of the position in all.");
  module.def("mosaic_points", &mosaic_point_table, py::arg("map_H_frame"), py::arg("width_px"), py::arg("height_px"), py::arg("links"),
             py::arg("count"), py::arg("seed") = 1,
             "Random points of the mosaic in the frames: frame, point, pixel. links: (first, second, second_H_first).");
  module.def("ground_homography", &ground_homography, py::arg("pose"), py::arg("ground_depth_m"), py::arg("camera"), py::arg("mount"),
             "Pixels of the corrected frame -> (x, y) of level ground. pose: x, y, z, roll, pitch, yaw; mount: settings of [camera].");
  module.def("chosen_tracks", &chosen_tracks, py::arg("tracks"), py::arg("per_frame"), "The tracks over most frames, so many a frame.");
  module.def(
      "pixel_lengths",
      [](const py::dict& config, int frames, const std::vector<std::tuple<int, int, PointRows, PointRows>>& pairs, int width_px,
         int height_px) {
        return pixel_lengths(frames, matched_frames(pairs, frames, width_px, height_px), width_px, checked_config(config));
      },
      py::arg("config"), py::arg("frames"), py::arg("pairs"), py::arg("width_px"), py::arg("height_px"),
      "Length of a pixel of every frame on the ground. pairs: (first, second, first_px (n, 2), second_px (n, 2)), lens corrected.");
  module.def(
      "frame_increments",
      [](const py::dict& config, const Eigen::VectorXd& time_s, const Eigen::VectorXd& pixel_length,
         const std::vector<std::tuple<int, int, PointRows, PointRows>>& pairs, int width_px, int height_px) {
        const VisualOdometryConfig odometry = checked_config(config);
        const auto frames = static_cast<int>(time_s.size());
        if (frames < 2 || pixel_length.size() != time_s.size()) {
          throw InvalidArgument("pixel_length", static_cast<int>(pixel_length.size()), "must be one for each of two frames or more");
        }
        std::vector<std::optional<GaussianSe2>> motions(static_cast<std::size_t>(frames) - 1);
        for (const MatchedFrames& pair : matched_frames(pairs, frames, width_px, height_px)) {
          if (pair.second != pair.first + 1) throw InvalidArgument("pairs", pair.second, "must be of frames that follow each other");
          motions[static_cast<std::size_t>(pair.first)] = frame_motion(pair, pixel_length, odometry);
        }
        return increments_table(bridged(motions, time_s, odometry), motions);
      },
      py::arg("config"), py::arg("time_s"), py::arg("pixel_length"), py::arg("pairs"), py::arg("width_px"), py::arg("height_px"),
      "motion (n - 1, 3), covariance (n - 1, 6) and whether it was registered, from every frame to the next.");
}

}  // namespace ssjs::bindings
