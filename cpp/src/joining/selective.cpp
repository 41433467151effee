#include "ssjs/joining/selective.hpp"

#include <algorithm>
#include <chrono>
#include <set>
#include <tuple>
#include <utility>

#include "ssjs/base/chi_squared.hpp"
#include "ssjs/joining/fusion.hpp"
#include "ssjs/joining/landmark_list.hpp"
#include "ssjs/joining/loop_attempt.hpp"
#include "ssjs/joining/loop_candidates.hpp"
#include "ssjs/joining/nearby_maps.hpp"

namespace ssjs {
namespace {

constexpr const char* kTooLarge = "the fused map would be too large";

/// Pair i of the rows i of an encounter of pairs.
std::vector<Pair> row_by_row(std::size_t count) {
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < count; ++i) pairs.push_back({static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)});
  return pairs;
}

}  // namespace

SelectiveJoiner::SelectiveJoiner(const SelectiveJoinerConfig& config, AssociationMethod association,
                                 std::optional<int> max_submap_landmarks, std::uint64_t seed)
    : config_(config),
      associator_(
          {association, {config.gate_probability, config.joint_gate_probability, config.node_budget}, config.max_pairing_sigma_m, {}},
          seed),
      max_submap_landmarks_(max_submap_landmarks),
      global_(config.solver, config.dense_bases) {}

JoinReport SelectiveJoiner::take(const Submap& submap) {
  JoinReport report;
  LiveMap fresh = live_map_of(submap);
  newest_base_ = submap.index + 1;
  global_.attach(fresh);
  const int needed = needed_pairs({config_.fusion_threshold, config_.min_pairs, max_submap_landmarks_}, fresh);
  const bool comparable = fresh.landmark_count() >= needed;
  const std::vector<int> candidates = comparable ? candidates_for(fresh) : std::vector<int>{};
  replace_users(fresh, 1);
  maps_.emplace(submap.index, std::move(fresh));

  int current = submap.index;  // base of the map that holds the new submap; fused maps go on as the new one
  for (const int candidate : candidates) {
    LoopAttempt attempt;
    attempt.time_s = submap.end_time_s;
    attempt.from = submap.index;
    attempt.to = candidate;
    attempt.accepted = compare(candidate, current, needed, attempt, report);
    if (attempt.accepted) {
      current = candidate;
      ++report.fusions;
    }
    ++report.candidates;
    report.loops.push_back(std::move(attempt));
  }
  global_.settle();
  return report;
}

std::vector<int> SelectiveJoiner::candidates_for(const LiveMap& fresh) const {
  return nearby_maps(
      maps_, fresh, {config_.min_pairs, config_.min_gap, associator_.ambiguity_gate()}, [&](int base) { return global_.pose(base); },
      [&](const LiveMap& map) { return relative_placement(map, fresh, global_, global_.covariance_bound(map.base, fresh.base)); });
}

std::vector<Pair> SelectiveJoiner::search_pairs(const LiveMap& a, const LiveMap& b, double reach_m, int needed, LoopAttempt& attempt,
                                                JoinReport& report) {
  Overlap near = overlap(a, b, global_, reach_m);
  const auto most = static_cast<Eigen::Index>(std::min(near.a_landmarks.size(), near.b_landmarks.size()));
  if (most < needed) {
    attempt.reason = "too few landmarks near each other";
    return {};
  }
  if (a.landmark_count() + b.landmark_count() - most > config_.max_fused_landmarks) {  // whatever the pairing says
    attempt.reason = kTooLarge;
    return {};
  }
  const Encounter meeting = encounter(a, b, global_, std::move(near));
  const auto begin = std::chrono::steady_clock::now();
  const Hypothesis hypothesis = associator_.associate(meeting.problem);
  report.association_time_s += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  report.budget_exhausted = report.budget_exhausted || hypothesis.budget_exhausted;
  return landmark_pairs(meeting, hypothesis.pairs);
}

