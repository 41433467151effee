// Frames of a down-looking camera: lens, regions of interest, keypoints, registration.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "config.hpp"
#include "frame_arrays.hpp"
#include "parts.hpp"
#include "region_tables.hpp"
#include "ssjs/optical/frame_reader.hpp"
#include "ssjs/optical/lens_estimate.hpp"

namespace ssjs::bindings {
namespace {

/// Keys as a configuration file of the command line has them.
struct FrameSettings {
  FrameReaderConfig reader;
  MatchingConfig matching;
  template <class Visitor>
  void visit(Visitor& v) {
    v.section("frames", reader, "from frame to keypoints");
    v.section("matching", matching, "the same keypoints in two frames");
  }
};

std::optional<CameraCalibration> calibration_from(const std::optional<py::dict>& values) {
  if (!values) return std::nullopt;
  const auto number = [&](const char* key) { return (*values)[key].cast<double>(); };
  CameraCalibration calibration;
  calibration.camera = {(*values)["width_px"].cast<int>(),
                        (*values)["height_px"].cast<int>(),
                        number("focal_x_px"),
                        number("focal_y_px"),
                        number("centre_x_px"),
                        number("centre_y_px")};
  calibration.skew_px = number("skew_px");
  const auto lens = (*values)["lens"].cast<std::string>();
  const std::vector<std::pair<std::string, LensModel>> lenses = {
      {"pinhole", LensModel::kPinhole}, {"brown", LensModel::kBrown}, {"equidistant", LensModel::kEquidistant}};
  const auto known = std::find_if(lenses.begin(), lenses.end(), [&](const auto& entry) { return entry.first == lens; });
  if (known == lenses.end()) throw InvalidArgument("lens", lens, "must be pinhole, brown or equidistant");
  calibration.lens = known->second;
  const auto distortion = (*values)["distortion"].cast<std::vector<double>>();
  if (distortion.size() > calibration.distortion.size()) {
    throw InvalidArgument("distortion", static_cast<int>(distortion.size()), "at most five coefficients");
  }
  std::copy(distortion.begin(), distortion.end(), calibration.distortion.begin());
  return calibration;
}

py::dict calibration_table(const CameraCalibration& calibration) {
  py::dict table;
  table["width_px"] = calibration.camera.width_px;
  table["height_px"] = calibration.camera.height_px;
  table["focal_x_px"] = calibration.camera.focal_x_px;
  table["focal_y_px"] = calibration.camera.focal_y_px;
  table["centre_x_px"] = calibration.camera.centre_x_px;
  table["centre_y_px"] = calibration.camera.centre_y_px;
  table["skew_px"] = calibration.skew_px;
  table["lens"] = calibration.lens == LensModel::kPinhole ? "pinhole" : calibration.lens == LensModel::kBrown ? "brown" : "equidistant";
  table["distortion"] = std::vector<double>(calibration.distortion.begin(), calibration.distortion.end());
  return table;
}

using PixelRows = py::array_t<double, py::array::c_style | py::array::forcecast>;

std::vector<cv::Point2d> pixels_from(const PixelRows& array, const char* name) {
  if (array.ndim() != 2 || array.shape(1) != 2) throw InvalidArgument(name, array_text(array), "must be of shape (n, 2)");
  std::vector<cv::Point2d> pixels;
  for (py::ssize_t i = 0; i < array.shape(0); ++i) pixels.emplace_back(array.at(i, 0), array.at(i, 1));
  return pixels;
}

py::object lens_estimate(const std::vector<std::pair<PixelRows, PixelRows>>& pairs, int width_px, int height_px, double tolerance_px) {
  std::vector<MatchedPixels> matched;
  for (const auto& [first, second] : pairs) matched.push_back({pixels_from(first, "first_px"), pixels_from(second, "second_px")});
  std::optional<LensEstimate> found;
  {
    const py::gil_scoped_release release;
    found = estimate_lens(matched, {width_px, height_px}, tolerance_px);
  }
  if (!found) return py::none();
  py::dict table;
  table["calibration"] = calibration_table(found->calibration);
  table["rms_before_px"] = found->rms_before_px;
  table["rms_after_px"] = found->rms_after_px;
  return table;
}

py::array through_lens(const PixelRows& array, const py::dict& calibration, bool backwards) {
  const CameraCalibration lens = *calibration_from(calibration);
  std::vector<cv::Point2d> pixels = pixels_from(array, "pixel");
  for (cv::Point2d& p : pixels) p = backwards ? undistorted(lens, p) : distorted(lens, p);
  return rows<double, 2>(pixels, [](const cv::Point2d& p) { return xy(p); });
}

py::dict keypoint_table(const FrameFeatures& features) {
  const std::vector<Keypoint>& points = features.keypoints.points;
  py::dict table;
  table["position_px"] = rows<double, 2>(points, [](const Keypoint& keypoint) { return xy(keypoint.position_px); });
  table["scale_px"] = column<double>(points, [](const Keypoint& keypoint) { return keypoint.scale_px; });
  table["angle_rad"] = column<double>(points, [](const Keypoint& keypoint) { return keypoint.angle_rad; });
  table["response"] = column<double>(points, [](const Keypoint& keypoint) { return keypoint.response; });
  table["region"] = column<int>(features.region_of, [](int label) { return label; });
  return table;
}

/// One row a keypoint. ORB's bits become numbers: their squared distance is the number of bits that differ.
py::array_t<float> descriptor_rows(const FrameFeatures& features) {
  const cv::Mat& descriptors = features.keypoints.descriptors;
  const bool is_bits = descriptors.depth() == CV_8U;
  const int columns = is_bits ? 8 * descriptors.cols : descriptors.cols;
  py::array_t<float> array({descriptors.rows, columns});
  for (int r = 0; r < descriptors.rows; ++r) {
    float* to = array.mutable_data(r, 0);
    if (!is_bits) {
      std::copy_n(descriptors.ptr<float>(r), columns, to);
      continue;
    }
    const unsigned char* bytes = descriptors.ptr(r);
    for (int c = 0; c < columns; ++c) to[c] = ((bytes[c / 8] >> (c % 8)) & 1) != 0 ? 1.0F : 0.0F;
  }
  return array;
}

py::dict frame_regions(const FrameFeatures& features) {
  const std::vector<Region>& regions = features.regions;
  py::dict table;
  table["area_px"] = column<std::int64_t>(regions, [](const Region& region) { return region.area_px; });
  table["centroid_px"] = rows<double, 2>(regions, [](const Region& region) { return xy(region.centroid_px); });
  table["bounding_box_px"] = rows<int, 4>(regions, [](const Region& region) { return xywh(region.bounding_box); });
  return table;
}

py::dict registration_table(const Registration& found) {
  py::array_t<double> homography({3, 3});
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) homography.mutable_at(r, c) = found.second_H_first(r, c);
  }
  py::dict table;
  table["scale"] = found.second_T_first.scale;
  table["angle_rad"] = found.second_T_first.angle_rad;
  table["shift_px"] = py::make_tuple(found.second_T_first.shift_px.x, found.second_T_first.shift_px.y);
  table["second_H_first"] = homography;
  table["inliers"] = rows<int, 2>(found.inliers, [](const KeypointMatch& match) -> std::array<int, 2> {
    return {match.first, match.second};
  });
  table["rms_px"] = found.rms_px;
  return table;
}

}  // namespace

