/// Windows with and without an object, and every feature of them: what the searches for stumps are tried on.
#pragma once

#include <cstdint>
#include <vector>

#include "cascade/speckle.hpp"
#include "ssjs/cascade/haar_feature.hpp"
#include "ssjs/cascade/window_set.hpp"

namespace ssjs {

struct Problem {
  std::vector<HaarFeature> features;
  WindowSet positives;
  WindowSet negatives;
};

inline Problem make_problem(cv::Size window, FeatureSet set, int positives, int negatives, std::uint64_t seed) {
  Rng rng(seed);
  Problem problem{enumerate_features(set, window), WindowSet(window), WindowSet(window)};
  for (int i = 0; i < positives; ++i) {
    cv::Mat picture = speckle(window, rng);
    draw_object(picture, {0, 0, window.width, window.height}, rng);
    problem.positives.add(picture);
  }
  for (int i = 0; i < negatives; ++i) problem.negatives.add(speckle(window, rng));
  return problem;
}

}  // namespace ssjs
