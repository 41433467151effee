/// Cascades of random features, stumps and trees, with thresholds that let about half of all windows pass.
#pragma once

#include <cmath>

#include "ssjs/base/random.hpp"
#include "ssjs/cascade/haar_cascade.hpp"

namespace ssjs {

inline HaarCascade random_cascade(cv::Size window, FeatureSet set, int stages, int most_nodes, Rng& rng) {
  const auto all = enumerate_features(set, window);
  HaarCascade cascade;
  cascade.window = window;
  for (int s = 0; s < stages; ++s) {
    CascadeStage stage;
    for (int w = 0; w < 3 + s; ++w) {
      WeakClassifier tree;
      const int nodes = 1 + static_cast<int>(rng.below(static_cast<std::uint64_t>(most_nodes)));
      for (int n = 0; n < nodes; ++n) {
        // a chain: each node has one leaf, the last one two
        const bool last = n + 1 == nodes;
        TreeNode node{static_cast<int>(cascade.features.size()), static_cast<float>(0.02 * rng.normal()), -n, last ? -(n + 1) : n + 1};
        if (rng.uniform() < 0.5) std::swap(node.left, node.right);
        tree.nodes.push_back(node);
        cascade.features.push_back(all[rng.below(all.size())]);
      }
      for (int n = 0; n <= nodes; ++n) tree.leaves.push_back(static_cast<float>(rng.normal()));
      stage.weak.push_back(tree);
    }
    stage.threshold = static_cast<float>(0.3 * rng.normal());
    cascade.stages.push_back(stage);
  }
  return cascade;
}

}  // namespace ssjs
