#include "ssjs/cascade/cascade_xml.hpp"

#include <charconv>
#include <cmath>
#include <cstdint>
#include <pugixml.hpp>
#include <vector>

#include "ssjs/base/error.hpp"
#include "ssjs/base/whole_file.hpp"

namespace ssjs {
namespace {

constexpr std::int64_t kMostBytes = std::int64_t{1} << 26U;  // OpenCV's largest is 3 MB
constexpr std::size_t kMostItems = 1000000;                  // stages, weak classifiers, nodes, features

/// Walks one document; every complaint carries the place it is about.
class Reader {
 public:
  Reader(std::string_view xml, std::string name) : name_(std::move(name)) {
    const pugi::xml_parse_result parsed = document_.load_buffer(xml.data(), xml.size(), pugi::parse_default, pugi::encoding_utf8);
    if (!parsed) throw FileError(name_, parsed.offset, "at byte " + std::to_string(parsed.offset) + ": " + parsed.description());
  }

  HaarCascade read() {
    const pugi::xml_node storage = document_.child("opencv_storage");
    if (!storage) throw FileError(name_, 0, "at byte 0: no <opencv_storage>: this is no file of OpenCV's");
    pugi::xml_node root = storage.first_child();
    while (root && root.type() != pugi::node_element) root = root.next_sibling();
    if (!root) fail(storage, "<opencv_storage> holds nothing");
    if (!root.child("stageType"))
      fail(root, "no <stageType>: OpenCV's older Haar form is not read; opencv_traincascade and OpenCV 3 and 4 write the newer one");
    expect_text(root, "stageType", "BOOST");
    expect_text(root, "featureType", "HAAR");
    HaarCascade cascade;
    cascade.window = {integer(child(root, "width")), integer(child(root, "height"))};
    const pugi::xml_node parameters = child(root, "featureParams");
    const pugi::xml_node categories = parameters.child("maxCatCount");
    if (categories && integer(categories) != 0) fail(categories, "categorical features are not Haar features");
    read_features(child(root, "features"), cascade);
    for (const pugi::xml_node stage : child(root, "stages").children("_")) {
      bound(stage, cascade.stages.size());
      cascade.stages.push_back(read_stage(stage));
    }
    try {
      check_cascade(cascade);
    } catch (const InvalidArgument& error) {
      fail(root, error.what());
    }
    return cascade;
  }

 private:
  [[noreturn]] void fail(const pugi::xml_node& node, const std::string& what) const {
    const auto offset = node.offset_debug();
    throw FileError(name_, offset, "at byte " + std::to_string(offset) + ": " + what);
  }
  void bound(const pugi::xml_node& node, std::size_t count) const {
    if (count >= kMostItems) fail(node, "more than " + std::to_string(kMostItems) + " <" + node.name() + "> in a row");
  }
  pugi::xml_node child(const pugi::xml_node& node, const char* name) const {
    const pugi::xml_node found = node.child(name);
    if (!found) fail(node, std::string("no <") + name + "> in <" + node.name() + ">");
    return found;
  }
  void expect_text(const pugi::xml_node& node, const char* name, const std::string& expected) const {
    const pugi::xml_node found = child(node, name);
    if (expected != found.text().get())
      fail(found, std::string("<") + name + "> is '" + found.text().get() + "'; only " + expected + " is read");
  }

