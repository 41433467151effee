#include "ssjs/joining/batch_ports.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "ssjs/base/angle.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/geometry/gaussian.hpp"

namespace ssjs {
namespace {

constexpr int kMaxIterations = 30;
constexpr int kMaxHalvings = 8;
constexpr double kTolerance = 1e-12;  // of half chi-squared
constexpr double kRelativeDecrease = 1e-13;
// On the way to the solution a factor serves on while the unknowns are so near to where it was made.
constexpr double kSteadyTurn_rad = 1e-3;
constexpr double kSteadyWay_m = 0.1;
constexpr double kSlowDecrease = 0.1;  // of what the step before promised: the factor is too old

}  // namespace

BatchPorts::BatchPorts() { values_.bases.emplace_back(); }

void BatchPorts::align_to_north(const PortMap& map, Eigen::Index row, const OffsetPrior& prior) {
  if (!factors_.empty()) throw InvalidArgument("align_to_north", "late call", "comes before every map");
  prior_ = prior;
  values_.offsets.push_back(prior.mean_rad);
  values_.bases.front().heading = wrap_angle(map.submap.mean(row) - prior.mean_rad);
  set_factor(map, {{row, {UnknownKind::kOffset, 0}}});
}

void BatchPorts::introduce(const PortMap& map, const std::vector<Port>& ports) {
  append_values(values_, map, ports);
  const auto is_base = [](const Port& port) { return port.unknown.kind == UnknownKind::kBase; };
  if (std::any_of(ports.begin(), ports.end(), is_base)) {
    at_hand_ = {};
    is_adjusted_ = false;
  }
  count_landmarks();
  set_factor(map, ports);
}

void BatchPorts::tie(const PortMap& map, const std::vector<Port>& ports) { set_factor(map, ports); }

void BatchPorts::drift(int from, double variance) {
  drifts_.push_back({from, static_cast<int>(values_.offsets.size()), variance});
  values_.offsets.push_back(values_.offset(from));
  pattern_is_stale_ = true;
}

void BatchPorts::merge_landmarks(int keep, int gone) {
  for (auto& [base, factor] : factors_) {  // (P-19)
    for (Port& port : factor.ports) {
      if (port.unknown == Unknown{UnknownKind::kLandmark, gone}) port.unknown.index = keep;
    }
  }
  merged_.insert(gone);
  at_hand_.rows.erase({UnknownKind::kLandmark, gone});
  count_landmarks();
  pattern_is_stale_ = true;
}

void BatchPorts::free_start(const StartPrior& prior) {
  if (start_prior_) return;
  start_prior_ = prior;
  pattern_is_stale_ = true;
}

void BatchPorts::fix(const FixFactor& fix) {
  fixes_.push_back(fix);
  pattern_is_stale_ = true;  // of a base that no map holds yet
}

void BatchPorts::count_landmarks() {
  landmark_places_.clear();
  int living = 0;
  for (int i = 0; i < static_cast<int>(values_.landmarks.size()); ++i) landmark_places_.push_back(merged_.count(i) > 0 ? -1 : living++);
}

void BatchPorts::set_values(const PortValues& values) {
  values_ = values;
  at_hand_ = {};
}

void BatchPorts::set_factor(const PortMap& map, const std::vector<Port>& more) {
  Factor factor{map.ports, {}, {}};
  factor.ports.insert(factor.ports.end(), more.begin(), more.end());
  const Eigen::VectorXi rows = state_rows(factor.ports);
  factor.mean = map.submap.mean(rows);
  const std::string name = "map " + std::to_string(map.base());
  const Eigen::MatrixXd L = cholesky_lower(map.submap.covariance(rows, rows), "covariance of the ports", name.c_str());
  const Eigen::MatrixXd L_inverse = L.triangularView<Eigen::Lower>().solve(Eigen::MatrixXd::Identity(rows.size(), rows.size()));
  factor.information = L_inverse.transpose() * L_inverse;
  factors_[map.base()] = std::move(factor);
  pattern_is_stale_ = true;
}

std::pair<Eigen::Index, Eigen::Index> BatchPorts::free_rows(const Unknown& unknown) const {
  if (unknown.kind == UnknownKind::kBase && unknown.index == 0 && !start_prior_) return {2, 1};  // of a world aligned to north: the heading
  return {0, rows_of(unknown.kind)};
}

int BatchPorts::slot(const Unknown& unknown) const {
  const int first_base = prior_ || start_prior_ ? 0 : 1;  // base 0 is the world, or free to turn, or free
  const int bases = static_cast<int>(values_.bases.size()) - first_base;
  const int offsets = static_cast<int>(values_.offsets.size());
  switch (unknown.kind) {
    case UnknownKind::kBase:
      return unknown.index - first_base;
    case UnknownKind::kOffset:
      return bases + unknown.index;
    case UnknownKind::kLandmark:
      break;
  }
  const int place = landmark_places_[static_cast<std::size_t>(unknown.index)];
  return place < 0 ? -1 : bases + offsets + place;
}

std::vector<Unknown> BatchPorts::unknowns() const {
  std::vector<Unknown> all;
  for (std::size_t i = 0; i < values_.bases.size(); ++i) all.push_back({UnknownKind::kBase, static_cast<int>(i)});
  for (std::size_t i = 0; i < values_.offsets.size(); ++i) all.push_back({UnknownKind::kOffset, static_cast<int>(i)});
  for (std::size_t i = 0; i < values_.landmarks.size(); ++i) {
    if (landmark_places_[i] >= 0) all.push_back({UnknownKind::kLandmark, static_cast<int>(i)});
  }
  return all;
}

std::string BatchPorts::name_of(int slot_index) const {
  for (const Unknown& unknown : unknowns()) {
    if (slot(unknown) != slot_index) continue;
    const char* const kind = unknown.kind == UnknownKind::kBase     ? "base "
                             : unknown.kind == UnknownKind::kOffset ? "compass offset "
                                                                    : "landmark ";
    return kind + std::to_string(unknown.index);
  }
  return "an unknown";
}

void BatchPorts::analyse() {
  std::vector<int> sizes;
  for (const Unknown& unknown : unknowns()) {
    if (slot(unknown) >= 0) sizes.push_back(static_cast<int>(free_rows(unknown).second));
  }
  std::vector<BlockPosition> blocks;
  const auto couple = [&](int a, int b) {
    if (a >= b && b >= 0) blocks.emplace_back(a, b);
  };
  for (const auto& [base, factor] : factors_) {
    std::vector<int> touched{slot({UnknownKind::kBase, base})};
    for (const Port& port : factor.ports) touched.push_back(slot(port.unknown));
    for (const int a : touched) {
      for (const int b : touched) couple(a, b);
    }
  }
  for (const FixFactor& fix : fixes_) couple(slot({UnknownKind::kBase, fix.base}), slot({UnknownKind::kBase, fix.base}));
  for (const Drift& drift : drifts_) couple(slot({UnknownKind::kOffset, drift.to}), slot({UnknownKind::kOffset, drift.from}));
  hessian_.set_pattern(sizes, blocks);
  pattern_is_stale_ = false;
}

double BatchPorts::linearize(bool with_hessian) {
  if (with_hessian) hessian_.set_zero();
  gradient_.setZero(hessian_.rows());
  double cost = 0.0;
  for (const auto& [base, factor] : factors_) {  // (P-6)
    const PortPlacement placed = place_ports(base, factor.ports, values_);
    const Eigen::VectorXd residual = port_difference(factor.ports, placed.s, factor.mean);
    const Eigen::VectorXd W_residual = factor.information * residual;
    cost += 0.5 * residual.dot(W_residual);
    Eigen::MatrixXd W_J;
    if (with_hessian) W_J = factor.information * placed.J;
    for (std::size_t i = 0; i < placed.unknowns.size(); ++i) {
      const int at_i = slot(placed.unknowns[i]);
      if (at_i < 0) continue;
      const auto [first_i, count_i] = free_rows(placed.unknowns[i]);
      const auto J_i = placed.J.middleCols(placed.columns[i] + first_i, count_i);
      gradient_.segment(hessian_.row_of(at_i), count_i) += J_i.transpose() * W_residual;
      for (std::size_t j = 0; with_hessian && j < placed.unknowns.size(); ++j) {
        const auto [first_j, count_j] = free_rows(placed.unknowns[j]);
        const int at_j = slot(placed.unknowns[j]);
        if (at_j < 0 || at_i < at_j) continue;
        hessian_.add<Eigen::Dynamic, Eigen::Dynamic>(at_i, at_j, J_i.transpose() * W_J.middleCols(placed.columns[j] + first_j, count_j));
      }
    }
  }
  const auto add_scalar = [&](int row, int column, double value) {
    if (with_hessian) hessian_.add<1, 1>(row, column, Eigen::Matrix<double, 1, 1>(value));
  };
  for (const Drift& drift : drifts_) {  // (P-4)
    const double residual = wrap_angle(values_.offset(drift.to) - values_.offset(drift.from));
    const int to = slot({UnknownKind::kOffset, drift.to});
    const int from = slot({UnknownKind::kOffset, drift.from});
    const double W = 1.0 / drift.variance;
    cost += 0.5 * residual * residual * W;
    gradient_(hessian_.row_of(to)) += W * residual;
    gradient_(hessian_.row_of(from)) -= W * residual;
    add_scalar(to, to, W);
    add_scalar(from, from, W);
    add_scalar(to, from, -W);
    add_scalar(from, to, -W);
  }
  for (const FixFactor& fix : fixes_) {  // (P-30)
    const PlacedFix placed = place_fix(values_.base(fix.base), fix.base_p);
    const Eigen::Vector2d residual = placed.world_p - fix.world_p;
    const Eigen::Matrix2d W = fix.covariance.inverse();
    const int at = slot({UnknownKind::kBase, fix.base});
    cost += 0.5 * residual.dot(W * residual);
    gradient_.segment<3>(hessian_.row_of(at)) += placed.J_base.transpose() * W * residual;
    if (with_hessian) hessian_.add<3, 3>(at, at, placed.J_base.transpose() * W * placed.J_base);
  }
  if (start_prior_ && !prior_) {  // (P-31)
    const int at = slot({UnknownKind::kBase, 0});
    const double heading = values_.base(0).heading;
    cost += 0.5 * heading * heading / start_prior_->heading_variance;
    gradient_(hessian_.row_of(at) + 2) += heading / start_prior_->heading_variance;
    if (with_hessian)
      hessian_.add<3, 3>(at, at, Eigen::Vector3d(0.0, 0.0, 1.0 / start_prior_->heading_variance).asDiagonal().toDenseMatrix());
  }
  if (prior_) {  // (P-4)
    const double residual = wrap_angle(values_.offsets.front() - prior_->mean_rad);
    const int at = slot({UnknownKind::kOffset, 0});
    cost += 0.5 * residual * residual / prior_->variance;
    gradient_(hessian_.row_of(at)) += residual / prior_->variance;
    add_scalar(at, at, 1.0 / prior_->variance);
  }
  return cost;
}

void BatchPorts::factorize() {
  at_hand_.covariance.resize(0, 0);
  if (!hessian_.all_finite()) {
    throw NotPositiveDefinite("information matrix of the survey", "a map or an estimate is not finite");
  }
  if (const std::optional<int> loose = hessian_.factorize()) {
    throw NotPositiveDefinite("information matrix of the survey", name_of(*loose) + " is not held by any map");
  }
}

void BatchPorts::move(const PortValues& start, const Eigen::VectorXd& step) {
  values_ = start;
  for (const Unknown& unknown : unknowns()) {
    const int at = slot(unknown);
    if (at < 0) continue;
    const auto [first, count] = free_rows(unknown);
    Eigen::Vector3d by = Eigen::Vector3d::Zero();
    by.segment(first, count) = step.segment(hessian_.row_of(at), count);
    values_.move(unknown, by.head(rows_of(unknown.kind)));
  }
}

bool BatchPorts::is_near(const PortValues& other) const {
  for (std::size_t i = 0; i < values_.bases.size(); ++i) {
    if (std::abs(angle_difference(values_.bases[i].heading, other.bases[i].heading)) > kSteadyTurn_rad ||
        (values_.bases[i].translation() - other.bases[i].translation()).norm() > kSteadyWay_m)
      return false;
  }
  return true;
}

void BatchPorts::settle() {
  if (pattern_is_stale_) analyse();
  cost_ = linearize(true);
  factorized_at_ = values_;
  if (hessian_.rows() == 0) return;
  factorize();
  bool moved = false;  // since the Hessian was factorised
  double promised_before = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const Eigen::VectorXd step = hessian_.solve(-gradient_);
    const double promised = -0.5 * step.dot(gradient_);
    if (promised <= kTolerance + kRelativeDecrease * cost_) break;
    const PortValues start = values_;
    double scale = 1.0;
    double cost = cost_;
    for (int halving = 0; halving <= kMaxHalvings; ++halving, scale *= 0.5) {
      move(start, scale * step);
      cost = linearize(false);
      if (cost <= cost_ * (1.0 + kRelativeDecrease) + kTolerance) break;
    }
    moved = true;
    if (scale < 1.0 || promised > kSlowDecrease * promised_before || !is_near(factorized_at_)) {
      cost = linearize(true);
      factorize();
      factorized_at_ = values_;
      moved = false;
    }
    promised_before = promised;
    const double decrease = cost_ - cost;
    cost_ = cost;
    if (std::abs(decrease) <= kTolerance + kRelativeDecrease * cost_) break;
  }
  if (!moved) return;
  cost_ = linearize(true);  // covariances are those of the solution
  factorize();
  factorized_at_ = values_;
}

