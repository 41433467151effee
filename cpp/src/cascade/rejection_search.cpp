#include "ssjs/cascade/rejection_search.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <limits>
#include <string>
#include <tuple>

#include "ssjs/base/error.hpp"
#include "ssjs/cascade/feature_sweep.hpp"

namespace ssjs {
namespace {

constexpr std::size_t kBins = FeatureTable::kBins;
constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

/// A feature and which of its values pass.
struct Rejection {
  std::size_t passed = kNone;  ///< negatives
  std::size_t feature = kNone;
  bool keeps_small = false;
  float extreme = 0;  ///< the least value that passes, or the greatest
};

bool better(const Rejection& a, const Rejection& b) {
  return std::tuple(a.passed, a.feature, a.keeps_small) < std::tuple(b.passed, b.feature, b.keeps_small);
}

class Search {
 public:
  Search(const FeatureTable& table, const std::vector<unsigned char>& standing, std::size_t lost)
      : table_(table), standing_(standing), lost_(lost) {
    for (std::size_t i = 0; i < standing.size(); ++i)
      if (standing[i] != 0) (i < table.positives() ? positives_ : negatives_).push_back(i);
  }

  [[nodiscard]] bool possible() const { return positives_.size() > lost_ && !negatives_.empty(); }

  void examine(std::size_t feature, FeatureTable::Scratch& scratch, Rejection& best) {
    // A bin is an interval of values: negatives beyond the bin of the extreme positive pass, wherever in it the extreme is.
    const FeatureTable::Bin* bins = table_.bins(feature, scratch);
    const auto [least, greatest] = extreme_bins(bins);
    std::size_t above = 0;
    std::size_t below = 0;
    for (std::size_t i = table_.positives(); i < table_.samples(); ++i) {
      above += bins[i] > least ? standing_[i] : 0U;
      below += bins[i] < greatest ? standing_[i] : 0U;
    }
    const std::size_t known = fewest_.load(std::memory_order_relaxed);
    if (above > known && below > known) return;
    thread_local std::vector<float> values;
    values.resize(table_.samples());
    table_.values(feature, values.data());
    if (above <= known) offer(exact(feature, values, false), best);
    if (below <= known) offer(exact(feature, values, true), best);
  }

  [[nodiscard]] std::size_t negatives() const { return negatives_.size(); }
  [[nodiscard]] Stump stump_of(const Rejection& rejection) const;

 private:
  /// The bins of the positive that is lost_ + 1 from the least and from the greatest value.
  [[nodiscard]] std::pair<std::size_t, std::size_t> extreme_bins(const FeatureTable::Bin* bins) const {
    std::array<std::uint32_t, kBins> histogram{};
    for (const std::size_t i : positives_) ++histogram[bins[i]];
    std::size_t least = 0;
    std::size_t greatest = kBins - 1;
    for (std::size_t counted = histogram[least]; counted <= lost_;) counted += histogram[++least];
    for (std::size_t counted = histogram[greatest]; counted <= lost_;) counted += histogram[--greatest];
    return {least, greatest};
  }

  [[nodiscard]] Rejection exact(std::size_t feature, const std::vector<float>& values, bool keeps_small) const {
    thread_local std::vector<float> of_positives;
    of_positives.clear();
    for (const std::size_t i : positives_) of_positives.push_back(keeps_small ? -values[i] : values[i]);
    const auto extreme = of_positives.begin() + static_cast<std::ptrdiff_t>(lost_);
    std::nth_element(of_positives.begin(), extreme, of_positives.end());
    const auto passed = static_cast<std::size_t>(std::count_if(
        negatives_.begin(), negatives_.end(), [&](std::size_t i) { return (keeps_small ? -values[i] : values[i]) >= *extreme; }));
    return {passed, feature, keeps_small, keeps_small ? -*extreme : *extreme};
  }

  void offer(const Rejection& found, Rejection& best) {
    if (better(found, best)) best = found;
    std::size_t known = fewest_.load(std::memory_order_relaxed);
    while (found.passed < known && !fewest_.compare_exchange_weak(known, found.passed, std::memory_order_relaxed)) {
    }
  }

  const FeatureTable& table_;
  const std::vector<unsigned char>& standing_;
  std::size_t lost_;
  std::vector<std::size_t> positives_;
  std::vector<std::size_t> negatives_;
  std::atomic<std::size_t> fewest_{kNone};
};

/// Threshold midway between the last value that passes and the first that does not.
Stump Search::stump_of(const Rejection& rejection) const {
  std::vector<float> values(table_.samples());
  table_.values(rejection.feature, values.data());
  const auto passes = [&](float value) { return rejection.keeps_small ? value <= rejection.extreme : value >= rejection.extreme; };
  float first_out = rejection.keeps_small ? std::numeric_limits<float>::infinity() : -std::numeric_limits<float>::infinity();
  const auto share = [&](const std::vector<std::size_t>& samples) {
    std::size_t passed = 0;
    for (const std::size_t i : samples) {
      if (passes(values[i]))
        ++passed;
      else
        first_out = rejection.keeps_small ? std::min(first_out, values[i]) : std::max(first_out, values[i]);
    }
    return static_cast<double>(passed) / static_cast<double>(samples.size());
  };
  const double objects = share(positives_);
  const double others = share(negatives_);
  const float low = rejection.keeps_small ? rejection.extreme : first_out;
  const float high = rejection.keeps_small ? first_out : rejection.extreme;
  Stump stump{rejection.feature, low + (high - low) / 2, 0, 0};
  if (!(stump.threshold > low)) stump.threshold = high;
  const auto accepting = static_cast<float>((objects - others) / (objects + others));
  const auto rejecting = static_cast<float>((others - objects) / (2 - objects - others));
  stump.left = rejection.keeps_small ? accepting : rejecting;
  stump.right = rejection.keeps_small ? rejecting : accepting;
  return stump;
}

}  // namespace

std::optional<Stump> best_rejection(const FeatureTable& table, const std::vector<unsigned char>& standing, std::size_t lost, int threads) {
  if (standing.size() != table.samples())
    throw InvalidArgument("standing", static_cast<double>(standing.size()),
                          "must be as many as samples: " + std::to_string(table.samples()));
  Search search(table, standing, lost);
  if (!search.possible()) return std::nullopt;
  const Rejection best = sweep_features<Rejection>(
      table.features(), threads,
      [&](std::size_t f, FeatureTable::Scratch& scratch, Rejection& found) { search.examine(f, scratch, found); }, better, [] {});
  if (best.passed >= search.negatives()) return std::nullopt;
  return search.stump_of(best);
}

}  // namespace ssjs