void add_optical(py::module_& module) {
  module.def(
      "frame_fields", [] { return fields_of<FrameSettings>(); },
      "Settings of the way from frames to registered frames, as config_fields() lists those of the estimator.");
  module.def(
      "validate_frames", [](const py::dict& values) { return violations(config_from<FrameSettings>(values)); }, py::arg("values"),
      "Every violation of them, as text; unknown keys raise ValueError.");
  module.def(
      "has_keypoints",
      [](const std::string& kind) {
        return (kind == "surf" && has_keypoints(KeypointKind::kSurf)) || (kind == "sift" && has_keypoints(KeypointKind::kSift)) ||
               (kind == "orb" && has_keypoints(KeypointKind::kOrb));
      },
      py::arg("kind"), "Whether this build finds them.");

  module.def(
      "check_calibration", [](const py::dict& calibration) { check_calibration(*calibration_from(calibration)); }, py::arg("calibration"),
      "Raises ValueError that names what is wrong.");

  module.def("estimate_lens", &lens_estimate, py::arg("pairs"), py::arg("width_px"), py::arg("height_px"), py::arg("tolerance_px"),
             "The radial lens of an uncalibrated camera from matched pixels (n, 2), (n, 2) of its frames; None where they tell nothing.");
  module.def(
      "undistorted", [](const PixelRows& pixel, const py::dict& calibration) { return through_lens(pixel, calibration, true); },
      py::arg("pixel"), py::arg("calibration"), "Where the camera without its lens would show what was seen at pixel (n, 2).");
  module.def(
      "distorted", [](const PixelRows& pixel, const py::dict& calibration) { return through_lens(pixel, calibration, false); },
      py::arg("pixel"), py::arg("calibration"), "The inverse of undistorted().");

  py::class_<FrameFeatures, std::shared_ptr<FrameFeatures>>(module, "FrameFeatures",
                                                            "What one frame holds; pixels with the lens corrected.")
      .def_property_readonly("left_out", [](const FrameFeatures& features) { return features.left_out; })
      .def_property_readonly("quality",
                             [](const FrameFeatures& features) {
                               py::dict quality;
                               quality["mean_level"] = features.quality.mean_level;
                               quality["level_sigma"] = features.quality.level_sigma;
                               quality["sharpness"] = features.quality.sharpness;
                               return quality;
                             })
      .def_property_readonly("regions", &frame_regions)
      .def_property_readonly("keypoints", &keypoint_table)
      .def_property_readonly("descriptors", &descriptor_rows, "Row by row those of the keypoints, float32.")
      .def(
          "straightened",
          [](const FrameFeatures& features, const py::dict& calibration) {
            return std::make_shared<FrameFeatures>(straightened(features, *calibration_from(calibration)));
          },
          py::arg("calibration"), "The same without a lens that was not known when the frame was read.");

  py::class_<FrameReader>(module, "FrameReader", "From a frame as taken to keypoints.")
      .def(py::init([](const py::dict& config, const std::optional<py::dict>& calibration) {
             return std::make_unique<FrameReader>(config_from<FrameSettings>(config).reader, calibration_from(calibration));
           }),
           py::arg("config") = py::dict(), py::arg("calibration") = py::none())
      .def(
          "read",
          [](const FrameReader& reader, const py::array& frame) {
            const cv::Mat pixels = frame_from(frame);
            const py::gil_scoped_release release;
            return std::make_shared<FrameFeatures>(reader.read(pixels));
          },
          py::arg("frame"))
      .def(
          "corrected", [](const FrameReader& reader, const py::array& frame) { return frame_array(reader.corrected(frame_from(frame))); },
          py::arg("frame"), "The frame without its lens.")
      .def(
          "lit", [](const FrameReader& reader, const py::array& frame) { return picture_array(reader.lit(frame_from(frame))); },
          py::arg("frame"), "What keypoints are looked for in.");

  module.def(
      "register_frames",
      [](const FrameFeatures& first, const FrameFeatures& second, const py::dict& config, std::uint64_t seed) -> py::object {
        const MatchingConfig matching = config_from<FrameSettings>(config).matching;
        std::optional<Registration> found;
        {
          const py::gil_scoped_release release;
          found = register_frames(first, second, matching, seed);
        }
        if (!found) return py::none();
        return registration_table(*found);
      },
      py::arg("first"), py::arg("second"), py::arg("config") = py::dict(), py::arg("seed") = 1,
      "The motion between two frames; None when they share nothing.");
}

}  // namespace ssjs::bindings
