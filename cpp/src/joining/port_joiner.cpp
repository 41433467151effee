#include "ssjs/joining/port_joiner.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "ssjs/base/angle.hpp"
#include "ssjs/base/chi_squared.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/joining/batch_ports.hpp"
#include "ssjs/joining/recursive_ports.hpp"
#include "ssjs/joining/unsound_map.hpp"

namespace ssjs {
namespace {

constexpr double kOffsetGate = 0.999999;           // a compass that jumped between two maps is met anew
constexpr double kSmallestNeighbourhood_m = 25.0;  // radius in which landmarks are counted: a swath, where a map has few of its own

/// The mean offset as an entry of the state, independent of all others (P-4).
void insert_compass_mean(LevelledSubmap& submap) {
  const CompassMean mean = *submap.compass_mean;
  const Eigen::Index n = submap.mean.size();
  const Eigen::Index at = LevelledSubmap::compass_offset();
  const auto with_entry = [&](const auto& matrix) {
    Eigen::MatrixXd wider = Eigen::MatrixXd::Zero(n + 1, n + 1);
    for (Eigen::Index row = 0; row < n; ++row) {
      for (Eigen::Index column = 0; column < n; ++column) {
        wider(row + (row >= at ? 1 : 0), column + (column >= at ? 1 : 0)) = matrix(row, column);
      }
    }
    return wider;
  };
  Eigen::VectorXd state(n + 1);
  state << submap.mean.head(at), mean.offset_rad, submap.mean.tail(n - at);
  submap.mean = state;
  submap.covariance = with_entry(submap.covariance);
  submap.covariance(at, at) = mean.variance;
  submap.compass = CompassPorts::kConstant;
  submap.compass_mean.reset();
  for (LevelledStep& step : submap.steps) {
    if (step.gain.cols() <= at) continue;
    Eigen::Matrix<double, 6, Eigen::Dynamic> gain(6, step.gain.cols() + 1);
    gain << step.gain.leftCols(at), Eigen::Matrix<double, 6, 1>::Zero(), step.gain.rightCols(step.gain.cols() - at);
    step.gain = gain;
  }
}

void put(PortMap& map, const std::vector<Port>& ports) { map.ports.insert(map.ports.end(), ports.begin(), ports.end()); }

std::string number(Eigen::Index value) { return std::to_string(value); }

}  // namespace

std::unique_ptr<PortLevel> PortJoiner::make_level(const PortJoinerConfig& config) {
  if (config.solver == PortSolver::kRecursive) return std::make_unique<RecursivePorts>(config.relinearize_heading_rad);
  return std::make_unique<BatchPorts>();
}

PortJoiner::PortJoiner(const PortJoinerConfig& config)
    : config_(config),
      association_{{config.gate_probability, config.joint_gate_probability, config.node_budget},
                   config.max_chance_odds,
                   config.max_chance_alignments,
                   config.max_descriptor_distance},
      level_(make_level(config)),
      fixes_(config.fixes),
      guard_(config.closures) {
  if (config.association != AssociationMethod::kKnown && config.association != AssociationMethod::kJointCompatibility) {
    throw InvalidArgument("association", static_cast<int>(config.association), "levelled maps are paired by jcbb or by known identities");
  }
}

void PortJoiner::check(const LevelledSubmap& submap) const {
  const auto next = static_cast<int>(maps_.size());
  if (submap.index != next) throw InvalidArgument("submap.index", submap.index, "the next map is number " + std::to_string(next));
  const Eigen::Index n = submap.landmark_offset(submap.landmark_count());
  if (submap.mean.size() != n || submap.covariance.rows() != n || submap.covariance.cols() != n) {
    throw InvalidArgument(
        "submap " + std::to_string(submap.index),
        number(submap.mean.size()) + " entries, covariance " + number(submap.covariance.rows()) + " x " + number(submap.covariance.cols()),
        "3 for the exit, the compass entries and 3 a landmark make " + number(n));
  }
  if (!submap.seen_s.empty() && submap.seen_s.size() != submap.landmarks.size()) {
    throw InvalidArgument("submap " + std::to_string(submap.index), std::to_string(submap.seen_s.size()) + " lists of sighting times",
                          "one a landmark, or none at all");
  }
  if (submap.compass_mean && (submap.compass != CompassPorts::kNone || !(submap.compass_mean->variance > 0.0))) {
    throw InvalidArgument("compass_mean.variance", submap.compass_mean->variance, "must be positive, in a map without compass ports");
  }
  if (compass_ && (*compass_ != submap.compass || compass_is_mean_ != submap.compass_mean.has_value())) {
    throw InvalidArgument("submap.compass", static_cast<int>(submap.compass), "must be the same in all maps of a survey");
  }
}

bool PortJoiner::offset_is_shared() const { return !compass_is_mean_ || !(config_.offset_drift_rad_per_sqrt_s > 0.0); }

int PortJoiner::offset_at_start(const PortMap& map) const {
  if (map.submap.compass == CompassPorts::kBorders || !offset_is_shared()) return map.base();
  return 0;
}

/// Whether the offset that the map started with can be the one that the map before ended with: the innovation of (P-8) for c_s alone.
bool PortJoiner::offset_goes_on(const PortMap& map) const {
  if (map.base() == 0 || map.submap.compass_rows() < 2) return true;
  const Port start{LevelledSubmap::compass_offset(), {UnknownKind::kOffset, offset_at_start(map)}};
  const Unknown base{UnknownKind::kBase, map.base()};
  const Eigen::MatrixXd P = level_->covariance({base, start.unknown});
  const Eigen::Index row = start.row;
  const double expected = level_->values().base(base.index).heading + level_->values().offset(start.unknown.index);
  const double jump = angle_difference(map.submap.mean(row), expected);
  const double variance = P(2, 2) + P(3, 3) + 2.0 * P(3, 2) + map.submap.covariance(row, row);
  return jump * jump <= chi_squared_quantile(kOffsetGate, 1.0) * variance;
}

void PortJoiner::attach(PortMap& map) {
  const int base = map.base();
  std::vector<Port> fresh{{0, {UnknownKind::kBase, base + 1}}};
  const Eigen::Index rows = map.submap.compass_rows();
  if (rows > 0) {
    const Port start{LevelledSubmap::compass_offset(), {UnknownKind::kOffset, offset_at_start(map)}};
    if (base > 0) {
      if (compass_goes_on_[static_cast<std::size_t>(base)]) {
        level_->tie(map, {start});
        put(map, {start});
      }  // otherwise the map's own offsets go on from here, and its heading hangs on its neighbours alone
    } else if (config_.north_offset_rad) {
      const double sigma = config_.north_offset_sigma_rad;
      level_->align_to_north(map, start.row, {wrap_angle(*config_.north_offset_rad), sigma * sigma});
      put(map, {start});
    } else {
      fresh.push_back(start);
    }
    if (rows == 2) fresh.push_back({start.row + 1, {UnknownKind::kOffset, base + 1}});
  } else if (base == 0 && config_.north_offset_rad) {
    throw InvalidArgument("north_offset_rad", *config_.north_offset_rad, "the maps hold no compass: leave it out");
  }
  level_->introduce(map, fresh);
  put(map, fresh);
}

void PortJoiner::stand_on(const std::vector<GaussianSe2>& world_T_base) {
  if (!maps_.empty()) throw InvalidArgument("stand_on", "late call", "comes before every map");
  const auto n = static_cast<Eigen::Index>(world_T_base.size());
  LevelledSubmap datum;
  datum.mean.resize(3 * n);
  datum.covariance = Eigen::MatrixXd::Zero(3 * n, 3 * n);
  std::vector<Port> bases;
  for (Eigen::Index k = 0; k < n; ++k) {
    const GaussianSe2& base = world_T_base[static_cast<std::size_t>(k)];
    datum.mean.segment<3>(3 * k) = base.mean.vector();
    datum.covariance.block<3, 3>(3 * k, 3 * k) = base.covariance;
    bases.push_back({3 * k, {UnknownKind::kBase, static_cast<int>(k) + 1}});
  }
  bases_are_given_ = true;
  compass_goes_on_.push_back(true);
  drift_variance_.push_back(0.0);
  maps_.push_back({std::move(datum), {}});
  level_->introduce(maps_.back(), bases);  // (W-1)
  put(maps_.back(), bases);
  level_->settle();
  reach_.add({}, *level_);
}

JoinReport PortJoiner::take(LevelledSubmap submap) {
  check(submap);
  JoinReport report;
  if (!is_sound(submap)) {  // (P-40)
    submap = without_knowledge(submap);
    ++report.unsound;
  }
  const int newest = submap.index;
  compass_ = submap.compass;
  compass_is_mean_ = submap.compass_mean.has_value();
  double drift_variance = 0.0;
  if (compass_is_mean_) {
    const double time_s = submap.compass_mean->time_s;
    const double drift = config_.offset_drift_rad_per_sqrt_s;
    if (newest > 0 && !offset_is_shared()) {
      if (!(time_s > last_mean_time_s_)) throw InvalidArgument("compass_mean.time_s", time_s, "must be later than that of the map before");
      drift_variance = drift * drift * (time_s - last_mean_time_s_);
      level_->drift(newest - 1, drift_variance);  // (P-4)
    }
    last_mean_time_s_ = time_s;
    insert_compass_mean(submap);
  }
  const MapExtent extent = extent_of(submap);
  maps_.push_back({std::move(submap), {}});
  drift_variance_.push_back(drift_variance);
  compass_goes_on_.push_back(bases_are_given_ || offset_goes_on(maps_.back()));
  compass_jumps_ += compass_goes_on_.back() ? 0 : 1;
  if (!bases_are_given_) {
    attach(maps_.back());
    guard_.append(maps_.back().submap, compass_goes_on_.back(), drift_variance);
  }
  level_->settle();
  reach_.add(extent, *level_);

  const auto fix = [&](const std::optional<BaseFix>& base_fix, int base) {
    if (!base_fix) return;
    report.fixes.push_back(fixes_.take(*base_fix, base, *level_, maps_));
    if (report.fixes.back().relocated) chain_anew();  // a map has been loosened
  };
  fix(maps_.back().submap.start_fix, newest);
  fix(maps_.back().submap.exit_fix, newest + 1);
  if (config_.association == AssociationMethod::kKnown) {
    LoopAttempt all;
    const std::vector<Match> matches = standing(newest, match_by_identity(newest), all);
    join(newest, matches);
    std::map<int, int> pairs_with;
    for (const Match& match : matches) ++pairs_with[match.other.map->base()];
    for (const auto& [other, pairs] : pairs_with) {
      LoopAttempt loop;
      loop.time_s = maps_.back().submap.end_time_s;
      loop.from = newest;
      loop.to = other;
      loop.accepted = true;
      loop.pairs = pairs;
      loop.wrong_pairs = 0;
      report.loops.push_back(loop);
      ++report.candidates;
    }
    revise(report);
    return report;
  }
  const std::vector<int> others = reach_.of_newest(*level_);
  report.append(pair_with(newest, others, false));
  for (const int other : others) report.append(pair_with(other, {newest}, true));
  std::vector<int> around = others;
  around.push_back(newest);
  merge_duplicates(around);
  revise(report);
  return report;
}

std::vector<PortJoiner::Match> PortJoiner::match_by_identity(int newest) const {
  const PortMap& map = maps_[static_cast<std::size_t>(newest)];
  std::vector<Match> matches;
  std::set<std::int64_t> met;  // an identity twice in one map counts once
  for (Eigen::Index i = 0; i < map.submap.landmark_count(); ++i) {
    const std::optional<std::int64_t> id = map.submap.landmarks[static_cast<std::size_t>(i)].source_id;
    if (!id || !met.insert(*id).second) continue;
    const auto known = first_seen_.find(*id);
    if (known != first_seen_.end() && known->second.map != &map) matches.push_back({i, known->second});
  }
  return matches;
}

double PortJoiner::density_around(int observer, const std::vector<Sighting>& predicted) const {
  const MapExtent& extent = reach_.extent(observer);
  const PortMap& map = maps_[static_cast<std::size_t>(observer)];
  const double radius = std::max(extent.radius_m, kSmallestNeighbourhood_m);
  const Eigen::Vector2d centre = level_->values().base(observer) * extent.centroid;
  Eigen::Index near = 0;
  for (const Sighting& sighting : predicted) {
    const Eigen::Vector2d base_p = sighting.map->submap.mean.segment<2>(sighting.row());
    if ((level_->values().base(sighting.map->base()) * base_p - centre).norm() <= radius) ++near;
  }
  return static_cast<double>(std::max(near, map.submap.landmark_count())) / (kPi * radius * radius);
}

JoinReport PortJoiner::pair_with(int observer, const std::vector<int>& others, bool only_ports) {
  JoinReport report;
  const PortMap& map = maps_[static_cast<std::size_t>(observer)];
  const auto holds = [&](const Unknown& port) {
    return std::any_of(map.ports.begin(), map.ports.end(), [&](const Port& own) { return own.unknown == port; });
  };
  std::vector<Sighting> observed;
  for (Eigen::Index i = 0; i < map.submap.landmark_count(); ++i) {
    const Sighting own{&map, i};
    if (!own.port()) observed.push_back(own);
  }
  std::vector<Sighting> predicted;
  std::vector<Unknown> listed;  // ports, each to be met once
  for (const int other : others) {
    const PortMap& known = maps_[static_cast<std::size_t>(other)];
    for (Eigen::Index i = 0; i < known.submap.landmark_count(); ++i) {
      const Sighting sighting{&known, i};
      const std::optional<Unknown> port = sighting.port();
      if (port && (holds(*port) || std::find(listed.begin(), listed.end(), *port) != listed.end())) continue;
      if (!port && only_ports) continue;
      if (port) listed.push_back(*port);
      predicted.push_back(sighting);
    }
  }
  report.candidates = static_cast<int>(others.size());
  const SightingPairs found = associate_sightings(observed, predicted, *level_, density_around(observer, predicted), association_);
  report.budget_exhausted = found.budget_exhausted;
  if (found.pairs.empty() && found.refused == 0) return report;

  std::vector<Match> matches;
  for (const Pair& pair : found.pairs) {
    matches.push_back(
        {observed[static_cast<std::size_t>(pair.observation)].landmark, predicted[static_cast<std::size_t>(pair.prediction)]});
  }
  LoopAttempt attempt;
  attempt.time_s = map.submap.end_time_s;
  attempt.from = observer;
  attempt.to = matches.empty() ? others.front() : matches.front().other.map->base();
  attempt.accepted = !matches.empty();
  if (!attempt.accepted) attempt.reason = "chance explains the pairs";
  attempt.pairs = static_cast<int>(matches.size());
  attempt.chi_squared = found.joint_squared_distance;
  attempt.dof = 2 * attempt.pairs;
  attempt.sigma_m = found.sigma_m;
  attempt.wrong_pairs = 0;
  for (const Match& match : matches) {
    const auto& own = map.submap.landmarks[static_cast<std::size_t>(match.own)].source_id;
    const auto& other = match.other.map->submap.landmarks[static_cast<std::size_t>(match.other.landmark)].source_id;
    if (!own || !other) {
      attempt.wrong_pairs.reset();
      break;
    }
    *attempt.wrong_pairs += *own != *other ? 1 : 0;
  }
  const std::vector<Match> kept = standing(observer, matches, attempt);
  report.loops.push_back(attempt);
  join(observer, kept);
  return report;
}

void PortJoiner::join(int observer, const std::vector<Match>& matches) {
  PortMap& map = maps_[static_cast<std::size_t>(observer)];
  if (config_.association == AssociationMethod::kKnown) {
    for (Eigen::Index i = 0; i < map.submap.landmark_count(); ++i) {
      const auto& id = map.submap.landmarks[static_cast<std::size_t>(i)].source_id;
      if (id) first_seen_.try_emplace(*id, Sighting{&map, i});
    }
  }
  if (matches.empty()) return;
  tie(observer, matches);
  level_->settle();
}

void PortJoiner::tie(int observer, const std::vector<Match>& matches) {
  PortMap& map = maps_[static_cast<std::size_t>(observer)];
  std::map<int, std::vector<Port>> promoted;  // by the map that saw them first: stacked, so that their cross terms are kept
  for (const Match& match : matches) {
    if (!match.other.port()) promoted[match.other.map->base()].push_back({match.other.row(), {UnknownKind::kLandmark, 0}});
  }
  for (auto& [base, ports] : promoted) {
    for (Port& port : ports) port.unknown.index = landmark_ports_++;
    level_->introduce(maps_[static_cast<std::size_t>(base)], ports);  // (P-7)
    put(maps_[static_cast<std::size_t>(base)], ports);
  }
  std::vector<Port> tied;
  for (const Match& match : matches) tied.push_back({map.submap.landmark_offset(match.own), *match.other.port()});
  level_->tie(map, tied);  // (P-8)
  put(map, tied);
}

void PortJoiner::merge_duplicates(const std::vector<int>& among) {
  if (!(config_.duplicate_probability > 0.0) || config_.association == AssociationMethod::kKnown) return;
  const DuplicateConfig config{config_.gate_probability, config_.duplicate_probability, config_.max_chance_odds,
                               config_.max_descriptor_distance};
  while (true) {
    const std::vector<Duplicate> found = likely_duplicates(maps_, among, *level_, config);
    if (found.empty()) return;
    for (const Duplicate& duplicate : found) merge(duplicate);
    level_->settle();
  }
}

void PortJoiner::merge(const Duplicate& duplicate) {
  const auto identity = [](const Sighting& sighting) {
    return sighting.map->submap.landmarks[static_cast<std::size_t>(sighting.landmark)].source_id;
  };
  const Sighting& a = duplicate.a;
  const Sighting& b = duplicate.b;
  const bool wrong = identity(a) && identity(b) && *identity(a) != *identity(b);
  ++merged_;
  if (wrong) ++wrongly_merged_;
  const auto newest = static_cast<int>(maps_.size()) - 1;
  ties_.push_back({Tie::Kind::kUnite, newest, batches_++, a.map->base(), a.landmark, b.map->base(), b.landmark, {}, wrong});
  unite(a, b);
}

void PortJoiner::unite(Sighting a, Sighting b) {
  if (a.port() && a.port() == b.port()) return;
  if (!a.port() && b.port()) std::swap(a, b);
  PortMap& map_of_b = map_at(b.map->base());
  if (!a.port()) {
    PortMap& map_of_a = map_at(a.map->base());
    const std::vector<Port> promoted{{a.row(), {UnknownKind::kLandmark, landmark_ports_++}}};
    level_->introduce(map_of_a, promoted);  // (P-7)
    put(map_of_a, promoted);
  }
  const Unknown kept = *a.port();
  if (!b.port()) {  // a second entry for the same unknown, of whichever map
    const std::vector<Port> tied{{b.row(), kept}};
    level_->tie(map_of_b, tied);  // (P-8)
    put(map_of_b, tied);
    return;
  }
  const Unknown gone = *b.port();
  level_->merge_landmarks(kept.index, gone.index);  // (P-19)
  for (PortMap& map : maps_) {
    for (Port& port : map.ports) {
      if (port.unknown == gone) port.unknown = kept;
    }
  }
}

JoinReport PortJoiner::finish() {
  JoinReport report;
  level_->adjust();
  if (guard_.size() > 0) judge_by_the_rest(guard_.poses_near(guard_.size() - 1), report);
  const int before = merged_;
  std::vector<int> all;
  for (const PortMap& map : maps_) all.push_back(map.base());
  merge_duplicates(all);
  if (merged_ > before) level_->adjust();
  return report;
}

GaussianSe2 PortJoiner::global_T_newest_base() const {
  const auto newest = static_cast<int>(maps_.size());
  return {level_->values().base(newest), level_->covariance({{UnknownKind::kBase, newest}})};
}

void PortJoiner::archive(Archive& a) {
  if (bases_are_given_) throw InvalidArgument("archive", "maps that are no chain", "a season is joined anew from its runs");
  std::map<std::int64_t, std::pair<int, Eigen::Index>> first_seen;  // a sighting by the number of its map
  for (const auto& [id, sighting] : first_seen_) first_seen[id] = {sighting.map->base(), sighting.landmark};
  bool has_compass = compass_.has_value();
  CompassPorts compass = compass_.value_or(CompassPorts::kNone);
  a("level", *level_);
  a("maps", maps_);
  a("fixes", fixes_);
  a("reach", reach_);
  a("first_seen", first_seen);
  a("has_compass", has_compass);
  a.choice("compass", compass, CompassPorts::kBorders);
  a("compass_is_mean", compass_is_mean_);
  a("last_mean_time_s", last_mean_time_s_);
  a("landmark_ports", landmark_ports_);
  a("compass_jumps", compass_jumps_);
  a("merged", merged_);
  a("wrongly_merged", wrongly_merged_);
  a("compass_goes_on", compass_goes_on_);
  a("drift_variance", drift_variance_);
  a("guard", guard_);
  a("ties", ties_);
  a("in_force", in_force_);
  a("batches", batches_);
  if (!a.reading()) return;
  a.require(reach_.maps() == maps_.size(), "has more or fewer extents than maps");
  if (has_compass) compass_ = compass;
  for (const auto& [id, sighting] : first_seen) {
    a.require(sighting.first >= 0 && static_cast<std::size_t>(sighting.first) < maps_.size(), "has a landmark of a map that is not there");
    first_seen_[id] = {&maps_[static_cast<std::size_t>(sighting.first)], sighting.second};
  }
  check_read();
  check_ties();
  level_->resume(maps_);
  chain_anew();
}

/// Throws InvalidArgument where maps, ports and level do not fit each other.
void PortJoiner::check_read() const {
  int next = 0;
  for (const PortMap& map : maps_) {
    const std::string name = "map " + std::to_string(next);
    if (map.base() != next++) throw InvalidArgument(name, map.base(), "stands in the place of another");
    for (const Port& port : map.ports) {
      if (port.row < 0 || port.row + rows_of(port.unknown.kind) > map.submap.mean.size() || !level_->values().holds(port.unknown))
        throw InvalidArgument(name, number(port.row), "has a port that is no entry of its state or of no unknown");
    }
  }
  for (const auto& [id, sighting] : first_seen_) {
    if (sighting.landmark < 0 || sighting.landmark >= sighting.map->submap.landmark_count())
      throw InvalidArgument("landmark", number(sighting.landmark), "is none of its map");
  }
  if (level_->values().bases.size() != maps_.size() + 1)
    throw InvalidArgument("bases", static_cast<double>(level_->values().bases.size()), "must be one more than the maps");
}

}  // namespace ssjs
