#include "ssjs/cascade/cascade_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <utility>

#include "ssjs/base/error.hpp"
#include "ssjs/base/whole_file.hpp"
#include "ssjs/cascade/cascade_xml.hpp"

namespace ssjs {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "ssjs-haar-cascade";
constexpr int kVersion = 1;
constexpr std::int64_t kMostBytes = std::int64_t{1} << 26U;

[[noreturn]] void fail(const std::string& where, const std::string& what) {
  throw InvalidArgument(where, what, "this is no whole cascade model");
}

const Json& member(const Json& object, const std::string& key, const std::string& where) {
  if (!object.is_object() || !object.contains(key)) fail(where, "no '" + key + "'");
  return object.at(key);
}
const Json& list(const Json& object, const std::string& key, const std::string& where) {
  const Json& found = member(object, key, where);
  if (!found.is_array()) fail(where + "." + key, "not a list");
  return found;
}
double number(const Json& value, const std::string& where) {
  if (!value.is_number()) fail(where, "not a number");
  return value.get<double>();
}
float narrow(const Json& value, const std::string& where) {
  const auto found = static_cast<float>(number(value, where));
  if (!std::isfinite(found)) fail(where, "not a finite number");
  return found;
}
int integer(const Json& value, const std::string& where) {
  const double found = number(value, where);
  if (!(std::abs(found) <= 2147483647.0) || found != std::floor(found)) fail(where, "not a whole number");
  return static_cast<int>(found);
}
std::string string(const Json& value, const std::string& where) {
  if (!value.is_string()) fail(where, "not a text");
  return value.get<std::string>();
}
std::string at(const std::string& name, std::size_t index) { return name + "[" + std::to_string(index) + "]"; }

Json feature_json(const HaarFeature& feature) {
  Json rects = Json::array();
  for (const WeightedRect& part : feature.rects)
    if (!(part.weight == 0 && part.rect == cv::Rect()))
      rects.push_back({part.rect.x, part.rect.y, part.rect.width, part.rect.height, static_cast<double>(part.weight)});
  return {{"tilted", feature.tilted}, {"rects", rects}};
}

HaarFeature feature_from(const Json& json, const std::string& where) {
  HaarFeature feature;
  const Json& tilted = member(json, "tilted", where);
  if (!tilted.is_boolean()) fail(where + ".tilted", "neither true nor false");
  feature.tilted = tilted.get<bool>();
  const Json& rects = list(json, "rects", where);
  if (rects.empty() || rects.size() > feature.rects.size()) fail(where, "not one to three rectangles");
  for (std::size_t i = 0; i < rects.size(); ++i) {
    const Json& rect = rects[i];
    const std::string here = where + "." + at("rects", i);
    if (!rect.is_array() || rect.size() != 5) fail(here, "not [x, y, width, height, weight]");
    feature.rects[i] = {{integer(rect[0], here), integer(rect[1], here), integer(rect[2], here), integer(rect[3], here)},
                        narrow(rect[4], here)};
  }
  return feature;
}

Json stage_json(const CascadeStage& stage) {
  Json weak = Json::array();
  for (const WeakClassifier& tree : stage.weak) {
    Json nodes = Json::array();
    for (const TreeNode& node : tree.nodes) nodes.push_back({node.feature, static_cast<double>(node.threshold), node.left, node.right});
    Json leaves = Json::array();
    for (const float leaf : tree.leaves) leaves.push_back(static_cast<double>(leaf));
    weak.push_back({{"nodes", nodes}, {"leaves", leaves}});
  }
  return {{"threshold", static_cast<double>(stage.threshold)}, {"weak", weak}};
}

CascadeStage stage_from(const Json& json, const std::string& where) {
  CascadeStage stage;
  stage.threshold = narrow(member(json, "threshold", where), where + ".threshold");
  const Json& weak = list(json, "weak", where);
  for (std::size_t i = 0; i < weak.size(); ++i) {
    const std::string here = where + "." + at("weak", i);
    WeakClassifier tree;
    for (const Json& node : list(weak[i], "nodes", here)) {
      if (!node.is_array() || node.size() != 4) fail(here, "a node is not [feature, threshold, left, right]");
      tree.nodes.push_back({integer(node[0], here), narrow(node[1], here), integer(node[2], here), integer(node[3], here)});
    }
    for (const Json& leaf : list(weak[i], "leaves", here)) tree.leaves.push_back(narrow(leaf, here));
    stage.weak.push_back(std::move(tree));
  }
  return stage;
}

Json provenance_json(const Provenance& provenance) {
  Json settings = Json::object();
  for (const auto& [key, value] : provenance.settings) settings[key] = value;
  Json layers = Json::array();
  for (const LayerRecord& layer : provenance.layers)
    layers.push_back({{"features", layer.features},
                      {"detection_rate", layer.detection_rate},
                      {"false_positive_rate", layer.false_positive_rate},
                      {"target_detection_rate", layer.target_detection_rate},
                      {"target_false_positive_rate", layer.target_false_positive_rate},
                      {"negatives", layer.negatives},
                      {"negatives_looked_at", layer.negatives_looked_at}});
  return {{"trained_with", provenance.trained_with},
          {"settings", settings},
          {"layers", layers},
          {"stopped_because", provenance.stopped_because}};
}

Provenance provenance_from(const Json& json) {
  const std::string where = "provenance";
  Provenance provenance;
  provenance.trained_with = string(member(json, "trained_with", where), where + ".trained_with");
  const Json& settings = member(json, "settings", where);
  if (!settings.is_object()) fail(where + ".settings", "not a table");
  const std::string prefix = where + ".settings.";
  for (const auto& [key, value] : settings.items()) provenance.settings.emplace_back(key, string(value, std::string(prefix).append(key)));
  const Json& layers = list(json, "layers", where);
  for (std::size_t i = 0; i < layers.size(); ++i) {
    const std::string here = where + "." + at("layers", i);
    const auto real = [&](const char* key) { return number(member(layers[i], key, here), here); };
    provenance.layers.push_back({integer(member(layers[i], "features", here), here), real("detection_rate"), real("false_positive_rate"),
                                 real("target_detection_rate"), real("target_false_positive_rate"),
                                 integer(member(layers[i], "negatives", here), here), real("negatives_looked_at")});
  }
  provenance.stopped_because = string(member(json, "stopped_because", where), where + ".stopped_because");
  return provenance;
}

std::vector<double> numbers(const Json& object, const std::string& key, const std::string& where) {
  std::vector<double> found;
  const std::string here = where + "." + key;
  for (const Json& value : list(object, key, where)) found.push_back(number(value, here));
  return found;
}

ContourReference contour_from(const Json& json) {
  const std::string where = "contour";
  ContourReference reference;
  for (auto [key, spectrum] : {std::pair("mean", &reference.mean), std::pair("deviation", &reference.deviation)}) {
    const std::vector<double> harmonics = numbers(json, key, where);
    if (harmonics.size() != spectrum->size()) fail(where + "." + key, "not " + std::to_string(spectrum->size()) + " harmonics");
    std::copy(harmonics.begin(), harmonics.end(), spectrum->begin());
  }
  reference.distances = numbers(json, "distances", where);
  return reference;
}

HaarCascade cascade_from(const Json& root) {
  if (string(member(root, "format", "file"), "format") != kFormat) fail("format", string(root.at("format"), "format"));
  const int version = integer(member(root, "version", "file"), "version");
  if (version != kVersion)
    throw InvalidArgument("version", version, "this program reads version " + std::to_string(kVersion) + "; update it, or train anew");
  HaarCascade cascade;
  const Json& window = list(root, "window", "file");
  if (window.size() != 2) fail("window", "not [width, height]");
  cascade.window = {integer(window[0], "window"), integer(window[1], "window")};
  const Json& features = list(root, "features", "file");
  for (std::size_t i = 0; i < features.size(); ++i) cascade.features.push_back(feature_from(features[i], at("features", i)));
  const Json& stages = list(root, "stages", "file");
  for (std::size_t i = 0; i < stages.size(); ++i) cascade.stages.push_back(stage_from(stages[i], at("stages", i)));
  cascade.provenance = provenance_from(member(root, "provenance", "file"));
  if (root.contains("contour")) cascade.contour = contour_from(root.at("contour"));
  check_cascade(cascade);
  return cascade;
}

}  // namespace

