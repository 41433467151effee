#include "ssjs/joining/loop_attempt.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "ssjs/base/chi_squared.hpp"

namespace ssjs {

int needed_pairs(const LoopRule& rule, const LiveMap& fresh) {
  auto landmarks = static_cast<int>(fresh.landmark_count());
  if (rule.max_submap_landmarks) landmarks = std::min(landmarks, *rule.max_submap_landmarks);
  return std::max(rule.min_pairs, static_cast<int>(std::ceil(rule.threshold * landmarks - 1e-9)));
}

std::optional<std::vector<Pair>> attempt_loop(const LiveMap& a, const LiveMap& b, const std::function<GaussianSe2()>& a_T_b, int needed,
                                              MapAssociator& associator, LoopAttempt& attempt, JoinReport& report) {
  const auto gate = associator.ambiguity_gate();
  std::vector<Pair> pairs;
  if (associator.identities_are_known()) {
    pairs = pair_by_identity(a, b);
    attempt.pairs = static_cast<int>(pairs.size());
    if (attempt.pairs < needed) {
      attempt.reason = "too few landmarks in common";
      return std::nullopt;
    }
  }
  const MapPlacement placement{a_T_b(), {}};
  attempt.sigma_m = relative_placement(a, b, placement.a_T_b).sigma_m;
  if (gate && !(attempt.sigma_m <= 2.0 * *gate)) {  // the centroid is not yet a landmark: twice the gate dismisses only the hopeless
    attempt.reason = "ambiguous: the maps' relative position is too unsure";
    return std::nullopt;
  }
  if (!associator.identities_are_known()) {
    const auto begin = std::chrono::steady_clock::now();
    const MapMeeting meeting = meet(a, b, placement);
    if (static_cast<int>(std::min(meeting.a_landmarks.size(), meeting.b_landmarks.size())) >= needed) {
      const Hypothesis hypothesis = associator.associate(meeting.problem);
      report.budget_exhausted = report.budget_exhausted || hypothesis.budget_exhausted;
      pairs = landmark_pairs(meeting, hypothesis.pairs);
    }
    report.association_time_s += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    attempt.pairs = static_cast<int>(pairs.size());
    if (attempt.pairs < needed) {
      attempt.reason = "too few landmarks in common";
      return std::nullopt;
    }
  }
  attempt.sigma_m = 0.0;
  for (const Pair& pair : pairs) attempt.sigma_m = std::max(attempt.sigma_m, displacement_sigma(a, b, placement, pair));
  if (gate && !(attempt.sigma_m <= *gate)) {
    attempt.reason = "ambiguous: the paired landmarks' relative position is too unsure";
    return std::nullopt;
  }
  attempt.wrong_pairs = count_wrong_pairs(pairs, a, b);
  return pairs;
}

bool fits(LoopAttempt& attempt, const MapAssociator& associator, double probability) {
  if (associator.identities_are_known() || attempt.dof <= 0) return true;
  if (*attempt.chi_squared <= chi_squared_quantile(probability, attempt.dof)) return true;
  attempt.reason = "the maps do not fit on each other (chi-squared)";
  return false;
}

}  // namespace ssjs
