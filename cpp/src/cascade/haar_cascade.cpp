#include "ssjs/cascade/haar_cascade.hpp"

#include <algorithm>
#include <cmath>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

std::string text(int number) { return std::to_string(number); }

void check_tree(const WeakClassifier& tree, int features, const std::string& name) {
  const int nodes = static_cast<int>(tree.nodes.size());
  const int leaves = static_cast<int>(tree.leaves.size());
  if (nodes == 0) throw InvalidArgument(name, "no node", "must have at least one");
  if (leaves != nodes + 1) throw InvalidArgument(name, text(leaves) + " leaves", "must be one more than its " + text(nodes) + " nodes");
  for (const float leaf : tree.leaves)
    if (!std::isfinite(leaf)) throw InvalidArgument(name, leaf, "leaves must be finite");
  for (int i = 0; i < nodes; ++i) {
    const TreeNode& node = tree.nodes[static_cast<std::size_t>(i)];
    if (!std::isfinite(node.threshold)) throw InvalidArgument(name, node.threshold, "thresholds must be finite");
    if (node.feature < 0 || node.feature >= features)
      throw InvalidArgument(name, text(node.feature), "must name one of the " + text(features) + " features");
    for (const int child : {node.left, node.right}) {
      const bool follows = child > 0 && child > i && child < nodes;
      const bool is_leaf = child <= 0 && child > -leaves;
      if (!follows && !is_leaf) throw InvalidArgument(name, text(child), "must be a leaf of the tree or a node after its parent");
    }
  }
}

}  // namespace

void check_cascade(const HaarCascade& cascade) {
  constexpr int kLargestSide = 4096;
  const cv::Size window = cascade.window;
  if (window.width < 3 || window.height < 3 || window.width > kLargestSide || window.height > kLargestSide)
    throw InvalidArgument("window", text(window.width) + " x " + text(window.height), "must be 3 to 4096 pixels wide and high");
  for (std::size_t i = 0; i < cascade.features.size(); ++i) {
    try {
      check_feature(cascade.features[i], window);
    } catch (const InvalidArgument& error) {
      throw InvalidArgument("feature " + std::to_string(i), error.what(), "every feature must lie in the window");
    }
  }
  if (cascade.stages.empty()) throw InvalidArgument("stages", "none", "must be at least one");
  for (std::size_t s = 0; s < cascade.stages.size(); ++s) {
    const CascadeStage& stage = cascade.stages[s];
    const std::string name = "stage " + std::to_string(s);
    if (stage.weak.empty()) throw InvalidArgument(name, "no weak classifier", "must have at least one");
    if (!std::isfinite(stage.threshold)) throw InvalidArgument(name, stage.threshold, "its threshold must be finite");
    for (std::size_t i = 0; i < stage.weak.size(); ++i)
      check_tree(stage.weak[i], static_cast<int>(cascade.features.size()), name + ", weak classifier " + std::to_string(i));
  }
  if (cascade.contour) check_contour_reference(*cascade.contour);
}

HaarCascade mirrored(const HaarCascade& cascade) {
  HaarCascade mirror = cascade;
  for (std::size_t i = 0; i < mirror.features.size(); ++i) {
    const auto feature = mirrored(cascade.features[i], cascade.window);
    if (!feature)
      throw InvalidArgument("feature " + std::to_string(i), "tilted, at the left border",
                            "has no mirror image; mirror the pictures instead");
    mirror.features[i] = *feature;
  }
  return mirror;
}

float pass_mark(const CascadeStage& stage) { return stage.threshold - 1e-5F; }

double stage_sum(const CascadeStage& stage, const std::vector<HaarFeature>& features, const IntegralImage& image, cv::Point top_left,
                 float norm) {
  double sum = 0;
  for (const WeakClassifier& tree : stage.weak) {
    int next = 0;
    do {
      const TreeNode& node = tree.nodes[static_cast<std::size_t>(next)];
      const float value = feature_value(features[static_cast<std::size_t>(node.feature)], image, top_left, norm);
      next = value < node.threshold ? node.left : node.right;
    } while (next > 0);
    sum += static_cast<double>(tree.leaves[static_cast<std::size_t>(-next)]);
  }
  return sum;
}

WindowVerdict judge_window(const HaarCascade& cascade, const IntegralImage& image, cv::Point top_left) {
  WindowVerdict verdict;
  const auto norm = normalisation(image, top_left, cascade.window);
  if (!norm) return {-1, 0};
  for (const CascadeStage& stage : cascade.stages) {
    const double margin = stage_sum(stage, cascade.features, image, top_left, *norm) - static_cast<double>(pass_mark(stage));
    verdict.score += margin;
    if (margin < 0) break;
    ++verdict.stages_passed;
  }
  return verdict;
}

}  // namespace ssjs
