// One picture of the ground out of many frames.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <memory>
#include <vector>

#include "config.hpp"
#include "frame_arrays.hpp"
#include "parts.hpp"
#include "ssjs/optical/mosaic.hpp"

namespace ssjs::bindings {
namespace {

/// Keys as a configuration file of the command line has them.
struct MosaicSettings {
  MosaicConfig mosaic;
  template <class Visitor>
  void visit(Visitor& v) {
    v.section("mosaic", mosaic, "one picture of the ground");
  }
};

using Homographies = py::array_t<double, py::array::c_style | py::array::forcecast>;

cv::Matx33d homography_at(const double* values) {
  cv::Matx33d H;
  std::copy_n(values, 9, H.val);
  return H;
}

std::vector<cv::Matx33d> homographies_from(const Homographies& array) {
  if (array.ndim() != 3 || array.shape(1) != 3 || array.shape(2) != 3) {
    throw InvalidArgument("map_H_frame", array_text(array), "must be of shape (frames, 3, 3)");
  }
  std::vector<cv::Matx33d> all;
  for (py::ssize_t i = 0; i < array.shape(0); ++i) all.push_back(homography_at(array.data(i, 0, 0)));
  return all;
}

py::dict window_table(const MosaicWindow& window) {
  py::dict table;
  table["left"] = window.left;
  table["bottom"] = window.bottom;
  table["pixel_length"] = window.pixel_length;
  table["width_px"] = window.size_px.width;
  table["height_px"] = window.size_px.height;
  return table;
}

}  // namespace

void add_mosaic(py::module_& module) {
  module.def(
      "mosaic_fields", [] { return fields_of<MosaicSettings>(); },
      "Settings of the mosaic, as config_fields() lists those of the estimator.");

  module.def(
      "validate_mosaic", [](const py::dict& values) { return violations(config_from<MosaicSettings>(values)); }, py::arg("values"),
      "Every violation of them, as text; unknown keys raise ValueError.");

  py::class_<LampLight>(module, "LampLight", "What the lamps do to every frame alike.")
      .def(py::init([](const py::dict& config) { return std::make_unique<LampLight>(config_from<MosaicSettings>(config).mosaic); }),
           py::arg("config") = py::dict())
      .def(
          "learn", [](LampLight& light, const py::array& frame) { light.learn(frame_from(frame)); }, py::arg("frame"))
      .def(
          "evened", [](const LampLight& light, const py::array& frame) { return frame_array(light.evened(frame_from(frame))); },
          py::arg("frame"), "The frame as lit evenly, as bright as the mean of all frames.");

  py::class_<MosaicCanvas>(module, "MosaicCanvas", "A map's part that frames are drawn on, x to the right, y upwards.")
      .def(py::init([](const Homographies& map_H_frame, int width_px, int height_px, int channels, const py::dict& config) {
             const MosaicConfig mosaic = config_from<MosaicSettings>(config).mosaic;
             return std::make_unique<MosaicCanvas>(mosaic_window(homographies_from(map_H_frame), {width_px, height_px}, mosaic), channels,
                                                   mosaic);
           }),
           py::arg("map_H_frame"), py::arg("width_px"), py::arg("height_px"), py::arg("channels"), py::arg("config") = py::dict(),
           "Holds every frame that map_H_frame (frames, 3, 3) takes to the map.")
      .def(
          "add",
          [](MosaicCanvas& canvas, const py::array& frame, const Homographies& map_H_frame, const py::object& valid) {
            if (map_H_frame.ndim() != 2 || map_H_frame.shape(0) != 3 || map_H_frame.shape(1) != 3) {
              throw InvalidArgument("map_H_frame", array_text(map_H_frame), "must be of shape (3, 3)");
            }
            const cv::Mat pixels = frame_from(frame);
            const cv::Mat usable = valid.is_none() ? cv::Mat() : frame_from(valid.cast<py::array>());
            const cv::Matx33d H = homography_at(map_H_frame.data(0, 0));
            const py::gil_scoped_release release;
            canvas.add(pixels, H, usable);
          },
          py::arg("frame"), py::arg("map_H_frame"), py::arg("valid") = py::none())
      .def("picture", [](const MosaicCanvas& canvas) { return frame_array(canvas.picture()); })
      .def("seen", [](const MosaicCanvas& canvas) { return frame_array(canvas.seen()); })
      .def_property_readonly("window", [](const MosaicCanvas& canvas) { return window_table(canvas.window()); });
}

}  // namespace ssjs::bindings