bool SelectiveJoiner::compare(int a_base, int b_base, int needed, LoopAttempt& attempt, JoinReport& report) {
  const LiveMap& a = maps_.at(a_base);
  const LiveMap& b = maps_.at(b_base);
  const std::optional<double> gate = associator_.ambiguity_gate();
  const RelativePlacement placement = relative_placement(a, b, global_);
  attempt.sigma_m = placement.sigma_m;
  if (gate && !(placement.sigma_m <= 2.0 * *gate)) {  // the centroid is not yet a landmark: twice the gate dismisses only the hopeless
    attempt.reason = "ambiguous: the maps' relative position is too unsure";
    return false;
  }
  const std::vector<Pair> of_maps = associator_.identities_are_known()
                                        ? pair_by_identity(a, b)
                                        : search_pairs(a, b, kReachSigmas * placement.sigma_m + kReachMargin, needed, attempt, report);
  attempt.pairs = static_cast<int>(of_maps.size());
  if (!attempt.reason.empty()) return false;
  if (attempt.pairs < needed) {
    attempt.reason = "too few landmarks in common";
    return false;
  }
  if (a.landmark_count() + b.landmark_count() - attempt.pairs > config_.max_fused_landmarks) {
    attempt.reason = kTooLarge;
    return false;
  }
  const Encounter meeting = encounter(a, b, global_, of_maps);
  const std::vector<Pair> pairs = row_by_row(of_maps.size());
  attempt.sigma_m = displacement_sigma(meeting, pairs);
  if (gate && !(attempt.sigma_m <= *gate)) {
    attempt.reason = "ambiguous: the paired landmarks' relative position is too unsure";
    return false;
  }
  attempt.wrong_pairs = count_wrong_pairs(of_maps, a, b);
  Fusion fusion = fuse(a, b, of_maps);
  attempt.chi_squared = fusion.chi_squared;
  attempt.dof = fusion.dof;
  if (!associator_.identities_are_known() && fusion.dof > 0 &&
      !(fusion.chi_squared <= chi_squared_quantile(config_.fusion_probability, fusion.dof))) {
    attempt.reason = "the maps do not fit on each other (chi-squared)";
    return false;
  }
  const JoinEvidence evidence = evidence_of(meeting, pairs);
  replace_users(a, -1);
  replace_users(b, -1);
  maps_.erase(b_base);
  replace_users(fusion.map, 1);
  std::vector<const LiveMap*> changed;
  for (const int loosened : loosen_ties(fusion.map)) {
    LiveMap& other = maps_.at(loosened);
    set_ports(other, ports_of(other));
    changed.push_back(&other);
  }
  freeze_inner_poses(fusion.map);
  set_ports(fusion.map, ports_of(fusion.map));
  global_.replace(a_base, b_base, fusion.map, evidence, changed);
  maps_.insert_or_assign(a_base, std::move(fusion.map));
  return true;
}

void SelectiveJoiner::replace_users(const LiveMap& map, int change) {
  users_[map.base] += change;
  for (const int base : map.poses) users_[base] += change;
}

/// A base is a port where another live map, the vehicle or the world attaches.
std::vector<bool> SelectiveJoiner::ports_of(const LiveMap& map) const {
  std::vector<bool> is_port;
  for (const int base : map.poses) is_port.push_back(base == 0 || base == newest_base_ || users_.at(base) > 1);
  return is_port;
}

std::vector<int> SelectiveJoiner::loosen_ties(LiveMap& fused) {
  const std::vector<bool> is_port = ports_of(fused);
  auto ports = static_cast<int>(std::count(is_port.begin(), is_port.end(), true));
  if (ports <= config_.max_ports) return {};
  struct Tie {
    double variance;  // in `fused`
    Eigen::Index pose;
    int other;
  };
  std::vector<Tie> ties;
  std::map<int, int> shared;
  for (const auto& [other_base, other] : maps_) {
    if (other_base == fused.base) continue;
    for (Eigen::Index i = 0; i < fused.pose_count(); ++i) {
      const int base = fused.poses[static_cast<std::size_t>(i)];
      if (base == 0 || base == newest_base_ || !other.pose_of(base)) continue;
      ties.push_back({fused.covariance(LiveMap::pose(i), LiveMap::pose(i)).trace(), i, other_base});
      ++shared[other_base];
    }
  }
  std::sort(ties.begin(), ties.end(),
            [](const Tie& a, const Tie& b) { return std::tie(b.variance, a.pose) < std::tie(a.variance, b.pose); });
  std::set<int> loosened;
  std::vector<Eigen::Index> removed;
  for (const Tie& tie : ties) {  // the least sure first
    if (ports <= config_.max_ports) break;
    if (shared[tie.other] <= config_.min_shared_bases) continue;
    --shared[tie.other];
    --ports;
    --users_.at(fused.poses[static_cast<std::size_t>(tie.pose)]);  // from now on inside `other` alone
    removed.push_back(tie.pose);
    loosened.insert(tie.other);
  }
  remove_poses(fused, removed);  // (J-19)
  return {loosened.begin(), loosened.end()};
}