void BatchPorts::adjust() {
  settle();
  is_adjusted_ = true;
}

void BatchPorts::look_up(const std::vector<Unknown>& unknowns) const {
  AtHand& hand = at_hand_;
  bool all_there = hand.covariance.size() > 0;
  for (const Unknown& unknown : unknowns) {
    if (is_fixed(unknown)) continue;
    const auto [place, is_new] = hand.rows.emplace(unknown, 0);
    all_there = all_there && !is_new && place->second + free_rows(unknown).second <= hand.covariance.rows();
  }
  if (all_there || hand.rows.empty()) return;
  hand.covariance.resize(0, 0);  // until the new one is there, lest a failure leaves rows without it
  if (is_adjusted_) {            // the whole survey is told, map after map
    hand.rows.clear();
    for (const Unknown& unknown : unknowns) {
      if (!is_fixed(unknown)) hand.rows.emplace(unknown, 0);
    }
  }
  std::vector<int> slots;
  Eigen::Index row = 0;
  for (auto& [unknown, first] : hand.rows) {
    slots.push_back(slot(unknown));
    first = row;
    row += free_rows(unknown).second;
  }
  Eigen::MatrixXd covariance = hessian_.joint_inverse(slots);
  if (covariance.rows() != row)
    throw InvalidArgument("covariance", "changed level", "is there once the level has settled after its last change");
  hand.covariance = std::move(covariance);
}