std::string to_json(const HaarCascade& cascade) {
  check_cascade(cascade);
  Json features = Json::array();
  for (const HaarFeature& feature : cascade.features) features.push_back(feature_json(feature));
  Json stages = Json::array();
  for (const CascadeStage& stage : cascade.stages) stages.push_back(stage_json(stage));
  Json root = {{"format", kFormat},
               {"version", kVersion},
               {"window", {cascade.window.width, cascade.window.height}},
               {"provenance", provenance_json(cascade.provenance)}};
  if (cascade.contour)
    root["contour"] = {
        {"mean", cascade.contour->mean}, {"deviation", cascade.contour->deviation}, {"distances", cascade.contour->distances}};
  root["stages"] = stages;
  root["features"] = features;
  return root.dump(1) + "\n";
}

HaarCascade from_json(std::string_view json, const std::string& name) {
  Json root;
  try {
    root = Json::parse(json);
  } catch (const Json::parse_error& error) {
    throw FileError(name, static_cast<std::int64_t>(error.byte),
                    "at byte " + std::to_string(error.byte) + ": no JSON, or cut off: " + error.what());
  } catch (const Json::out_of_range& error) {
    throw FileError(name, 0, std::string("holds a number that is too large: ") + error.what());
  }
  try {
    return cascade_from(root);
  } catch (const InvalidArgument& error) {
    throw FileError(name, 0, error.what());
  }
}

HaarCascade load_cascade(const std::string& path) {
  const std::string content = read_whole_file(path, kMostBytes);
  const std::size_t first = content.find_first_not_of(" \t\r\n\xef\xbb\xbf");
  if (first != std::string::npos && content[first] == '<') return from_opencv_xml(content, path);
  return from_json(content, path);
}

void save_cascade(const HaarCascade& cascade, const std::string& path) {
  constexpr std::string_view kXml = ".xml";
  const bool as_xml = path.size() > kXml.size() && path.compare(path.size() - kXml.size(), kXml.size(), kXml) == 0;
  write_whole_file(path, as_xml ? to_opencv_xml(cascade) : to_json(cascade));
}

}  // namespace ssjs
