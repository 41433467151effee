#include "ssjs/joining/relative_joiner.hpp"

#include <algorithm>
#include <utility>

#include "ssjs/joining/landmark_list.hpp"
#include "ssjs/joining/nearby_maps.hpp"

namespace ssjs {

RelativeJoiner::RelativeJoiner(const SelectiveJoinerConfig& config, AssociationMethod association, std::optional<int> max_submap_landmarks,
                               std::uint64_t seed)
    : config_(config),
      associator_(
          {association, {config.gate_probability, config.joint_gate_probability, config.node_budget}, config.max_pairing_sigma_m, {}},
          seed),
      rule_{config.fusion_threshold, config.min_pairs, max_submap_landmarks} {}

JoinReport RelativeJoiner::take(const Submap& submap) {
  JoinReport report;
  LiveMap fresh = live_map_of(submap);
  links_.append({fresh.base_T_pose(0), fresh.covariance.topLeftCorner<3, 3>()});
  remove_poses(fresh, {0});
  set_ports(fresh, {});
  NewMap among_others{fresh.base, submap.end_time_s, needed_pairs(rule_, fresh), {}, links_.all_relative_to(fresh.base)};
  if (fresh.landmark_count() >= among_others.needed) among_others.candidates = candidates_for(fresh, among_others.base_T_fresh);
  maps_.emplace(submap.index, std::move(fresh));
  report.candidates += static_cast<int>(among_others.candidates.size());
  close_loops(among_others, report);
  return report;
}

LoopAttempt RelativeJoiner::begun(const NewMap& fresh, int candidate) {
  LoopAttempt attempt;
  attempt.time_s = fresh.time_s;
  attempt.from = fresh.base;
  attempt.to = candidate;
  return attempt;
}

std::optional<std::vector<Pair>> RelativeJoiner::compare(int a, int b, const std::function<GaussianSe2()>& a_T_b, int needed,
                                                         LoopAttempt& attempt, JoinReport& report) {
  return attempt_loop(maps_.at(a), maps_.at(b), a_T_b, needed, associator_, attempt, report);
}

std::vector<int> RelativeJoiner::candidates_for(const LiveMap& fresh, const std::vector<GaussianSe2>& base_T_fresh) const {
  return nearby_maps(
      maps_, fresh, {config_.min_pairs, config_.min_gap, associator_.ambiguity_gate()},
      [&](int base) { return links_.global_T_base(base); },
      [&](const LiveMap& map) { return relative_placement(map, fresh, base_T_fresh[static_cast<std::size_t>(map.base)]); });
}

GaussianSe2 RelativeJoiner::global_T_newest_base() const {
  const int newest = links_.newest_base();
  return {links_.global_T_base(newest), links_.relative(0, newest).covariance};
}

WorldEstimate RelativeJoiner::estimate(BaseCovariance covariance) const {
  WorldEstimate estimate;
  estimate.global_T_base = links_.global_T_bases();
  Eigen::MatrixXd P = links_.base_covariance();
  const auto at = [](int base) { return Eigen::seqN(3 * Eigen::Index{base}, Eigen::fix<3>); };
  for (int k = 0; k < links_.newest_base(); ++k)
    estimate.border_covariance.push_back(P.block<6, 6>(3 * Eigen::Index{k}, 3 * Eigen::Index{k}));
  std::map<int, std::size_t> first_of;
  for (const auto& [base, map] : maps_) {
    const Se2& global_T_base = links_.global_T_base(base);
    const Eigen::Matrix2d R = global_T_base.rotation();
    first_of[base] = estimate.landmarks.size();
    for (Eigen::Index i = 0; i < map.landmark_count(); ++i) {  // (H-4)
      const auto rows = map.landmark(i);
      const Eigen::Vector2d base_p = map.mean(rows);
      const Eigen::Matrix<double, 2, 3> J = act_jacobian(global_T_base, base_p);
      const Eigen::Matrix2d own = R * map.covariance(rows, rows) * R.transpose();
      estimate.landmarks.push_back(
          {{global_T_base * base_p, J * P(at(base), at(base)) * J.transpose() + own}, map.landmarks[static_cast<std::size_t>(i)], base});
    }
    estimate.maps.push_back({base, map.members, static_cast<int>(map.landmark_count())});
  }
  const auto paired = [&](const LiveMap& a, const LiveMap& b) -> std::vector<Pair> {
    if (associator_.identities_are_known()) return pair_by_identity(a, b);
    const RelativePose tau = relative_pose(links_.global_T_base(a.base), links_.global_T_base(b.base));
    const Eigen::Matrix3d cross = tau.J_i * P(at(a.base), at(b.base)) * tau.J_j.transpose();
    const GaussianSe2 a_T_b{tau.i_T_j, tau.J_i * P(at(a.base), at(a.base)) * tau.J_i.transpose() + cross + cross.transpose() +
                                           tau.J_j * P(at(b.base), at(b.base)) * tau.J_j.transpose()};
    const MapPlacement placement{a_T_b, {}};
    const MapMeeting meeting = meet(a, b, placement);
    if (meeting.a_landmarks.empty() || meeting.b_landmarks.empty()) return {};
    const Hypothesis hypothesis = associator_.associate_exactly(meeting.problem);
    std::vector<Pair> pairs = landmark_pairs(meeting, hypothesis.pairs);
    const auto gate = associator_.ambiguity_gate();
    for (const Pair& pair : pairs) {
      if (gate && !(displacement_sigma(a, b, placement, pair) <= *gate)) return {};
    }
    return pairs;
  };
  estimate.landmarks = listed_once(estimate.landmarks, common_landmarks(
                                                           maps_, first_of, [&](int base) { return links_.global_T_base(base); }, paired));
  if (covariance == BaseCovariance::kJoint) estimate.base_covariance = std::move(P);
  return estimate;
}

}  // namespace ssjs