Eigen::MatrixXd BatchPorts::covariance(const std::vector<Unknown>& unknowns) const {
  look_up(unknowns);
  std::vector<Eigen::Index> starts;
  Eigen::Index size = 0;
  for (const Unknown& unknown : unknowns) {
    starts.push_back(size);
    size += rows_of(unknown.kind);
  }
  Eigen::MatrixXd joint = Eigen::MatrixXd::Zero(size, size);
  for (std::size_t j = 0; j < unknowns.size(); ++j) {
    if (is_fixed(unknowns[j])) continue;
    const auto [first_j, count_j] = free_rows(unknowns[j]);
    const Eigen::Index at_j = at_hand_.rows.at(unknowns[j]);
    for (std::size_t i = 0; i < unknowns.size(); ++i) {
      if (is_fixed(unknowns[i])) continue;
      const auto [first_i, count_i] = free_rows(unknowns[i]);
      joint.block(starts[i] + first_i, starts[j] + first_j, count_i, count_j) =
          at_hand_.covariance.block(at_hand_.rows.at(unknowns[i]), at_j, count_i, count_j);
    }
  }
  return joint;
}

void BatchPorts::resume(const std::deque<PortMap>& maps) {
  const auto known = [&](UnknownKind kind, int index) { return values_.holds({kind, index}); };
  for (const int landmark : merged_) {
    if (!known(UnknownKind::kLandmark, landmark)) throw InvalidArgument("merged landmark", landmark, "must be one of those there are");
  }
  for (const Drift& drift : drifts_) {
    if (!known(UnknownKind::kOffset, drift.from) || !known(UnknownKind::kOffset, drift.to) || !(drift.variance > 0.0))
      throw InvalidArgument("drift to offset", drift.to, "must lead from one offset to another, with a positive variance");
  }
  for (const FixFactor& fix : fixes_) {
    if (!known(UnknownKind::kBase, fix.base)) throw InvalidArgument("fix of base", fix.base, "must be one of those there are");
  }
  const bool settled = !pattern_is_stale_;
  count_landmarks();
  for (const PortMap& map : maps) set_factor(map, {});
  if (!settled) return;
  if (factorized_at_.bases.size() != values_.bases.size() || factorized_at_.offsets.size() != values_.offsets.size() ||
      factorized_at_.landmarks.size() != values_.landmarks.size()) {
    throw InvalidArgument("factorized_at", static_cast<double>(factorized_at_.bases.size()), "must hold the same unknowns as the values");
  }
  for (const auto& [unknown, row] : at_hand_.rows) {
    const bool is_there = at_hand_.covariance.size() == 0 ||
                          (row >= 0 && row <= std::min(at_hand_.covariance.rows(), at_hand_.covariance.cols()) - free_rows(unknown).second);
    if (!known(unknown.kind, unknown.index) || is_fixed(unknown) || !is_there)
      throw InvalidArgument("covariance at hand, row", static_cast<double>(row), "must be one of an unknown");
  }
  const AtHand hand = at_hand_;
  analyse();
  std::swap(values_, factorized_at_);
  static_cast<void>(linearize(true));
  if (hessian_.rows() > 0) factorize();
  std::swap(values_, factorized_at_);
  cost_ = linearize(false);
  at_hand_ = hand;
}

}  // namespace ssjs
