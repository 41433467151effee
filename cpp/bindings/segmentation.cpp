// Thresholds and the segmentation chain.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "config.hpp"
#include "parts.hpp"
#include "region_tables.hpp"
#include "ssjs/imaging/highlight_shadow.hpp"
#include "ssjs/imaging/histogram.hpp"
#include "ssjs/imaging/improved_otsu.hpp"
#include "ssjs/imaging/segmentation.hpp"
#include "ssjs/imaging/threshold.hpp"

namespace ssjs::bindings {
namespace {

/// Keys as a configuration file of the command line has them.
struct SegmentationSettings {
  SegmentationConfig segmentation;
  HighlightShadowConfig shadows;
  template <class Visitor>
  void visit(Visitor& v) {
    v.section("segmentation", segmentation, "from picture to regions");
    v.section("shadows", shadows, "highlights with a shadow behind them");
  }
};

/// Rules of single fields carry their full key; those between the fields of a stage get the stage's name in front.
std::vector<std::string> all_violations(const SegmentationSettings& settings) {
  std::vector<std::string> all;
  for (const std::string& violation : settings.segmentation.violations()) all.push_back("segmentation." + violation);
  for (const std::string& violation : violations(settings.shadows)) all.push_back("shadows." + violation);
  if (settings.shadows.median_px % 2 == 0) {
    all.push_back("shadows.median_px = " + std::to_string(settings.shadows.median_px) + ": must be odd");
  }
  return all;
}

/// Every field of a configuration with its value, keys dotted and prefixed.
py::dict values_of(SegmentationConfig config) {
  FieldLister lister;
  config.visit(lister);
  py::dict values;
  for (const py::handle entry : lister.fields()) {
    values[py::str("segmentation." + entry["key"].cast<std::string>())] = entry["default"];
  }
  return values;
}

py::object improved_otsu_dict(const std::optional<ImprovedOtsu>& answer) {
  if (!answer) return py::none();
  py::dict entry;
  entry["first_threshold"] = answer->first_threshold;
  entry["threshold"] = answer->threshold;
  entry["spots"] = answer->spots;
  entry["spot_px"] = answer->spot_px;
  entry["spot_limit"] = answer->spot_limit;
  entry["canny_high"] = answer->canny_high;
  entry["second_pass_fired"] = answer->second_pass_fired;
  return entry;
}

py::object step_pictures(const std::optional<SegmentationSteps>& steps) {
  if (!steps) return py::none();
  py::dict pictures;
  pictures["filtered"] = picture_array(steps->filtered);
  pictures["normalised"] = picture_array(steps->normalised);
  pictures["contrasted"] = picture_array(steps->contrasted);
  pictures["thresholded"] = picture_array(steps->thresholded);
  pictures["cleaned"] = picture_array(steps->cleaned);
  pictures["bridged"] = picture_array(steps->bridged);
  pictures["dilated"] = picture_array(steps->dilated);
  return pictures;
}

/// What `find` answers about the image, without the interpreter lock.
template <class Find>
auto unlocked(const py::array& intensity_array, const std::optional<py::array>& valid_array, const Find& find) {
  const Picture intensity(intensity_array, "intensity", {CV_8U, CV_16U});
  const OptionalMask valid(valid_array, "valid");
  const SonarImage image{intensity.mat(), valid.mat()};
  check_sonar_image(image);
  const py::gil_scoped_release release;
  return find(image);
}

void add_thresholds(py::module_& module) {
  module.def(
      "otsu_threshold",
      [](const py::array& intensity, const std::optional<py::array>& valid, int lowest_level) {
        return unlocked(intensity, valid, [&](const SonarImage& image) { return otsu_threshold(histogram(image), lowest_level); });
      },
      py::arg("intensity"), py::arg("valid") = py::none(), py::arg("lowest_level") = 0);
  module.def(
      "iterative_threshold",
      [](const py::array& intensity, const std::optional<py::array>& valid) {
        return unlocked(intensity, valid, [](const SonarImage& image) { return iterative_threshold(histogram(image)); });
      },
      py::arg("intensity"), py::arg("valid") = py::none());
  module.def(
      "maximum_entropy_threshold",
      [](const py::array& intensity, const std::optional<py::array>& valid) {
        return unlocked(intensity, valid, [](const SonarImage& image) { return maximum_entropy_threshold(histogram(image)); });
      },
      py::arg("intensity"), py::arg("valid") = py::none());
  module.def(
      "local_foreground",
      [](const py::array& intensity, const std::optional<py::array>& valid, const py::dict& config) {
        const auto local = config_from<LocalThresholdConfig>(config);
        return picture_array(unlocked(intensity, valid, [&](const SonarImage& image) { return local_foreground(image, local); }));
      },
      py::arg("intensity"), py::arg("valid") = py::none(), py::arg("config") = py::dict());
  module.def(
      "foreground",
      [](const py::array& intensity, int threshold, const std::optional<py::array>& valid) {
        return picture_array(unlocked(intensity, valid, [&](const SonarImage& image) { return foreground(image, threshold); }));
      },
      py::arg("intensity"), py::arg("threshold"), py::arg("valid") = py::none());
  module.def(
      "improved_otsu",
      [](const py::array& intensity, const std::optional<py::array>& valid, const py::dict& config) {
        const auto improved = config_from<ImprovedOtsuConfig>(config);
        return improved_otsu_dict(unlocked(intensity, valid, [&](const SonarImage& image) { return improved_otsu(image, improved); }));
      },
      py::arg("intensity"), py::arg("valid") = py::none(), py::arg("config") = py::dict());
}

}  // namespace

void add_segmentation(py::module_& module) {
  add_thresholds(module);
  module.def(
      "segmentation_fields",
      [] {
        FieldLister lister;
        SegmentationSettings settings;
        settings.visit(lister);
        return lister.fields();
      },
      "Every setting of the segmentation and of the shadow detector, with its default.");
  module.def(
      "validate_segmentation", [](const py::dict& values) { return all_violations(config_from<SegmentationSettings>(values)); },
      py::arg("values"));
  module.def("segmentation_preset_names", [] {
    std::vector<std::string> names;
    for (const auto& [name, preset] : kSegmentationPresets) names.push_back(name);
    return names;
  });
  module.def(
      "segmentation_preset",
      [](const std::string& name) {
        for (const auto& [known, preset] : kSegmentationPresets) {
          if (known == name) return values_of(segmentation_preset(preset));
        }
        throw InvalidArgument("name", name, "no such preset");
      },
      py::arg("name"), "Every setting of the chain as the preset has it.");
  module.def(
      "segment",
      [](const py::array& intensity, const std::optional<py::array>& valid, const py::dict& config, bool keep_steps) {
        const auto chain = config_from<SegmentationConfig>(config);
        SegmentationResult result = unlocked(intensity, valid, [&](const SonarImage& image) {
          return segment(image, chain, keep_steps ? KeepSteps::kYes : KeepSteps::kNo);
        });
        py::dict answer;
        answer["threshold"] = result.threshold;
        answer["improved_otsu"] = improved_otsu_dict(result.improved_otsu);
        answer["smallest_area_px"] = result.smallest_area_px;
        answer["mask"] = picture_array(result.mask);
        answer["objects"] = object_table(result.objects, result.regions.regions.size());
        answer["regions"] = std::move(result.regions);
        answer["steps"] = step_pictures(result.steps);
        return answer;
      },
      py::arg("intensity"), py::arg("valid") = py::none(), py::arg("config") = py::dict(), py::arg("keep_steps") = false,
      "The whole chain on one picture (h, w) of uint8 or uint16; valid (h, w) of uint8, nonzero where a pixel is a measurement.");
  module.def(
      "set_image_threads", [](int threads) { cv::setNumThreads(threads); }, py::arg("threads"),
      "Threads of OpenCV's functions, process-wide; results do not depend on them.");
}

}  // namespace ssjs::bindings
