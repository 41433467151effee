// Cascades: training windows, training, models, detection. Pictures are uint8 or uint16 arrays (rows x columns), masks uint8.
#include "ssjs/cascade/cascade_trainer.hpp"

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "config.hpp"
#include "parts.hpp"
#include "ssjs/cascade/augmentation.hpp"
#include "ssjs/cascade/cascade_detector.hpp"
#include "ssjs/cascade/cascade_file.hpp"
#include "ssjs/cascade/cascade_xml.hpp"
#include "ssjs/cascade/contour_signature.hpp"
#include "ssjs/cascade/window_sums.hpp"

namespace ssjs::bindings {
namespace {

using Boxes = std::vector<std::array<int, 4>>;  // x, y, width, height

/// A view of an array: the array has to outlive it.
cv::Mat view(const py::array& array, const char* name) {
  int depth = 0;
  if (array.dtype().is(py::dtype::of<std::uint8_t>()))
    depth = CV_8U;
  else if (array.dtype().is(py::dtype::of<std::uint16_t>()))
    depth = CV_16U;
  else
    throw InvalidArgument(name, py::str(array.dtype()).cast<std::string>(), "must be an array of uint8 or uint16");
  if (array.ndim() != 2 || array.size() == 0 || array.strides(1) != array.itemsize())
    throw InvalidArgument(name, std::to_string(array.ndim()) + " dimensions",
                          "must be rows x columns, not empty, with the columns side by side");
  return {static_cast<int>(array.shape(0)), static_cast<int>(array.shape(1)), depth, const_cast<void*>(array.data()),
          static_cast<std::size_t>(array.strides(0))};
}

SonarImage image_of(const py::array& intensity, const std::optional<py::array>& valid) {
  return {view(intensity, "image"), valid ? view(*valid, "valid") : cv::Mat()};
}

py::array_t<std::uint8_t> array_of(const cv::Mat& picture) {
  py::array_t<std::uint8_t> array({picture.rows, picture.cols});
  for (int y = 0; y < picture.rows; ++y) std::copy_n(picture.ptr(y), picture.cols, array.mutable_data(y, 0));
  return array;
}

TrainingPlan plan_of(const std::vector<std::tuple<double, double, int, double>>& rows) {
  TrainingPlan plan;
  for (const auto& [detection, false_positive, features, false_alarm] : rows)
    plan.push_back({detection, false_positive, features, false_alarm});
  return plan;
}

std::vector<std::tuple<double, double, int, double>> rows_of(const TrainingPlan& plan) {
  std::vector<std::tuple<double, double, int, double>> rows;
  for (const LayerTarget& layer : plan)
    rows.emplace_back(layer.detection_rate, layer.false_positive_rate, layer.max_features, layer.false_alarm_rate);
  return rows;
}

/// `read(index)` gives a picture, a pair of picture and mask, or None; what it gives is copied before the lock is released.
NegativeImages negative_images(std::size_t count, const py::object& read) {
  return {count, [read](std::size_t index) -> std::optional<SonarImage> {
            const py::gil_scoped_acquire lock;
            const py::object given = read(index);
            if (given.is_none()) return std::nullopt;
            if (!py::isinstance<py::tuple>(given)) return SonarImage{view(given.cast<py::array>(), "picture").clone(), {}};
            const auto pair = given.cast<std::pair<py::array, py::array>>();
            return SonarImage{view(pair.first, "picture").clone(), view(pair.second, "valid").clone()};
          }};
}

py::dict record_of(const LayerRecord& layer) {
  py::dict dict;
  dict["features"] = layer.features;
  dict["detection_rate"] = layer.detection_rate;
  dict["false_positive_rate"] = layer.false_positive_rate;
  dict["target_detection_rate"] = layer.target_detection_rate;
  dict["target_false_positive_rate"] = layer.target_false_positive_rate;
  dict["negatives"] = layer.negatives;
  dict["negatives_looked_at"] = layer.negatives_looked_at;
  return dict;
}

py::dict provenance_of(const HaarCascade& cascade) {
  py::dict dict;
  py::list layers;
  py::dict settings;
  for (const LayerRecord& layer : cascade.provenance.layers) layers.append(record_of(layer));
  for (const auto& [key, value] : cascade.provenance.settings) settings[py::str(key)] = value;
  dict["trained_with"] = cascade.provenance.trained_with;
  dict["settings"] = settings;
  dict["layers"] = layers;
  dict["stopped_because"] = cascade.provenance.stopped_because;
  return dict;
}

/// Each feature as (tilted, [(x, y, width, height, weight), ...]).
py::list features_of(const std::vector<HaarFeature>& features) {
  py::list list;
  for (const HaarFeature& feature : features) {
    py::list rects;
    for (const WeightedRect& part : feature.rects)
      if (part.weight != 0) rects.append(py::make_tuple(part.rect.x, part.rect.y, part.rect.width, part.rect.height, part.weight));
    list.append(py::make_tuple(feature.tilted, rects));
  }
  return list;
}

HaarFeature feature_of(bool tilted, const std::vector<std::tuple<int, int, int, int, float>>& rects) {
  HaarFeature feature;
  if (rects.empty() || rects.size() > feature.rects.size())
    throw InvalidArgument("rects", static_cast<double>(rects.size()), "must be one to three (x, y, width, height, weight)");
  for (std::size_t i = 0; i < rects.size(); ++i) {
    const auto& [x, y, width, height, weight] = rects[i];
    feature.rects[i] = {{x, y, width, height}, weight};
  }
  feature.tilted = tilted;
  return feature;
}

/// Detections as n x 6: x, y, width, height, score, neighbours; where contours are verified n x 8: and the contour's distance (NaN
/// without an echo) and score.
py::array_t<double> rows_of(const std::vector<Detection>& detections, DetectionVerifier verifier) {
  const std::size_t columns = verifier == DetectionVerifier::kContour ? 8 : 6;
  py::array_t<double> rows({static_cast<py::ssize_t>(detections.size()), static_cast<py::ssize_t>(columns)});
  for (std::size_t i = 0; i < detections.size(); ++i) {
    const Detection& d = detections[i];
    const ContourVerdict contour = d.contour.value_or(ContourVerdict{});
    const std::array<double, 8> row = {static_cast<double>(d.box.x),
                                       static_cast<double>(d.box.y),
                                       static_cast<double>(d.box.width),
                                       static_cast<double>(d.box.height),
                                       d.score,
                                       static_cast<double>(d.neighbours),
                                       contour.distance.value_or(std::numeric_limits<double>::quiet_NaN()),
                                       contour.score};
    std::copy_n(row.begin(), columns, rows.mutable_data(static_cast<py::ssize_t>(i), 0));
  }
  return rows;
}

/// Distances and spectrum, or None.
py::object signature_of(const std::optional<ContourSignature>& signature) {
  if (!signature) return py::none();
  return py::make_tuple(signature->distance, signature->spectrum);
}

void add_windows(py::module_& module) {
  py::class_<WindowSet>(module, "WindowSet", "Equal-sized 8-bit windows, each with its recording.")
      .def(py::init([](int width, int height) {
             return WindowSet({width, height});
           }),
           py::arg("width"), py::arg("height"))
      .def("__len__", &WindowSet::size)
      .def(
          "add", [](WindowSet& windows, const py::array& picture, int recording) { windows.add(view(picture, "picture"), recording); },
          py::arg("picture"), py::arg("recording") = 0)
      .def(
          "add_object",
          [](WindowSet& windows, const py::array& image, const std::array<int, 4>& box, int recording) {
            const cv::Mat picture = window_of(view(image, "image"), {box[0], box[1], box[2], box[3]}, windows.window());
            if (picture.empty()) return false;
            windows.add(picture, recording);
            return true;
          },
          py::arg("image"), py::arg("box"), py::arg("recording") = 0,
          "The box grown to the window's proportions, resampled. False, and nothing added, if that does not lie in the image.")
      .def("append", &WindowSet::append, py::arg("other"))
      .def("select", &WindowSet::select, py::arg("indices"))
      .def(
          "picture",
          [](const WindowSet& windows, std::size_t index) {
            if (index >= windows.size()) throw py::index_error();
            return array_of(windows[index]);
          },
          py::arg("index"))
      .def(
          "pictures",
          [](const WindowSet& windows) {
            const cv::Size size = windows.window();
            py::array_t<std::uint8_t> array(
                {static_cast<py::ssize_t>(windows.size()), static_cast<py::ssize_t>(size.height), static_cast<py::ssize_t>(size.width)});
            for (std::size_t i = 0; i < windows.size(); ++i) {
              const cv::Mat picture = windows[i];
              std::copy(picture.datastart, picture.dataend, array.mutable_data(static_cast<py::ssize_t>(i), 0, 0));
            }
            return array;
          },
          "All windows: (n, height, width) of uint8.")
      .def("recordings",
           [](const WindowSet& windows) {
             std::vector<int> recordings;
             for (std::size_t i = 0; i < windows.size(); ++i) recordings.push_back(windows.recording(i));
             return recordings;
           })
      .def("digest", &WindowSet::digest)
      .def(
          "augmented",
          [](const WindowSet& windows, const py::dict& config, int seed) {
            return augmented(windows, config_from<AugmentationConfig>(config), Rng(static_cast<std::uint64_t>(seed)));
          },
          py::arg("config") = py::dict(), py::arg("seed") = 1)
      .def(
          "split_by_recording",
          [](const WindowSet& windows, double validation_fraction, int seed) {
            std::vector<int> recordings;
            for (std::size_t i = 0; i < windows.size(); ++i) recordings.push_back(windows.recording(i));
            SampleSplit split = split_by_recording(recordings, validation_fraction, Rng(static_cast<std::uint64_t>(seed)));
            return std::make_pair(std::move(split.training), std::move(split.validation));
          },
          py::arg("validation_fraction"), py::arg("seed") = 1, "Indices of the windows for training and for validation.")
      .def(
          "responses",
          [](const WindowSet& windows, bool tilted, const std::vector<std::tuple<int, int, int, int, float>>& rects) {
            const HaarFeature feature = feature_of(tilted, rects);
            check_feature(feature, windows.window());
            std::vector<float> values(windows.size());
            WindowSums(windows, tilted ? WindowSums::Diagonal::kWith : WindowSums::Diagonal::kWithout).values(feature, values.data());
            return values;
          },
          py::arg("tilted"), py::arg("rects"), "One feature on every window (0 on flat ones).");
}

void add_model(py::module_& module) {
  py::class_<HaarCascade>(module, "HaarCascade", "A trained cascade.")
      .def_static("load", &load_cascade, py::arg("path"), "Our JSON form or OpenCV's XML, by content.")
      .def_static(
          "from_opencv_xml", [](const std::string& xml) { return from_opencv_xml(xml, "text"); }, py::arg("xml"))
      .def_static(
          "from_json", [](const std::string& json) { return from_json(json, "text"); }, py::arg("json"))
      .def(
          "with_settings",
          [](HaarCascade cascade, const std::vector<std::pair<std::string, std::string>>& settings) {
            for (const auto& entry : settings) cascade.provenance.settings.push_back(entry);
            return cascade;
          },
          py::arg("settings"), "The same model, with further settings in its provenance.")
      .def(
          "with_contours",
          [](HaarCascade cascade, const std::vector<ContourSpectrum>& spectra) {
            cascade.contour = learn_contours(spectra);
            return cascade;
          },
          py::arg("spectra"), "The same model, with what the contours of at least three objects look like.")
      .def_property_readonly(
          "contours_known", [](const HaarCascade& cascade) { return cascade.contour ? cascade.contour->distances.size() : 0; },
          "Of how many objects the model knows the contour.")
      .def("save", &save_cascade, py::arg("path"), "OpenCV's XML if the path ends in .xml, else our JSON form.")
      .def("to_json", &to_json)
      .def("to_opencv_xml", &to_opencv_xml)
      .def("mirrored", [](const HaarCascade& cascade) { return mirrored(cascade); })
      .def("provenance", &provenance_of)
      .def("features", [](const HaarCascade& cascade) { return features_of(cascade.features); })
      .def_property_readonly("window",
                             [](const HaarCascade& cascade) { return std::make_pair(cascade.window.width, cascade.window.height); })
      .def_property_readonly("stages",
                             [](const HaarCascade& cascade) {
                               py::list stages;
                               for (const CascadeStage& stage : cascade.stages) {
                                 py::list weak;
                                 for (const WeakClassifier& tree : stage.weak) {
                                   py::list nodes;
                                   for (const TreeNode& node : tree.nodes)
                                     nodes.append(py::make_tuple(node.feature, node.threshold, node.left, node.right));
                                   weak.append(py::make_tuple(nodes, tree.leaves));
                                 }
                                 stages.append(py::make_tuple(stage.threshold, weak));
                               }
                               return stages;
                             })
      .def(
          "judge",
          [](const HaarCascade& cascade, const WindowSet& windows) {
            py::list verdicts;
            for (std::size_t i = 0; i < windows.size(); ++i) {
              const auto diagonal = IntegralImage::Diagonal::kWith;
              const WindowVerdict verdict = judge_window(cascade, IntegralImage(windows[i], diagonal), {0, 0});
              verdicts.append(py::make_tuple(verdict.stages_passed, verdict.score));
            }
            return verdicts;
          },
          py::arg("windows"), "Stages passed (-1: too flat) and score of every window.");
}

void add_training(py::module_& module) {
  module.def(
      "thesis_plan", [] { return rows_of(thesis_plan()); },
      "Rows of detection rate, false positive rate, most features, false alarm rate.");
  module.def(
      "uniform_plan",
      [](int layers, double detection_rate, double false_positive_rate, int max_features) {
        return rows_of(uniform_plan(layers, detection_rate, false_positive_rate, max_features));
      },
      py::arg("layers"), py::arg("detection_rate"), py::arg("false_positive_rate"), py::arg("max_features"));
  module.def(
      "mine_negatives",
      [](const std::optional<HaarCascade>& cascade, int width, int height, std::size_t images, const py::object& read, std::size_t wanted,
         double scale_factor, int seed, const std::string& name, int threads) {
        HaarCascade nothing;
        nothing.window = {width, height};
        const NegativeImages source = negative_images(images, read);
        std::optional<MinedNegatives> mined;
        {
          const py::gil_scoped_release unlocked;
          mined = mine_negatives(cascade ? *cascade : nothing, source, wanted, scale_factor, Rng(static_cast<std::uint64_t>(seed)), name,
                                 threads);
        }
        return py::make_tuple(std::move(mined->windows), mined->windows_looked_at, mined->windows_passed, mined->images_missing);
      },
      py::arg("cascade"), py::arg("width"), py::arg("height"), py::arg("images"), py::arg("read"), py::arg("wanted"),
      py::arg("scale_factor") = 1.25, py::arg("seed") = 1, py::arg("name") = "mining", py::arg("threads") = 1,
      "Windows without object that pass the cascade (None: any), how many were looked at, how many passed, how many pictures were "
      "missing.");
  module.def(
      "train_cascade",
      [](const WindowSet& positives, const std::optional<WindowSet>& validation_positives, const std::optional<WindowSet>& negatives,
         const std::optional<WindowSet>& validation_negatives, std::size_t images, const py::object& read, const std::string& images_digest,
         const std::vector<std::tuple<double, double, int, double>>& plan, const py::dict& config, int threads,
         const std::optional<std::string>& checkpoint, bool resume, const py::object& progress) {
        const WindowSet none(positives.window());
        const CascadeTrainingData data{positives,
                                       validation_positives.value_or(none),
                                       negatives.value_or(none),
                                       validation_negatives.value_or(none),
                                       negative_images(images, read),
                                       images_digest};
        const auto settings = config_from<CascadeTrainerConfig>(config);
        TrainingProgressSink sink;
        if (!progress.is_none()) {
          sink = [&progress](const TrainingProgress& at) {
            const py::gil_scoped_acquire lock;
            if (PyErr_CheckSignals() != 0) return false;
            const py::object answer = progress(at.layer, at.layers, at.doing, at.features, at.max_features, at.fraction);
            return answer.is_none() || answer.cast<bool>();
          };
        }
        const py::gil_scoped_release unlocked;
        return train_cascade(data, plan_of(plan), settings, threads, checkpoint, resume, sink);
      },
      py::arg("positives"), py::arg("validation_positives") = py::none(), py::arg("negatives") = py::none(),
      py::arg("validation_negatives") = py::none(), py::arg("images") = 0, py::arg("read") = py::none(), py::arg("images_digest") = "",
      py::arg("plan"), py::arg("config") = py::dict(), py::arg("threads") = 1, py::arg("checkpoint") = py::none(),
      py::arg("resume") = false, py::arg("progress") = py::none(),
      "read(index) gives a picture, a pair of picture and mask, or None; progress(layer, layers, doing, features, most features, fraction) "
      "stops by False.");
}

template <class Config>
py::list fields() {
  FieldLister lister;
  Config config;
  config.visit(lister);
  return lister.fields();
}

template <class Config>
std::vector<std::string> all_violations(const py::dict& values) {
  return violations(config_from<Config>(values));
}

}  // namespace

void add_cascade(py::module_& module) {
  add_windows(module);
  add_model(module);
  add_training(module);
  module.def(
      "check_plan", [](const std::vector<std::tuple<double, double, int, double>>& plan) { check_plan(plan_of(plan)); }, py::arg("plan"));
  module.def(
      "split_by_recording",
      [](const std::vector<int>& recordings, double validation_fraction, int seed) {
        SampleSplit split = split_by_recording(recordings, validation_fraction, Rng(static_cast<std::uint64_t>(seed)));
        return std::make_pair(std::move(split.training), std::move(split.validation));
      },
      py::arg("recordings"), py::arg("validation_fraction"), py::arg("seed") = 1, "Indices of training and of validation samples.");
  module.def(
      "in_8_bits",
      [](const py::array& image, const std::optional<py::array>& valid) { return array_of(in_8_bits(image_of(image, valid)).intensity); },
      py::arg("image"), py::arg("valid") = py::none(), "As it is if it has 8 bits, otherwise its valid range drawn out to 0..255.");
  module.def("validate_cascade_trainer", &all_violations<CascadeTrainerConfig>, py::arg("values"));
  module.def("validate_cascade_detector", &all_violations<CascadeDetectorConfig>, py::arg("values"));
  module.def("validate_augmentation", &all_violations<AugmentationConfig>, py::arg("values"));
  module.def("cascade_trainer_fields", &fields<CascadeTrainerConfig>);
  module.def("cascade_detector_fields", &fields<CascadeDetectorConfig>);
  module.def("augmentation_fields", &fields<AugmentationConfig>);
  module.def(
      "detect_objects",
      [](const HaarCascade& cascade, const py::array& image, const std::optional<py::array>& valid, const py::dict& config, int threads) {
        const SonarImage picture = image_of(image, valid);
        const auto settings = config_from<CascadeDetectorConfig>(config);
        const CascadeDetector detector(cascade, settings);
        std::vector<Detection> detections;
        {
          const py::gil_scoped_release unlocked;
          detections = detector.detect(picture, threads);
        }
        return rows_of(detections, settings.verify);
      },
      py::arg("cascade"), py::arg("image"), py::arg("valid") = py::none(), py::arg("config") = py::dict(), py::arg("threads") = 1,
      "n x 6: x, y, width, height (px), score, windows in the group; best score first. With "
      "verify='contour' n x 8: the contour's distance from the known ones, NaN without an echo, and its score.");
  module.def(
      "haar_features",
      [](const std::string& set, int width, int height) {
        CascadeTrainerConfig config = config_from<CascadeTrainerConfig>(py::dict(py::arg("feature_set") = set));
        return features_of(enumerate_features(config.feature_set, {width, height}));
      },
      py::arg("set"), py::arg("width"), py::arg("height"), "Every feature of a set: (tilted, [(x, y, width, height, weight), ...]).");
  module.def(
      "contour_signature", [](const py::array& mask) { return signature_of(contour_signature(view(mask, "mask"))); }, py::arg("mask"),
      "Distances from the boundary to the centroid (mean 1) and the magnitudes of their harmonics; None without a region.");
  module.def(
      "echo_signature",
      [](const py::array& image, const std::array<int, 4>& box, const std::optional<py::array>& valid) {
        return signature_of(echo_signature(image_of(image, valid), {box[0], box[1], box[2], box[3]}));
      },
      py::arg("image"), py::arg("box"), py::arg("valid") = py::none(), "As contour_signature, of the echo in a box; None without one.");
  module.def(
      "echo_mask",
      [](const py::array& image, const std::array<int, 4>& box, const std::optional<py::array>& valid) -> py::object {
        const auto mask = echo_mask(image_of(image, valid), {box[0], box[1], box[2], box[3]});
        return mask ? py::object(array_of(*mask)) : py::none();
      },
      py::arg("image"), py::arg("box"), py::arg("valid") = py::none(),
      "The echo in a box, its longer side 64 pixels: 255 where it is. None where all is of one level.");
}

}  // namespace ssjs::bindings