  /// The numbers of a node's text, apart from each other by white space.
  std::vector<double> numbers(const pugi::xml_node& node) const {
    std::vector<double> found;
    const std::string_view text = node.text().get();
    const char* at = text.data();
    const char* const end = at + text.size();
    while (true) {
      while (at != end && (*at == ' ' || *at == '\n' || *at == '\t' || *at == '\r')) ++at;
      if (at == end) return found;
      if (*at == '+') ++at;
      double value = 0;
      const auto [next, error] = std::from_chars(at, end, value);
      if (error != std::errc() || !std::isfinite(value))
        fail(node, std::string("'") + std::string(at, static_cast<std::size_t>(std::min<std::ptrdiff_t>(end - at, 24))) + "' in <" +
                       node.name() + "> is no number");
      bound(node, found.size());
      found.push_back(value);
      at = next;
    }
  }
  int as_integer(const pugi::xml_node& node, double value) const {
    constexpr double kLargest = 2147483647.0;
    if (!(std::abs(value) <= kLargest) || value != std::floor(value))
      fail(node, std::string("<") + node.name() + "> must hold a whole number");
    return static_cast<int>(value);
  }
  float as_float(const pugi::xml_node& node, double value) const {
    const auto narrow = static_cast<float>(value);
    if (!std::isfinite(narrow)) fail(node, std::string("a number in <") + node.name() + "> is too large");
    return narrow;
  }
  double number(const pugi::xml_node& node) const {
    const auto found = numbers(node);
    if (found.size() != 1) fail(node, std::string("<") + node.name() + "> must hold one number");
    return found[0];
  }
  int integer(const pugi::xml_node& node) const { return as_integer(node, number(node)); }

  void read_features(const pugi::xml_node& list, HaarCascade& cascade) const {
    for (const pugi::xml_node entry : list.children("_")) {
      bound(entry, cascade.features.size());
      HaarFeature feature;
      std::size_t count = 0;
      for (const pugi::xml_node rect : child(entry, "rects").children("_")) {
        const auto n = numbers(rect);
        if (n.size() != 5) fail(rect, "a rectangle is x y width height weight");
        if (count == feature.rects.size()) fail(rect, "a feature has at most 3 rectangles");
        feature.rects[count++] = {{as_integer(rect, n[0]), as_integer(rect, n[1]), as_integer(rect, n[2]), as_integer(rect, n[3])},
                                  as_float(rect, n[4])};
      }
      if (count == 0) fail(entry, "a feature has at least one rectangle");
      if (entry.child("tilted")) feature.tilted = integer(entry.child("tilted")) != 0;
      try {
        check_feature(feature, cascade.window);
      } catch (const InvalidArgument& error) {
        fail(entry, error.what());
      }
      cascade.features.push_back(feature);
    }
  }

  CascadeStage read_stage(const pugi::xml_node& node) const {
    CascadeStage stage;
    stage.threshold = as_float(node, number(child(node, "stageThreshold")));
    for (const pugi::xml_node entry : child(node, "weakClassifiers").children("_")) {
      bound(entry, stage.weak.size());
      const pugi::xml_node inner = child(entry, "internalNodes");
      const auto n = numbers(inner);
      if (n.empty() || n.size() % 4 != 0) fail(inner, "a node is left right feature threshold");
      WeakClassifier tree;
      for (std::size_t i = 0; i < n.size(); i += 4)
        tree.nodes.push_back(
            {as_integer(inner, n[i + 2]), as_float(inner, n[i + 3]), as_integer(inner, n[i]), as_integer(inner, n[i + 1])});
      const pugi::xml_node leaves = child(entry, "leafValues");
      for (const double value : numbers(leaves)) tree.leaves.push_back(as_float(leaves, value));
      stage.weak.push_back(std::move(tree));
    }
    return stage;
  }

