// Masks, regions, shadows and scores of sonar pictures.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "config.hpp"
#include "parts.hpp"
#include "region_tables.hpp"
#include "ssjs/imaging/highlight_shadow.hpp"
#include "ssjs/imaging/morphology.hpp"
#include "ssjs/imaging/regions.hpp"
#include "ssjs/imaging/segmentation_score.hpp"
#include "ssjs/imaging/shadow_height.hpp"
#include "ssjs/imaging/three_class_otsu.hpp"

namespace ssjs::bindings {
namespace {

/// A mask made of a mask, without the interpreter lock.
template <class Operation>
py::array mask_of(const py::array& array, const Operation& operation) {
  const Picture mask = mask_picture(array, "mask");
  cv::Mat result;
  {
    const py::gil_scoped_release unlocked;
    result = operation(mask.mat());
  }
  return picture_array(result);
}

template <class Enum>
Enum named(const char* argument, const std::string& name, const Choices<Enum>& choices) {
  std::string known;
  for (const auto& [text, value] : choices) {
    if (text == name) return value;
    known += (known.empty() ? "" : ", ") + text;
  }
  throw InvalidArgument(argument, name, "must be one of " + known);
}

const Choices<ShadowRanges> kShadowRanges = {
    {"ground", ShadowRanges::kGround}, {"slant_top", ShadowRanges::kSlantTop}, {"slant_foot", ShadowRanges::kSlantFoot}};

template <class Config>
Config checked_config(const py::dict& values) {
  const auto config = config_from<Config>(values);
  throw_if_any(violations(config));
  return config;
}

template <class Config>
py::list fields_of() {
  FieldLister lister;
  Config config;
  config.visit(lister);
  return lister.fields();
}

void add_morphology(py::module_& module) {
  module.def(
      "remove_small_components",
      [](const py::array& mask, int smallest_area_px) {
        return mask_of(mask, [&](const cv::Mat& m) { return remove_small_components(m, smallest_area_px); });
      },
      py::arg("mask"), py::arg("smallest_area_px"), "Without the 8-connected components of fewer pixels.");
  module.def(
      "bridge", [](const py::array& mask) { return mask_of(mask, bridge); }, py::arg("mask"),
      "Clear pixels are set that join neighbours not joined around them, once.");
  module.def(
      "dilate", [](const py::array& mask, int times) { return mask_of(mask, [&](const cv::Mat& m) { return dilate(m, times); }); },
      py::arg("mask"), py::arg("times") = 1, "Dilations by a square of 3.");
  module.def(
      "fill_holes", [](const py::array& mask) { return mask_of(mask, fill_holes); }, py::arg("mask"),
      "Clear pixels not 4-connected to the border are set.");
}

LabelledRegions regions_of(const py::array& mask_array, const py::array& intensity_array) {
  const Picture mask = mask_picture(mask_array, "mask");
  const Picture intensity(intensity_array, "intensity", {CV_8U, CV_16U});
  const py::gil_scoped_release unlocked;
  return find_regions(mask.mat(), intensity.mat());
}

py::dict objects_of(const LabelledRegions& regions, double gap_px, const std::string& weighting_name) {
  const CentroidWeighting weighting = named("weighting", weighting_name, kCentroidWeightings);
  std::vector<RegionObject> objects;
  {
    const py::gil_scoped_release unlocked;
    objects = group_regions(regions, gap_px, weighting);
  }
  return object_table(objects, regions.regions.size());
}

void add_regions(py::module_& module) {
  const auto each = [](auto value_of) {
    return [value_of](const LabelledRegions& self) { return column<decltype(value_of(Region{}))>(self.regions, value_of); };
  };
  py::class_<LabelledRegions>(module, "Regions", "The regions of a mask, in the order of their labels 1, 2, ...")
      .def("__len__", [](const LabelledRegions& self) { return self.regions.size(); })
      .def_property_readonly("labels", [](const LabelledRegions& self) { return picture_array(self.labels); })
      .def_property_readonly("area_px", each([](const Region& region) { return region.area_px; }))
      .def_property_readonly(
          "centroid_px",
          [](const LabelledRegions& self) {
            return rows<double, 2>(self.regions, [](const Region& region) { return xy(region.centroid_px); });
          },
          "n x 2: x, y; the centre of the top left pixel is (0, 0).")
      .def_property_readonly(
          "bounding_box_px",
          [](const LabelledRegions& self) {
            return rows<int, 4>(self.regions, [](const Region& region) { return xywh(region.bounding_box); });
          },
          "n x 4: x, y, width, height.")
      .def_property_readonly("orientation_rad", each([](const Region& region) { return region.orientation_rad; }))
      .def_property_readonly("major_axis_px", each([](const Region& region) { return region.major_axis_px; }))
      .def_property_readonly("minor_axis_px", each([](const Region& region) { return region.minor_axis_px; }))
      .def_property_readonly("mean_intensity", each([](const Region& region) { return region.mean_intensity; }))
      .def_property_readonly("max_intensity", each([](const Region& region) { return region.max_intensity; }));
  module.def("find_regions", &regions_of, py::arg("mask"), py::arg("intensity"), "The 8-connected components of the mask, measured.");
  module.def("group_regions", &objects_of, py::arg("regions"), py::arg("gap_px"), py::arg("weighting") = "regions",
             "Regions nearer together than the gap are one object.");
}

py::dict shadows_of(const py::array& intensity_array, int nadir_column, const std::optional<py::array>& valid_array,
                    const py::dict& values) {
  const Picture intensity(intensity_array, "intensity", {CV_8U, CV_16U});
  const OptionalMask valid(valid_array, "valid");
  const auto config = checked_config<HighlightShadowConfig>(values);
  HighlightShadows found;
  {
    const py::gil_scoped_release unlocked;
    found = highlight_shadow({intensity.mat(), valid.mat()}, nadir_column, config);
  }
  py::list objects;
  for (const ShadowedObject& object : found.objects) {
    py::dict entry;
    entry["side"] = object.side == SonarSide::kPort ? "port" : "starboard";
    entry["centroid_px"] = xy(object.centroid_px);
    entry["highlight_box_px"] = xywh(object.highlight_box);
    entry["shadow_box_px"] = xywh(object.shadow_box);
    entry["highlight_area_px"] = object.highlight_area_px;
    entry["shadow_area_px"] = object.shadow_area_px;
    entry["contact_px"] = object.contact_px;
    entry["shadow_start_px"] = object.shadow_start_px;
    entry["shadow_tip_px"] = object.shadow_tip_px;
    entry["shadow_is_cut"] = object.shadow_is_cut;
    objects.append(entry);
  }
  py::dict dict;
  dict["shadow_below"] = found.thresholds ? py::cast(found.thresholds->shadow_below) : py::none();
  dict["highlight_above"] = found.thresholds ? py::cast(found.thresholds->highlight_above) : py::none();
  dict["highlights"] = picture_array(found.highlights);
  dict["shadows"] = picture_array(found.shadows);
  dict["objects"] = objects;
  return dict;
}

void add_shadows(py::module_& module) {
  module.def("highlight_shadow", &shadows_of, py::arg("intensity"), py::arg("nadir_column"), py::arg("valid") = py::none(),
             py::arg("config") = py::dict(), "Objects that are a highlight with its shadow beyond it, seen from the nadir.");
  module.def("highlight_shadow_fields", &fields_of<HighlightShadowConfig>);
  module.def(
      "height_from_shadow_m",
      [](double altitude_m, double shadow_start_m, double shadow_tip_m, const std::string& ranges) {
        return height_from_shadow_m(altitude_m, shadow_start_m, shadow_tip_m, named("ranges", ranges, kShadowRanges));
      },
      py::arg("altitude_m"), py::arg("shadow_start_m"), py::arg("shadow_tip_m"), py::arg("ranges") = "ground",
      "Height of an object on a flat seabed; ranges: ground, slant_top, slant_foot.");
  module.def("ground_range_m", &ground_range_m, py::arg("slant_range_m"), py::arg("altitude_m"));
  module.def(
      "three_class_otsu",
      [](const std::vector<std::int64_t>& counts) -> std::optional<std::pair<int, int>> {
        const std::optional<ThreeClasses> classes = three_class_otsu(Histogram{counts});
        if (!classes) return std::nullopt;
        return std::pair(classes->lower, classes->upper);
      },
      py::arg("counts"), "Classes are up to the first threshold, up to the second, and above; None for fewer than three levels.");
}

py::object ratio(const std::optional<double>& value) { return value ? py::cast(*value) : py::none(); }

py::dict score_of(const LabelledRegions& regions, const GroundTruth& truth, const std::optional<py::array>& pool_array,
                  const py::dict& values) {
  const OptionalMask pool(pool_array, "pool");
  const auto config = checked_config<SegmentationScoreConfig>(values);
  SegmentationScore score;
  {
    const py::gil_scoped_release unlocked;
    score = segmentation_score(regions, truth, pool.mat(), config);
  }
  py::list objects;
  for (const ObjectScore& object : score.objects) {
    py::dict entry;
    entry["labels"] = object.labels;
    entry["best_iou"] = object.best_iou;
    entry["centroid_error_px"] = ratio(object.centroid_error_px);
    objects.append(entry);
  }
  py::dict dict;
  dict["true_positives"] = score.confusion.true_positives;
  dict["false_positives"] = score.confusion.false_positives;
  dict["false_negatives"] = score.confusion.false_negatives;
  dict["true_negatives"] = score.confusion.true_negatives;
  dict["false_positive_rate"] = ratio(score.confusion.false_positive_rate());
  dict["precision"] = ratio(score.confusion.precision());
  dict["recall"] = ratio(score.confusion.recall());
  dict["objects"] = objects;
  dict["hits"] = score.hits;
  dict["hit_rate"] = ratio(score.hit_rate());
  dict["mask_iou"] = ratio(score.mask_iou);
  dict["pixel_recall"] = ratio(score.pixel_recall);
  dict["mean_centroid_error_px"] = ratio(score.mean_centroid_error_px);
  dict["intersection_px"] = score.intersection_px;
  dict["union_px"] = score.union_px;
  dict["false_area_px"] = score.false_area_px;
  dict["background_px"] = score.background_px;
  dict["false_area_fraction"] = ratio(score.false_area_fraction());
  return dict;
}

GroundTruth truth_of_box_rows(int rows, int columns, const std::vector<std::array<int, 4>>& boxes_px) {
  if (rows < 0 || columns < 0)
    throw InvalidArgument("rows, columns", std::to_string(rows) + ", " + std::to_string(columns), "must not be negative");
  std::vector<cv::Rect> boxes;
  boxes.reserve(boxes_px.size());
  for (const auto& [x, y, width, height] : boxes_px) boxes.emplace_back(x, y, width, height);
  return truth_of_boxes({columns, rows}, boxes);
}

void add_scores(py::module_& module) {
  py::class_<GroundTruth>(module, "GroundTruth", "Where the objects of a picture truly are.")
      .def_static(
          "of_mask", [](const py::array& mask) { return truth_of_mask(mask_picture(mask, "mask").mat()); }, py::arg("mask"),
          "One object for each 8-connected component.")
      .def_static(
          "of_labels",
          [](const py::array& labels) {
            return truth_of_labels(Picture(labels, "labels", {CV_8U, CV_16U, CV_32S}).mat());
          },
          py::arg("labels"), "One object for each value that is not 0, in ascending order.")
      .def_static("of_boxes", &truth_of_box_rows, py::arg("rows"), py::arg("columns"), py::arg("boxes_px"),
                  "Boxes are x, y, width, height, clipped to the picture.")
      .def("__len__", [](const GroundTruth& self) { return self.objects.size(); })
      .def_property_readonly("area_px",
                             [](const GroundTruth& self) {
                               return column<std::int64_t>(self.objects, [](const TruthObject& object) { return object.area_px; });
                             })
      .def_property_readonly("centroid_px", [](const GroundTruth& self) {
        return rows<double, 2>(self.objects, [](const TruthObject& object) { return xy(object.centroid_px); });
      });
  module.def("segmentation_score", &score_of, py::arg("regions"), py::arg("truth"), py::arg("pool") = py::none(),
             py::arg("config") = py::dict(), "Detected regions against the truth.");
  module.def("segmentation_score_fields", &fields_of<SegmentationScoreConfig>);
}

}  // namespace

void add_imaging(py::module_& module) {
  add_morphology(module);
  add_regions(module);
  add_shadows(module);
  add_scores(module);
}

}  // namespace ssjs::bindings