void SelectiveJoiner::freeze_inner_poses(LiveMap& fused) {
  const std::vector<bool> is_port = ports_of(fused);
  std::vector<std::pair<int, Eigen::Index>> inner;  // base, pose; the oldest first
  for (Eigen::Index i = 0; i < fused.pose_count(); ++i) {
    if (!is_port[static_cast<std::size_t>(i)]) inner.emplace_back(fused.poses[static_cast<std::size_t>(i)], i);
  }
  if (static_cast<int>(inner.size()) <= config_.max_inner_poses) return;
  std::sort(inner.begin(), inner.end());
  inner.resize(inner.size() - static_cast<std::size_t>(config_.max_inner_poses));
  std::vector<Eigen::Index> removed;
  for (const auto& [base, pose] : inner) {
    frozen_.push_back({base, fused.base, {fused.base_T_pose(pose), fused.covariance(LiveMap::pose(pose), LiveMap::pose(pose))}});  // (J-18)
    users_.erase(base);
    removed.push_back(pose);
  }
  remove_poses(fused, removed);
}

GaussianSe2 SelectiveJoiner::global_T_newest_base() const { return {global_.pose(newest_base_), global_.covariance({newest_base_})}; }

JoinReport SelectiveJoiner::finish() {
  if (config_.final_adjustment && newest_base_ > 0) global_.relinearize();
  return {};
}

WorldEstimate SelectiveJoiner::estimate(BaseCovariance covariance) const {
  WorldEstimate estimate;
  BaseEstimate bases(global_, newest_base_ + 1);
  std::map<int, std::size_t> first_of;
  for (const auto& [base, map] : maps_) {
    const WorldMap world = to_world(map, global_);
    bases.add(map, world);
    first_of[base] = estimate.landmarks.size();
    for (Eigen::Index i = 0; i < map.landmark_count(); ++i) {
      estimate.landmarks.push_back({{world.landmarks.col(i), world.landmark_covariance[static_cast<std::size_t>(i)]},
                                    map.landmarks[static_cast<std::size_t>(i)],
                                    base});
    }
    estimate.maps.push_back({base, map.members, static_cast<int>(map.landmark_count())});
  }
  for (auto frozen = frozen_.rbegin(); frozen != frozen_.rend(); ++frozen) bases.add(*frozen);  // a reference is frozen after its followers
  estimate.global_T_base = bases.global_T_base();
  for (int k = 0; k < newest_base_; ++k) estimate.border_covariance.push_back(bases.border_covariance(k));
  if (covariance == BaseCovariance::kJoint) estimate.base_covariance = bases.joint_covariance();
  const auto pose = [&](int base) { return global_.pose(base); };
  const auto paired = [&](const LiveMap& a, const LiveMap& b) { return common_landmarks_of(a, b); };
  estimate.landmarks = listed_once(estimate.landmarks, common_landmarks(maps_, first_of, pose, paired));
  return estimate;
}

std::vector<Pair> SelectiveJoiner::common_landmarks_of(const LiveMap& a, const LiveMap& b) const {
  if (associator_.identities_are_known()) return pair_by_identity(a, b);
  Overlap near = overlap(a, b, global_, kReachMargin);
  if (near.a_landmarks.empty() || near.b_landmarks.empty()) return {};
  const Encounter meeting = encounter(a, b, global_, std::move(near));
  const std::vector<Pair> pairs = associator_.associate_exactly(meeting.problem).pairs;
  const std::optional<double> gate = associator_.ambiguity_gate();
  if (gate && !(displacement_sigma(meeting, pairs) <= *gate)) return {};
  return landmark_pairs(meeting, pairs);
}

}  // namespace ssjs