  std::string name_;
  pugi::xml_document document_;
};

/// Shortest text that reads back as the same number, whether as single or as double precision.
std::string text(float value) {
  char buffer[32];
  const auto [end, error] = std::to_chars(buffer, buffer + sizeof buffer, static_cast<double>(value));
  std::string written(buffer, error == std::errc() ? end : buffer);
  // OpenCV tells whole from other numbers by the point
  if (written.find_first_of(".en") == std::string::npos) written += '.';
  return written;
}

void append(pugi::xml_node parent, const char* name, const std::string& value) { parent.append_child(name).text().set(value.c_str()); }
void append(pugi::xml_node parent, const char* name, std::size_t value) { append(parent, name, std::to_string(value)); }

struct StringWriter : pugi::xml_writer {
  void write(const void* data, std::size_t size) override { content.append(static_cast<const char*>(data), size); }
  std::string content;
};

}  // namespace

std::string to_opencv_xml(const HaarCascade& cascade) {
  check_cascade(cascade);
  pugi::xml_document document;
  pugi::xml_node declaration = document.append_child(pugi::node_declaration);
  declaration.append_attribute("version") = "1.0";
  pugi::xml_node root = document.append_child("opencv_storage").append_child("cascade");
  root.append_attribute("type_id") = "opencv-cascade-classifier";
  append(root, "stageType", "BOOST");
  append(root, "featureType", "HAAR");
  append(root, "height", std::to_string(cascade.window.height));
  append(root, "width", std::to_string(cascade.window.width));
  std::size_t most_weak = 0;
  std::size_t depth = 1;
  for (const CascadeStage& stage : cascade.stages) {
    most_weak = std::max(most_weak, stage.weak.size());
    for (const WeakClassifier& tree : stage.weak) depth = std::max(depth, tree.nodes.size());
  }
  pugi::xml_node stage_parameters = root.append_child("stageParams");
  append(stage_parameters, "maxDepth", depth);
  append(stage_parameters, "maxWeakCount", most_weak);
  pugi::xml_node feature_parameters = root.append_child("featureParams");
  append(feature_parameters, "maxCatCount", std::size_t{0});
  append(feature_parameters, "featSize", std::size_t{1});
  append(feature_parameters, "mode", "ALL");
  append(root, "stageNum", cascade.stages.size());
  pugi::xml_node stages = root.append_child("stages");
  for (const CascadeStage& stage : cascade.stages) {
    pugi::xml_node node = stages.append_child("_");
    append(node, "maxWeakCount", stage.weak.size());
    append(node, "stageThreshold", text(stage.threshold));
    pugi::xml_node weak = node.append_child("weakClassifiers");
    for (const WeakClassifier& tree : stage.weak) {
      std::string nodes;
      std::string leaves;
      for (const TreeNode& n : tree.nodes)
        nodes += (nodes.empty() ? "" : " ") + std::to_string(n.left) + " " + std::to_string(n.right) + " " + std::to_string(n.feature) +
                 " " + text(n.threshold);
      for (const float leaf : tree.leaves) leaves += (leaves.empty() ? "" : " ") + text(leaf);
      pugi::xml_node entry = weak.append_child("_");
      append(entry, "internalNodes", nodes);
      append(entry, "leafValues", leaves);
    }
  }
  pugi::xml_node features = root.append_child("features");
  for (const HaarFeature& feature : cascade.features) {
    pugi::xml_node entry = features.append_child("_");
    pugi::xml_node rects = entry.append_child("rects");
    for (const WeightedRect& part : feature.rects) {
      if (part.weight == 0 && part.rect == cv::Rect()) continue;
      append(rects, "_",
             std::to_string(part.rect.x) + " " + std::to_string(part.rect.y) + " " + std::to_string(part.rect.width) + " " +
                 std::to_string(part.rect.height) + " " + text(part.weight));
    }
    append(entry, "tilted", feature.tilted ? "1" : "0");
  }
  StringWriter writer;
  document.save(writer, " ", pugi::format_indent, pugi::encoding_utf8);
  return writer.content;
}

HaarCascade from_opencv_xml(std::string_view xml, const std::string& name) { return Reader(xml, name).read(); }

HaarCascade read_opencv_xml(const std::string& path) { return from_opencv_xml(read_whole_file(path, kMostBytes), path); }

void write_opencv_xml(const HaarCascade& cascade, const std::string& path) { write_whole_file(path, to_opencv_xml(cascade)); }

}  // namespace ssjs
