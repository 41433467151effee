#include "ssjs/cascade/followed_windows.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace ssjs {

void StageSums::add(const MovableStump& stump, const std::vector<float>& values) {
  for (std::size_t m = 0; m < sums_.size(); ++m)
    for (std::size_t i = 0; i < values.size(); ++i)
      sums_[m][i] += static_cast<double>(values[i] < stump.thresholds[m] ? stump.left : stump.right);
}

FollowedWindows::FollowedWindows(const WindowSet& windows, WindowSums::Diagonal diagonal)
    : windows_(windows, diagonal), standing_(windows.size()), sums_(0, 0) {
  for (std::size_t i = 0; i < standing_.size(); ++i) standing_[i] = !windows_.is_flat(i);
}

void FollowedWindows::add(const MovableStump& stump) {
  values_.resize(standing_.size());
  windows_.values(stump.feature, values_.data());
  sums_.add(stump, values_);
}

void FollowedWindows::pass(const CascadeStage& stage, const std::vector<HaarFeature>& features) {
  begin_layer(1);
  for (const WeakClassifier& stump : stage.weak) {
    const TreeNode& node = stump.nodes[0];
    add({features[static_cast<std::size_t>(node.feature)], {node.threshold}, stump.leaves[0], stump.leaves[1]});
  }
  const auto mark = static_cast<double>(pass_mark(stage));
  for (std::size_t i = 0; i < standing_.size(); ++i) standing_[i] = standing_[i] && sums_.of_move(0)[i] >= mark;
}

double FollowedWindows::rate() const {
  return static_cast<double>(std::count(standing_.begin(), standing_.end(), true)) / static_cast<double>(standing_.size());
}

double FollowedWindows::rate_at(float mark, std::size_t move) const {
  const std::vector<double>& sums = sums_.of_move(move);
  std::size_t passed = 0;
  for (std::size_t i = 0; i < sums.size(); ++i) passed += standing_[i] && sums[i] >= static_cast<double>(mark) ? 1 : 0;
  return static_cast<double>(passed) / static_cast<double>(sums.size());
}

float FollowedWindows::threshold_for(double rate, std::size_t move) const {
  std::vector<double> sums;
  for (std::size_t i = 0; i < standing_.size(); ++i)
    if (standing_[i]) sums.push_back(sums_.of_move(move)[i]);
  if (sums.empty()) return 0;
  const auto needed = static_cast<std::size_t>(std::ceil(rate * static_cast<double>(standing_.size()) - 1e-9));
  const auto place = sums.begin() + static_cast<std::ptrdiff_t>(std::clamp<std::size_t>(needed, 1, sums.size()) - 1);
  std::nth_element(sums.begin(), place, sums.end(), std::greater<>());
  const auto threshold = static_cast<float>(*place);
  return static_cast<double>(threshold) <= *place ? threshold : std::nextafter(threshold, -INFINITY);
}

std::vector<std::size_t> FollowedWindows::standing() const {
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < standing_.size(); ++i)
    if (standing_[i]) indices.push_back(i);
  return indices;
}

}  // namespace ssjs
