#include "ssjs/cascade/rejecting_stumps.hpp"

#include <algorithm>
#include <utility>

#include "ssjs/cascade/rejection_search.hpp"

namespace ssjs {

RejectingStumps::RejectingStumps(const FeatureTable& table, double lost, int count, int threads)
    : table_(table), lost_(lost * static_cast<double>(table.positives()) + 1e-9), count_(count), threads_(threads) {}

std::optional<Stump> RejectingStumps::next() {
  const double part = static_cast<double>(stumps_.size() + 1) / count_;
  const auto found = best_in_place(stumps_.size(), static_cast<std::size_t>(part * lost_));
  if (!found) return std::nullopt;
  stumps_.push_back(*found);
  passed_.push_back(passed_by(*found));
  return found;
}

void RejectingStumps::refine() {
  std::size_t fewest = negatives_left();
  for (std::size_t since_better = 0, k = 0; since_better < stumps_.size(); ++since_better, k = (k + 1) % stumps_.size()) {
    const auto found = best_in_place(k, static_cast<std::size_t>(lost_));
    if (!found) continue;
    const Stump before = std::exchange(stumps_[k], *found);
    auto passed_before = std::exchange(passed_[k], passed_by(*found));
    if (const std::size_t left = negatives_left(); left < fewest) {
      fewest = left;
      since_better = 0;
    } else {
      stumps_[k] = before;
      passed_[k] = std::move(passed_before);
    }
  }
}

/// Samples that pass all stumps but one.
std::vector<unsigned char> RejectingStumps::standing_without(std::size_t stump) const {
  std::vector<unsigned char> standing(table_.samples(), 1);
  for (std::size_t k = 0; k < stumps_.size(); ++k)
    for (std::size_t i = 0; k != stump && i < standing.size(); ++i) standing[i] &= passed_[k][i];
  return standing;
}

std::size_t RejectingStumps::negatives_left() const {
  const auto standing = standing_without(stumps_.size());
  return static_cast<std::size_t>(std::count(standing.begin() + static_cast<std::ptrdiff_t>(table_.positives()), standing.end(), 1));
}

/// The best beside the others if all of them together lose at most `lost`.
std::optional<Stump> RejectingStumps::best_in_place(std::size_t stump, std::size_t lost) const {
  const auto standing = standing_without(stump);
  const auto objects_end = standing.begin() + static_cast<std::ptrdiff_t>(table_.positives());
  const auto gone = static_cast<std::size_t>(std::count(standing.begin(), objects_end, 0));
  return best_rejection(table_, standing, lost - std::min(lost, gone), threads_);
}

std::vector<unsigned char> RejectingStumps::passed_by(const Stump& stump) const {
  std::vector<float> values(table_.samples());
  table_.values(stump.feature, values.data());
  std::vector<unsigned char> passed(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) passed[i] = (values[i] < stump.threshold) == (stump.left > stump.right) ? 1 : 0;
  return passed;
}

}  // namespace ssjs
