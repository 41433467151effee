// PortJoiner: closures that contradict each other, and a level that can forget. docs/math/closures.md (C-10, C-11).
#include <Eigen/Cholesky>
#include <algorithm>
#include <set>
#include <string>

#include "ssjs/base/error.hpp"
#include "ssjs/joining/port_joiner.hpp"

namespace ssjs {
namespace {

constexpr int kMaxRevisions = 4;  // of one call: what is paired anew after one may bring the next

/// One more entry of the state, independent of the others: the pose of another base. (C-10)
Eigen::Index append_pose(LevelledSubmap& submap, const GaussianSe2& base_T_other) {
  const Eigen::Index n = submap.mean.size();
  submap.mean.conservativeResize(n + 3);
  submap.mean.tail<3>() = base_T_other.mean.vector();
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(n + 3, n + 3);
  P.topLeftCorner(n, n) = submap.covariance;
  P.bottomRightCorner<3, 3>() = base_T_other.covariance;
  submap.covariance = std::move(P);
  return n;
}

}  // namespace

void PortJoiner::check(const Closure& closure) const {
  if (bases_are_given_) throw InvalidArgument("closure", "maps that are no chain", "there is no way to hold it against");
  const std::string name = "closure from " + std::to_string(closure.from) + " to " + std::to_string(closure.to);
  const auto maps = static_cast<int>(maps_.size());
  if (closure.from < 0 || closure.to <= closure.from || closure.to > maps || (!closure.from_T_to && closure.to == maps)) {
    throw InvalidArgument(name, "no such maps", "an older one, then a newer one of the " + std::to_string(maps) + " there are");
  }
  if (closure.from_T_to.has_value() == !closure.pairs.empty()) {
    throw InvalidArgument(name, closure.from_T_to ? "a pose and pairs" : "empty", "states a relative pose or pairs of landmarks");
  }
  if (closure.from_T_to) {
    if (!closure.from_T_to->mean.vector().allFinite()) throw InvalidArgument(name, "not finite", "the pose must be");
    static_cast<void>(cholesky_lower(closure.from_T_to->covariance, "covariance of a loop closure", name.c_str()));
  }
  for (const auto& [of_from, of_to] : closure.pairs) {
    if (of_from < 0 || of_from >= maps_[static_cast<std::size_t>(closure.from)].submap.landmark_count() || of_to < 0 ||
        of_to >= maps_[static_cast<std::size_t>(closure.to)].submap.landmark_count()) {
      throw InvalidArgument(name, std::to_string(of_from) + " and " + std::to_string(of_to), "landmarks that the two maps have");
    }
  }
}

LoopAttempt PortJoiner::attempt_of(std::size_t closure) {
  const Closure& claimed = guard_.closure(closure);
  LoopAttempt attempt;
  attempt.time_s = maps_.back().submap.end_time_s;
  attempt.from = claimed.to;
  attempt.to = claimed.from;
  attempt.accepted = guard_.stands(closure);
  attempt.reason = guard_.reason(closure);
  attempt.pairs = static_cast<int>(claimed.pairs.size());
  if (const std::optional<ClosureFit>& alone = guard_.alone(closure)) {
    attempt.chi_squared = alone->chi_squared;
    attempt.dof = alone->dof;
  }
  attempt.source = claimed.source;
  return attempt;
}

JoinReport PortJoiner::propose(const std::vector<Closure>& closures) {
  for (const Closure& closure : closures) check(closure);
  JoinReport report;
  if (closures.empty()) return report;
  const auto newest = static_cast<int>(maps_.size()) - 1;
  const std::size_t first = ties_.size();
  const std::size_t first_closure = guard_.size();
  for (const Closure& closure : closures) {
    const double weight = closure.from_T_to ? 1.0 : static_cast<double>(closure.pairs.size());
    const std::size_t number = guard_.add(closure, weight, ClosureStanding::kProposed, maps_);
    const int batch = batches_++;
    if (closure.from_T_to) {
      const Eigen::Index entry = append_pose(map_at(closure.from).submap, *closure.from_T_to);
      ties_.push_back({Tie::Kind::kPose, newest, batch, closure.from, entry, closure.to, 0, number});
    }
    for (const auto& [of_from, of_to] : closure.pairs) {
      ties_.push_back({Tie::Kind::kUnite, newest, batch, closure.from, of_from, closure.to, of_to, number});
    }
  }
  for (std::size_t number = first_closure; number < guard_.size(); ++number) {
    in_force_.push_back(guard_.stands(number));
    report.loops.push_back(attempt_of(number));
    ++report.candidates;
  }
  for (std::size_t i = first; i < ties_.size(); ++i) {
    if (holds(ties_[i])) put_in_force(ties_[i]);
  }
  level_->settle();
  revise(report);
  const std::size_t last_closure = guard_.size();  // a revision may add pairings
  for (std::size_t number = first_closure; number < last_closure; ++number) judge_by_the_rest(guard_.poses_near(number), report);
  return report;
}

/// A proposed pose against the level without it. (C-12)
std::optional<ClosureFit> PortJoiner::against_the_rest(std::size_t closure) const {
  const Closure& claimed = guard_.closure(closure);
  const GaussianSe2& z = *claimed.from_T_to;
  const RelativePose tau = relative_pose(level_->values().base(claimed.from), level_->values().base(claimed.to));
  const Eigen::Vector3d r = additive_difference(tau.i_T_j, z.mean);
  Eigen::Matrix<double, 3, 6> J;
  J << tau.J_i, tau.J_j;
  const Eigen::Matrix3d known =
      J * level_->covariance({{UnknownKind::kBase, claimed.from}, {UnknownKind::kBase, claimed.to}}) * J.transpose();
  const bool is_in = in_force_[closure];
  const Eigen::LLT<Eigen::Matrix3d> S(is_in ? Eigen::Matrix3d(z.covariance - known) : Eigen::Matrix3d(z.covariance + known));
  if (S.info() != Eigen::Success) return std::nullopt;  // nothing but the closure itself ties these bases
  const Eigen::Vector3d weighted = S.solve(r);
  const Eigen::Vector3d innovation = is_in ? Eigen::Vector3d(z.covariance * weighted) : r;
  return ClosureFit{r.dot(weighted), 3, innovation.head<2>().norm()};
}

/// Of the closures that stand the worst is refused as long as it is beyond the gate; then those that had been so may come back.
void PortJoiner::judge_by_the_rest(const std::vector<std::size_t>& closures, JoinReport& report) {
  if (!config_.closures.enabled || closures.empty()) return;
  std::set<std::size_t> doubted;
  for (const std::size_t closure : closures) {
    if (guard_.is_doubted(closure)) doubted.insert(closure);
  }
  std::vector<Unknown> bases;  // asked for together, which the level answers at the price of one
  for (const std::size_t closure : closures) {
    bases.push_back({UnknownKind::kBase, guard_.closure(closure).from});
    bases.push_back({UnknownKind::kBase, guard_.closure(closure).to});
  }
  std::sort(bases.begin(), bases.end());
  bases.erase(std::unique(bases.begin(), bases.end()), bases.end());
  while (true) {
    static_cast<void>(level_->covariance(bases));
    std::optional<std::size_t> worst;
    ClosureFit worst_fit;
    for (const std::size_t closure : closures) {
      if (!in_force_[closure]) continue;
      const std::optional<ClosureFit> fit = against_the_rest(closure);
      if (!fit || guard_.fits(*fit) || (worst && fit->chi_squared <= worst_fit.chi_squared)) continue;
      worst = closure;
      worst_fit = *fit;
    }
    if (!worst) break;
    guard_.judge_by_the_rest(*worst, worst_fit);
    revise(report);
  }
  for (const std::size_t closure : doubted) {
    const std::optional<ClosureFit> fit = against_the_rest(closure);
    if (fit && guard_.fits(*fit)) guard_.judge_by_the_rest(closure, *fit);
  }
  revise(report);
}

/// Of the matches that a pairing has found: those whose closures stand.
std::vector<PortJoiner::Match> PortJoiner::standing(int observer, const std::vector<Match>& matches, LoopAttempt& attempt) {
  const bool granted = config_.association == AssociationMethod::kKnown;
  std::map<int, Closure> with;  // by the other map
  for (const Match& match : matches) {
    const int other = match.other.map->base();
    Closure& closure = with[other];
    closure.from = std::min(observer, other);
    closure.to = std::max(observer, other);
    const bool newer = observer > other;
    closure.pairs.emplace_back(newer ? match.other.landmark : match.own, newer ? match.own : match.other.landmark);
  }
  std::map<int, std::size_t> number_with;
  for (const auto& [other, closure] : with) {
    number_with[other] = guard_.add(closure, static_cast<double>(closure.pairs.size()),
                                    granted ? ClosureStanding::kGranted : ClosureStanding::kFound, maps_);
  }
  for (const auto& [other, number] : number_with) in_force_.push_back(guard_.stands(number));
  const auto newest = static_cast<int>(maps_.size()) - 1;
  const int batch = batches_++;
  std::vector<Match> kept;
  for (const Match& match : matches) {
    const std::size_t number = number_with.at(match.other.map->base());
    ties_.push_back({Tie::Kind::kJoin, newest, batch, observer, match.own, match.other.map->base(), match.other.landmark, number});
    if (in_force_[number]) {
      kept.push_back(match);
    } else {
      attempt.reason = guard_.reason(number);
    }
  }
  if (kept.size() < matches.size()) {
    attempt.pairs = static_cast<int>(kept.size());
    attempt.accepted = !kept.empty();
    if (attempt.accepted) attempt.reason.clear();
  }
  return kept;
}

void PortJoiner::put_in_force(const Tie& tie) {
  if (tie.kind == Tie::Kind::kPose) {
    PortMap& map = map_at(tie.map);
    const Port port{tie.entry, {UnknownKind::kBase, tie.other}};
    level_->tie(map, {port});  // (C-10)
    map.ports.push_back(port);
  } else {
    unite({&map_at(tie.map), tie.entry}, {&map_at(tie.other), tie.landmark});
  }
}

/// Every map is attached anew and every tie that holds is tied again, in the old order. (C-11)
void PortJoiner::rebuild() {
  level_ = make_level(config_);
  landmark_ports_ = 0;
  for (PortMap& map : maps_) map.ports.clear();
  std::size_t next = 0;
  for (int k = 0; k < static_cast<int>(maps_.size()); ++k) {
    if (drift_variance_[static_cast<std::size_t>(k)] > 0.0) level_->drift(k - 1, drift_variance_[static_cast<std::size_t>(k)]);
    attach(map_at(k));
    while (next < ties_.size() && ties_[next].newest == k) {
      const int batch = ties_[next].batch;
      const int observer = ties_[next].map;
      std::vector<Match> joined;
      for (; next < ties_.size() && ties_[next].batch == batch; ++next) {
        const Tie& again = ties_[next];
        if (!holds(again)) continue;
        if (again.kind == Tie::Kind::kJoin && !Sighting{&map_at(again.map), again.entry}.port()) {
          joined.push_back({again.entry, {&map_at(again.other), again.landmark}});
        } else {
          put_in_force(again);
        }
      }
      if (!joined.empty()) tie(observer, joined);
    }
  }
  fixes_.put_into(*level_);
  level_->adjust();
  PortReach anew;  // what was known of a base when its map came may have been known too well
  for (const PortMap& map : maps_) anew.add(reach_.extent(map.base()), *level_);
  reach_ = std::move(anew);
}

void PortJoiner::chain_anew() {
  guard_.forget_maps();
  for (const PortMap& map : maps_) {
    const auto k = static_cast<std::size_t>(map.base());
    guard_.append(map.submap, compass_goes_on_[k], drift_variance_[k]);
  }
}

void PortJoiner::revise(JoinReport& report) {
  for (int round = 0; round < kMaxRevisions; ++round) {
    std::set<std::size_t> changed;
    std::optional<int> since;  // the map that was newest when the first of those that fall now had been tied
    for (const Tie& tie : ties_) {
      if (!tie.closure || in_force_[*tie.closure] == guard_.stands(*tie.closure)) continue;
      changed.insert(*tie.closure);
      if (in_force_[*tie.closure]) since = std::min(since.value_or(tie.newest), tie.newest);
    }
    if (changed.empty()) return;
    for (const std::size_t number : changed) {
      in_force_[number] = !in_force_[number];
      report.loops.push_back(attempt_of(number));
      report.loops.back().revised = true;
    }
    if (since) {  // landmarks that were found to be one while the level was wrong are judged anew
      const auto doubtful = [&](const Tie& tie) { return !tie.closure && tie.newest >= *since; };
      for (const Tie& tie : ties_) {
        if (!doubtful(tie)) continue;
        --merged_;
        if (tie.wrong) --wrongly_merged_;
      }
      ties_.erase(std::remove_if(ties_.begin(), ties_.end(), doubtful), ties_.end());
    }
    rebuild();
    if (!since || config_.association == AssociationMethod::kKnown) continue;
    for (int k = *since; k < static_cast<int>(maps_.size()); ++k) {  // what could not be found while the level was wrong
      std::vector<int> around = reach_.before(k, *level_);
      report.append(pair_with(k, around, false));
      for (const int other : around) report.append(pair_with(other, {k}, true));
      around.push_back(k);
      merge_duplicates(around);
    }
  }
}

/// Throws InvalidArgument where what was read of the ties does not fit the maps.
void PortJoiner::check_ties() const {
  const std::size_t maps = maps_.size();
  if (compass_goes_on_.size() != maps || drift_variance_.size() != maps || in_force_.size() != guard_.size()) {
    throw InvalidArgument("ties", static_cast<double>(compass_goes_on_.size()), "must be of the maps and closures there are");
  }
  for (std::size_t i = 0; i < guard_.size(); ++i) check(guard_.closure(i));
  int newest = 0;
  for (const Tie& tie : ties_) {
    const bool pose = tie.kind == Tie::Kind::kPose;
    const auto last = static_cast<int>(maps) - (pose ? 0 : 1);
    if (tie.newest < newest || tie.newest >= static_cast<int>(maps) || tie.map < 0 || tie.map >= static_cast<int>(maps) || tie.other < 0 ||
        tie.other > last || (tie.closure && *tie.closure >= guard_.size())) {
      throw InvalidArgument("tie", tie.map, "joins maps and a closure that are there");
    }
    newest = tie.newest;
    const LevelledSubmap& submap = maps_[static_cast<std::size_t>(tie.map)].submap;
    const bool own = tie.entry >= 0 && (pose ? tie.entry + 3 <= submap.mean.size() : tie.entry < submap.landmark_count());
    const bool others = pose || (tie.landmark >= 0 && tie.landmark < maps_[static_cast<std::size_t>(tie.other)].submap.landmark_count());
    if (!own || !others) throw InvalidArgument("tie", static_cast<double>(tie.entry), "names entries that its maps have");
  }
}

}  // namespace ssjs
