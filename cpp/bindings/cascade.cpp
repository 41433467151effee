// Haar cascades: models, detection, training.
#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "config.hpp"
#include "parts.hpp"
#include "ssjs/cascade/cascade_detector.hpp"
#include "ssjs/cascade/cascade_file.hpp"
#include "ssjs/cascade/cascade_trainer.hpp"
#include "ssjs/cascade/cascade_xml.hpp"
#include "ssjs/cascade/sample_augmentation.hpp"
#include "ssjs/cascade/window_sums.hpp"

namespace ssjs::bindings {
namespace {

using Levels = py::array_t<std::uint8_t, py::array::c_style | py::array::forcecast>;
using Box = std::array<int, 4>;      // left, top, width, height
using Part = std::pair<Box, float>;  // rectangle and weight
using ReadImage = std::function<py::object(std::size_t)>;
using Report = std::function<bool(const py::dict&)>;

cv::Rect rect_of(const Box& box) { return {box[0], box[1], box[2], box[3]}; }
Box box_of(const cv::Rect& rect) { return {rect.x, rect.y, rect.width, rect.height}; }

/// (n, height, width) of uint8, with the recording of each window.
WindowSet window_set(const py::array& windows, const std::string& argument, const std::vector<int>& recordings = {}) {
  if (windows.ndim() != 3 || windows.dtype().kind() != 'u' || windows.itemsize() != 1)
    throw InvalidArgument(argument, array_text(windows), "must be an array (n, height, width) of uint8");
  if (windows.shape(1) < 1 || windows.shape(2) < 1 || windows.shape(1) > 4096 || windows.shape(2) > 4096)
    throw InvalidArgument(argument, array_text(windows), "windows must have 1 to 4096 rows and columns");
  if (!recordings.empty() && recordings.size() != static_cast<std::size_t>(windows.shape(0)))
    throw InvalidArgument(argument, array_text(windows), "must have as many windows as there are recordings");
  const Levels levels(windows);
  const cv::Size size(static_cast<int>(levels.shape(2)), static_cast<int>(levels.shape(1)));
  WindowSet set(size);
  for (py::ssize_t i = 0; i < levels.shape(0); ++i) {
    const cv::Mat picture(size, CV_8U, const_cast<std::uint8_t*>(levels.data(i, 0, 0)));  // cv::Mat knows no view of constants
    set.add(picture, recordings.empty() ? 0 : recordings[static_cast<std::size_t>(i)]);
  }
  return set;
}

py::array_t<std::uint8_t> window_array(const WindowSet& set) {
  const auto count = static_cast<py::ssize_t>(set.size());
  py::array_t<std::uint8_t> array({count, static_cast<py::ssize_t>(set.window().height), static_cast<py::ssize_t>(set.window().width)});
  for (py::ssize_t i = 0; i < count; ++i) {
    const cv::Mat picture = set[static_cast<std::size_t>(i)];
    std::copy(picture.datastart, picture.dataend, array.mutable_data(i, 0, 0));
  }
  return array;
}

/// A picture with its valid mask as C++ keeps it, apart from Python's arrays.
SonarImage sonar_image(const py::array& intensity, const std::optional<py::array>& valid) {
  const Picture picture(intensity, "intensity", {CV_8U, CV_16U});
  const OptionalMask mask(valid, "valid");
  SonarImage image{picture.mat().clone(), mask.mat().clone()};
  check_sonar_image(image);
  return image;
}

/// The pictures that `read` gives: (intensity, valid or None), or None where there is nothing to be read.
NegativeImages negative_images(std::size_t count, const ReadImage& read) {
  return {count, [&read](std::size_t index) -> std::optional<SonarImage> {
            const py::gil_scoped_acquire locked;
            const py::object answer = read(index);
            if (answer.is_none()) return std::nullopt;
            const auto pair = answer.cast<std::pair<py::array, std::optional<py::array>>>();
            return sonar_image(pair.first, pair.second);
          }};
}

py::list feature_list(const HaarCascade& cascade) {
  py::list list;
  for (const HaarFeature& feature : cascade.features) {
    std::vector<Part> parts;
    for (const WeightedRect& part : feature.rects)
      if (part.weight != 0) parts.emplace_back(box_of(part.rect), part.weight);
    py::dict entry;
    entry["parts"] = parts;
    entry["tilted"] = feature.tilted;
    list.append(entry);
  }
  return list;
}

py::list stage_list(const HaarCascade& cascade) {
  py::list list;
  for (const CascadeStage& stage : cascade.stages) {
    py::list weak;
    for (const WeakClassifier& classifier : stage.weak) {
      py::list nodes;
      for (const TreeNode& node : classifier.nodes) nodes.append(py::make_tuple(node.feature, node.threshold, node.left, node.right));
      py::dict entry;
      entry["nodes"] = nodes;
      entry["leaves"] = classifier.leaves;
      weak.append(entry);
    }
    py::dict entry;
    entry["threshold"] = stage.threshold;
    entry["weak"] = weak;
    list.append(entry);
  }
  return list;
}

py::dict provenance_dict(const HaarCascade& cascade) {
  const Provenance& provenance = cascade.provenance;
  py::list layers;
  for (const LayerRecord& layer : provenance.layers) {
    py::dict entry;
    entry["features"] = layer.features;
    entry["detection_rate"] = layer.detection_rate;
    entry["false_positive_rate"] = layer.false_positive_rate;
    entry["target_detection_rate"] = layer.target_detection_rate;
    entry["target_false_positive_rate"] = layer.target_false_positive_rate;
    entry["negatives"] = layer.negatives;
    entry["negatives_looked_at"] = layer.negatives_looked_at;
    layers.append(entry);
  }
  py::dict settings;
  for (const auto& [key, value] : provenance.settings) settings[py::str(key)] = value;
  py::dict dict;
  dict["trained_with"] = provenance.trained_with;
  dict["settings"] = settings;
  dict["layers"] = layers;
  dict["stopped_because"] = provenance.stopped_because;
  return dict;
}

py::tuple judge(const HaarCascade& cascade, const py::array& windows) {
  const WindowSet set = window_set(windows, "windows");
  if (set.window() != cascade.window)
    throw InvalidArgument(
        "windows", array_text(windows),
        "must be " + std::to_string(cascade.window.width) + " px wide and " + std::to_string(cascade.window.height) + " high");
  const auto count = static_cast<py::ssize_t>(set.size());
  py::array_t<int> passed(count);
  py::array_t<double> score(count);
  int* passed_data = passed.mutable_data();
  double* score_data = score.mutable_data();
  {
    const py::gil_scoped_release released;
    for (std::size_t i = 0; i < set.size(); ++i) {
      const WindowVerdict verdict = judge_window(cascade, IntegralImage(set[i], IntegralImage::Diagonal::kWith), {0, 0});
      passed_data[i] = verdict.stages_passed;
      score_data[i] = verdict.score;
    }
  }
  return py::make_tuple(passed, score);
}

py::dict detect(const HaarCascade& cascade, const py::array& intensity, const std::optional<py::array>& valid, const py::dict& config,
                int threads) {
  const CascadeDetector detector(cascade, config_from<CascadeDetectorConfig>(config));
  const SonarImage image = sonar_image(intensity, valid);
  std::vector<Detection> found;
  {
    const py::gil_scoped_release released;
    found = detector.detect(image, threads);
  }
  const auto count = static_cast<py::ssize_t>(found.size());
  py::array_t<int> boxes({count, py::ssize_t{4}});
  py::array_t<double> score(count);
  py::array_t<int> neighbours(count);
  for (py::ssize_t i = 0; i < count; ++i) {
    const Detection& detection = found[static_cast<std::size_t>(i)];
    const Box box = box_of(detection.box);
    for (std::size_t k = 0; k < box.size(); ++k) boxes.mutable_at(i, static_cast<py::ssize_t>(k)) = box[k];
    score.mutable_at(i) = detection.score;
    neighbours.mutable_at(i) = detection.neighbours;
  }
  py::dict dict;
  dict["boxes_px"] = boxes;
  dict["score"] = score;
  dict["neighbours"] = neighbours;
  return dict;
}

TrainingPlan plan_of(const std::vector<std::tuple<double, double, int>>& layers) {
  TrainingPlan plan;
  for (const auto& [detection_rate, false_positive_rate, max_features] : layers)
    plan.push_back({detection_rate, false_positive_rate, max_features});
  return plan;
}

std::vector<std::tuple<double, double, int>> layers_of(const TrainingPlan& plan) {
  std::vector<std::tuple<double, double, int>> layers;
  for (const LayerTarget& target : plan) layers.emplace_back(target.detection_rate, target.false_positive_rate, target.max_features);
  return layers;
}

TrainingProgressSink progress_sink(const std::optional<Report>& progress) {
  if (!progress) return {};
  return [&progress](const TrainingProgress& now) {
    const py::gil_scoped_acquire locked;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    py::dict dict;
    dict["layer"] = now.layer;
    dict["layers"] = now.layers;
    dict["doing"] = now.doing;
    dict["features"] = now.features;
    dict["max_features"] = now.max_features;
    dict["fraction"] = now.fraction;
    return (*progress)(dict);
  };
}

HaarCascade train(const py::array& positives, const std::vector<int>& recordings, const std::optional<py::array>& validation_positives,
                  const std::optional<py::array>& validation_negatives, std::size_t negative_count, const ReadImage& read_negative,
                  const std::string& negatives_digest, const std::vector<std::tuple<double, double, int>>& plan, const py::dict& config,
                  int threads, const std::optional<std::string>& checkpoint, bool resume, const std::optional<Report>& progress,
                  const std::optional<py::array>& negatives) {
  const auto trainer = config_from<CascadeTrainerConfig>(config);
  WindowSet objects = window_set(positives, "positives", recordings);
  const cv::Size window = objects.window();
  const auto optional_set = [&](const std::optional<py::array>& windows, const std::string& argument) {
    return windows ? window_set(*windows, argument) : WindowSet(window);
  };
  const CascadeTrainingData data{std::move(objects),
                                 optional_set(validation_positives, "validation_positives"),
                                 optional_set(negatives, "negatives"),
                                 optional_set(validation_negatives, "validation_negatives"),
                                 negative_images(negative_count, read_negative),
                                 negatives_digest};
  const TrainingPlan targets = plan_of(plan);
  const TrainingProgressSink sink = progress_sink(progress);
  const py::gil_scoped_release released;
  return train_cascade(data, targets, trainer, threads, checkpoint, resume, sink);
}

/// Every field of a configuration with its rule and default.
template <class Config>
py::list fields_of() {
  Config config;
  FieldLister lister;
  config.visit(lister);
  return lister.fields();
}

void add_model(py::module_& module) {
  py::class_<HaarCascade>(module, "Cascade", "A trained cascade of boosted Haar features.")
      .def_static("load", &load_cascade, py::arg("path"), "This library's form or OpenCV's XML, told apart by content.")
      .def_static(
          "from_json", [](const std::string& text, const std::string& name) { return from_json(text, name); }, py::arg("text"),
          py::arg("name"))
      .def_static(
          "from_opencv_xml", [](const std::string& text, const std::string& name) { return from_opencv_xml(text, name); }, py::arg("text"),
          py::arg("name"))
      .def("to_json", [](const HaarCascade& cascade) { return to_json(cascade); })
      .def("to_opencv_xml", [](const HaarCascade& cascade) { return to_opencv_xml(cascade); })
      .def(
          "mirrored", [](const HaarCascade& cascade) { return mirrored(cascade); }, "For the other side of the vehicle.")
      .def(
          "with_settings",
          [](HaarCascade cascade, const std::vector<std::pair<std::string, std::string>>& settings) {
            for (const auto& entry : settings) cascade.provenance.settings.push_back(entry);
            return cascade;
          },
          py::arg("settings"), "The same model, its provenance with further settings.")
      .def("judge", &judge, py::arg("windows"),
           "(n, height, width) of uint8 -> stages passed (n,), -1 for windows too flat to be looked at, and score (n,).")
      .def_property_readonly("width_px", [](const HaarCascade& cascade) { return cascade.window.width; })
      .def_property_readonly("height_px", [](const HaarCascade& cascade) { return cascade.window.height; })
      .def_property_readonly("features", &feature_list, "Each: parts ((left, top, width, height), weight) and tilted.")
      .def_property_readonly("stages", &stage_list, "Each: threshold, and weak classifiers with nodes (feature, threshold, left, right).")
      .def_property_readonly("provenance", &provenance_dict);
}

void add_samples(py::module_& module) {
  module.def(
      "training_window",
      [](const py::array& intensity, const Box& box_px, int width_px, int height_px) -> std::optional<py::array> {
        const Picture picture(intensity, "intensity", {CV_8U});
        const cv::Mat window = window_of(picture.mat(), rect_of(box_px), {width_px, height_px});
        return window.empty() ? std::nullopt : std::optional<py::array>(picture_array(window));
      },
      py::arg("intensity"), py::arg("box_px"), py::arg("width_px"), py::arg("height_px"),
      "The object of a box (left, top, width, height), grown to the window's proportions; None where it leaves the picture.");
  module.def(
      "in_8_bits",
      [](const py::array& intensity, const std::optional<py::array>& valid) {
        return picture_array(in_8_bits(sonar_image(intensity, valid)).intensity);
      },
      py::arg("intensity"), py::arg("valid") = py::none(), "As it is if it has 8 bits, otherwise its valid range drawn out to 0..255.");
  module.def("augmentation_fields", [] { return fields_of<SampleAugmentationConfig>(); });
  module.def(
      "validate_augmentation", [](const py::dict& values) { return violations(config_from<SampleAugmentationConfig>(values)); },
      py::arg("values"));
  module.def(
      "augmented_windows",
      [](const py::array& intensity, const Box& box_px, int width_px, int height_px, std::size_t copies, const py::dict& config,
         std::uint64_t seed, const std::string& name) {
        const Picture picture(intensity, "intensity", {CV_8U});
        const auto augmentation = config_from<SampleAugmentationConfig>(config);
        return window_array(augmented_windows(picture.mat(), rect_of(box_px), {width_px, height_px}, copies, 0, augmentation,
                                              Rng(seed).stream("augmentation: " + name)));
      },
      py::arg("intensity"), py::arg("box_px"), py::arg("width_px"), py::arg("height_px"), py::arg("copies"), py::arg("config"),
      py::arg("seed"), py::arg("name"), "Changed windows (n, height, width) of one object; name: of the object, for the random draws.");
  module.def(
      "split_by_recording",
      [](const std::vector<int>& recordings, double validation_fraction, std::uint64_t seed) {
        const SampleSplit split = split_by_recording(recordings, validation_fraction, Rng(seed));
        return py::make_tuple(split.training, split.validation);
      },
      py::arg("recordings"), py::arg("validation_fraction"), py::arg("seed"), "Indices of training and of validation samples.");
  module.def(
      "background_windows",
      [](std::size_t count, const ReadImage& read, std::size_t wanted, int width_px, int height_px, std::uint64_t seed,
         const std::string& name, int threads) {
        HaarCascade nothing;
        nothing.window = {width_px, height_px};
        const NegativeImages images = negative_images(count, read);
        MinedNegatives mined{WindowSet(nothing.window), 0, 0, 0};
        {
          const py::gil_scoped_release released;
          mined = mine_negatives(nothing, images, wanted, 2.0, Rng(seed), name, threads);
        }
        return window_array(mined.windows);
      },
      py::arg("count"), py::arg("read"), py::arg("wanted"), py::arg("width_px"), py::arg("height_px"), py::arg("seed"), py::arg("name"),
      py::arg("threads") = 1, "Windows at random places of `count` pictures; read(index) gives (intensity, valid or None) or None.");
  module.def(
      "feature_values",
      [](const std::vector<Part>& parts, bool tilted, const py::array& windows) {
        HaarFeature feature;
        if (parts.empty() || parts.size() > feature.rects.size())
          throw InvalidArgument("parts", static_cast<double>(parts.size()), "must be one to three rectangles");
        for (std::size_t k = 0; k < parts.size(); ++k) feature.rects[k] = {rect_of(parts[k].first), parts[k].second};
        feature.tilted = tilted;
        const WindowSet set = window_set(windows, "windows");
        check_feature(feature, set.window());
        std::vector<float> values(set.size());
        WindowSums(set, tilted ? WindowSums::Diagonal::kWith : WindowSums::Diagonal::kWithout).values(feature, values.data());
        return py::array_t<float>(static_cast<py::ssize_t>(values.size()), values.data());
      },
      py::arg("parts"), py::arg("tilted"), py::arg("windows"), "One Haar feature on windows (n, height, width): (n,).");
}

}  // namespace

void add_cascade(py::module_& module) {
  add_model(module);
  add_samples(module);
  module.def("cascade_detector_fields", [] { return fields_of<CascadeDetectorConfig>(); });
  module.def(
      "validate_cascade_detector", [](const py::dict& values) { return violations(config_from<CascadeDetectorConfig>(values)); },
      py::arg("values"));
  module.def("detect_objects", &detect, py::arg("cascade"), py::arg("intensity"), py::arg("valid") = py::none(),
             py::arg("config") = py::dict(), py::arg("threads") = 1,
             "boxes_px (n, 4): left, top, width, height; score (n,); neighbours (n,). Best score first.");
  module.def("cascade_trainer_fields", [] { return fields_of<CascadeTrainerConfig>(); });
  module.def(
      "validate_cascade_trainer", [](const py::dict& values) { return violations(config_from<CascadeTrainerConfig>(values)); },
      py::arg("values"));
  module.def(
      "thesis_plan", [] { return layers_of(thesis_plan()); }, "Per layer: detection rate, false positive rate, most features.");
  module.def(
      "check_plan", [](const std::vector<std::tuple<double, double, int>>& plan) { check_plan(plan_of(plan)); }, py::arg("plan"));
  module.def("train_cascade", &train, py::arg("positives"), py::arg("recordings"), py::arg("validation_positives"),
             py::arg("validation_negatives"), py::arg("negative_count"), py::arg("read_negative"), py::arg("negatives_digest"),
             py::arg("plan"), py::arg("config"), py::arg("threads") = 1, py::arg("checkpoint") = py::none(), py::arg("resume") = false,
             py::arg("progress") = py::none(), py::arg("negatives") = py::none(),
             "Windows are (n, height, width) of uint8. read_negative(index) gives (intensity, valid or None) or None.\n"
             "progress(dict) -> False asks to stop (KeyboardInterrupt).");
}

}  // namespace ssjs::bindings
