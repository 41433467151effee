#include "ssjs/mapping/submap_builder.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "ssjs/association/compatibility.hpp"
#include "ssjs/association/nearest_neighbour.hpp"
#include "ssjs/association/randomized_joint_compatibility.hpp"
#include "ssjs/base/chi_squared.hpp"

namespace ssjs {
namespace {

constexpr Eigen::Index kInitialCapacity = 32;  // landmarks; grows when a submap does
constexpr double kPreselectionSigmas = 6.0;    // beyond the dead band's 5 sigma, so that preselection never decides

std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

double normalized_squared(const Eigen::Vector2d& residual, const Eigen::Matrix2d& covariance) {
  return residual.dot(covariance.llt().solve(residual));
}

}  // namespace

SubmapBuilder::SubmapBuilder(const SubmapBuilderConfig& config, const ScanAssociationConfig& association, std::uint64_t seed)
    : config_(config),
      association_(association),
      rng_(Rng(seed).stream("scan association")),
      ekf_(kInitialCapacity, config.invariant_filter ? ErrorForm::kInvariant : ErrorForm::kAdditive) {
  ekf_.reset({});
  if (config_.condition_trajectory) ekf_.watch(&journal_);
  if (association_.identity_gate_probability) identity_gate_ = chi_squared_quantile(*association_.identity_gate_probability, 2.0);
}

void SubmapBuilder::start(double time_s) {
  ekf_.reset({});  // the vehicle is at the base, exactly
  tracked_.clear();
  journal_.clear();
  start_time_s_ = time_s;
  started_ = true;
  scans_ = 0;
  distance_m_ = moved_m_ = turned_rad_ = 0.0;
}

void SubmapBuilder::predict(double time_s, const MotionPrediction& motion) {
  if (!started_) start(time_s);
  const double moved = (motion.submap_T_vehicle.translation() - ekf_.vehicle_pose().translation()).norm();
  distance_m_ += moved;
  moved_m_ += moved;
  turned_rad_ += std::abs(angle_difference(motion.submap_T_vehicle.heading, ekf_.vehicle_pose().heading));
  ekf_.predict(motion);
  time_s_ = time_s;
}

void SubmapBuilder::record_step(double time_s) {
  if (!started_) start(time_s);
  journal_.step(time_s, ekf_);
}

ScanResult SubmapBuilder::observe(double time_s, const Features& scan) {
  if (!started_) start(time_s);
  time_s_ = time_s;
  ScanResult result;
  const bool moved_enough = moved_m_ >= config_.min_motion_m || (config_.min_rotation_rad > 0.0 && turned_rad_ >= config_.min_rotation_rad);
  if (!scan_due_ && !moved_enough) return result;
  scan_due_ = false;
  moved_m_ = turned_rad_ = 0.0;
  ++scans_;

  const auto begin = std::chrono::steady_clock::now();
  const Hypothesis hypothesis = associate(scan);
  result.association_time_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  result.budget_exhausted = hypothesis.budget_exhausted;

  std::vector<bool> is_paired(scan.size(), false);
  for (const Pair& pair : hypothesis.pairs) {
    is_paired[at(pair.observation)] = true;
    const auto& known = tracked_[at(selected_[at(pair.prediction)])].landmark.source_id;
    const auto& seen = scan[at(pair.observation)].landmark_id;
    if (known && seen && *known != *seen) ++result.wrong_pairs;
  }
  std::vector<Eigen::Index> fresh;  // outside the dead band
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (is_paired[i]) continue;
    const auto& nearest = hypothesis.nearest_squared_distance[i];
    if (!nearest || *nearest > association_.new_landmark_squared_distance) {
      fresh.push_back(static_cast<Eigen::Index>(i));
    }
  }

  if (const auto reason = reason_to_close(situation(time_s, hypothesis, static_cast<int>(fresh.size())), config_.split)) {
    // (C-2): matched observations alternate by bearing between the two submaps; the new one takes everything unpaired, as its dead band
    // is empty, but for misread identities.
    std::vector<Pair> by_bearing = hypothesis.pairs;
    std::sort(by_bearing.begin(), by_bearing.end(),
              [&](const Pair& a, const Pair& b) { return scan[at(a.observation)].bearing() < scan[at(b.observation)].bearing(); });
    const bool share = config_.split_boundary_scan && by_bearing.size() >= 4;
    std::vector<Pair> for_old;
    Features for_new;
    for (std::size_t i = 0; i < by_bearing.size(); ++i) {
      if (share && i % 2 == 1) {
        for_new.push_back(scan[at(by_bearing[i].observation)]);
      } else {
        for_old.push_back(by_bearing[i]);
      }
    }
    for (std::size_t i = 0; i < scan.size(); ++i) {
      const bool misread = association_.method == AssociationMethod::kKnown && hypothesis.nearest_squared_distance[i].has_value();
      if (!is_paired[i] && !misread) for_new.push_back(scan[i]);
    }
    update(scan, for_old, result);
    result.closed = finish(*reason);
    start(time_s);
    scans_ = 1;
    for (const Feature& feature : for_new) result.added += add(feature) ? 1 : 0;
    result.dropped = static_cast<int>(scan.size()) - result.paired - result.added;
    return result;
  }

  update(scan, hypothesis.pairs, result);
  for (const Eigen::Index i : fresh) result.added += add(scan[at(i)]) ? 1 : 0;
  result.dropped = static_cast<int>(scan.size()) - result.paired - result.added;
  prune();
  return result;
}

SplitSituation SubmapBuilder::situation(double time_s, const Hypothesis& hypothesis, int new_landmarks) const {
  SplitSituation now;
  for (const Tracked& tracked : tracked_) now.landmarks += confirmed(tracked) ? 1 : 0;
  if (config_.min_sightings == 1) {
    now.new_landmarks = new_landmarks;
  } else {
    for (const Pair& pair : hypothesis.pairs) {
      if (tracked_[at(selected_[at(pair.prediction)])].landmark.times_seen + 1 == config_.min_sightings) ++now.new_landmarks;
    }
  }
  now.submap_T_vehicle = base_T_vehicle();
  now.distance_m = distance_m_;
  now.duration_s = time_s - start_time_s_;
  return now;
}

Hypothesis SubmapBuilder::associate_by_identity(const Features& scan) {
  Hypothesis hypothesis;
  hypothesis.nearest_squared_distance.resize(scan.size());
  selected_.clear();
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (!scan[i].landmark_id) continue;
    const auto here = scan.begin() + static_cast<std::ptrdiff_t>(i);
    if (std::any_of(scan.begin(), here, [&](const Feature& earlier) { return earlier.landmark_id == scan[i].landmark_id; })) {
      hypothesis.nearest_squared_distance[i] = 0.0;  // the same identity twice in one scan: the second is neither paired nor new
      continue;
    }
    const auto same = [&](const Tracked& tracked) { return tracked.landmark.source_id == scan[i].landmark_id; };
    const auto found = std::find_if(tracked_.begin(), tracked_.end(), same);
    if (found == tracked_.end()) continue;
    hypothesis.pairs.push_back({static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(selected_.size())});
    selected_.push_back(found - tracked_.begin());
  }
  if (!identity_gate_ || selected_.empty()) return hypothesis;
  pose_problem(scan);
  const auto misread = [&](const Pair& pair) {
    const Eigen::Vector2d residual = pair_residual(problem_, pair.observation, pair.prediction);
    const double distance = normalized_squared(residual, pair_covariance(problem_, pair, pair));
    if (distance <= *identity_gate_) return false;
    hypothesis.nearest_squared_distance[at(pair.observation)] = 0.0;  // not a new landmark either
    return true;
  };
  hypothesis.pairs.erase(std::remove_if(hypothesis.pairs.begin(), hypothesis.pairs.end(), misread), hypothesis.pairs.end());
  return hypothesis;
}

void SubmapBuilder::pose_problem(const Features& scan) {
  const auto m = static_cast<Eigen::Index>(scan.size());
  problem_.observed.resize(2 * m);
  problem_.observed_covariance.setZero(2 * m, 2 * m);
  for (Eigen::Index i = 0; i < m; ++i) {
    problem_.observed.segment<2>(2 * i) = scan[at(i)].range_bearing;
    problem_.observed_covariance.block<2, 2>(2 * i, 2 * i) = scan[at(i)].covariance;
  }
  ekf_.predict_observations(selected_, problem_);
}

void SubmapBuilder::preselect(const Features& scan) {
  selected_.clear();
  double farthest = 0.0;
  double sigma_range = 0.0;
  for (const Feature& feature : scan) {
    farthest = std::max(farthest, feature.range());
    sigma_range = std::max(sigma_range, std::sqrt(feature.covariance(0, 0)));
  }
  const Se2& pose = ekf_.vehicle_pose();
  const double vehicle_variance = ekf_.vehicle_covariance().topLeftCorner<2, 2>().trace();
  for (Eigen::Index i = 0; i < ekf_.landmarks(); ++i) {
    const double distance = (ekf_.landmark_position(i) - pose.translation()).norm();
    const double spread = std::sqrt(vehicle_variance + ekf_.landmark_covariance(i).trace()) + sigma_range;
    if (distance <= farthest + kPreselectionSigmas * spread && distance > 1e-6) selected_.push_back(i);
  }
}

Hypothesis SubmapBuilder::associate(const Features& scan) {
  if (association_.method == AssociationMethod::kKnown) return associate_by_identity(scan);
  preselect(scan);
  pose_problem(scan);
  const JointCompatibilityConfig joint{association_.gate_probability, association_.joint_gate_probability, association_.node_budget};
  switch (association_.method) {
    case AssociationMethod::kNearestNeighbour:
      return nearest_neighbour(problem_, association_.gate_probability);
    case AssociationMethod::kRandomizedJointCompatibility: {
      RandomizedJointCompatibilityConfig randomized;
      randomized.joint = joint;
      return randomized_joint_compatibility(problem_, randomized, rng_);
    }
    default:
      return joint_compatibility(problem_, joint);
  }
}

void SubmapBuilder::update(const Features& scan, const std::vector<Pair>& pairs, ScanResult& result) {
  result.paired = static_cast<int>(pairs.size());
  if (pairs.empty()) return;
  result.update = ekf_.update(scan, pairs, selected_);
  for (const Pair& pair : pairs) ++tracked_[at(selected_[at(pair.prediction)])].landmark.times_seen;
}

bool SubmapBuilder::add(const Feature& feature) {
  if (std::count_if(tracked_.begin(), tracked_.end(), [&](const Tracked& t) { return !confirmed(t); }) >= config_.max_tentative)
    return false;
  ekf_.add_landmark(feature);
  tracked_.push_back({{1, feature.landmark_id}, scans_});
  return true;
}

void SubmapBuilder::remove(Eigen::Index landmark) {
  ekf_.remove_landmark(landmark);
  tracked_[at(landmark)] = tracked_.back();
  tracked_.pop_back();
}

void SubmapBuilder::prune() {
  if (!config_.prune_after_scans) return;
  for (Eigen::Index i = ekf_.landmarks() - 1; i >= 0; --i) {
    if (!confirmed(tracked_[at(i)]) && scans_ - tracked_[at(i)].first_scan >= *config_.prune_after_scans) remove(i);
  }
}

Submap SubmapBuilder::finish(const std::string& reason) {
  for (Eigen::Index i = ekf_.landmarks() - 1; i >= 0; --i) {
    if (!confirmed(tracked_[at(i)])) remove(i);
  }
  Submap submap;
  submap.index = index_++;
  submap.start_time_s = start_time_s_;
  submap.end_time_s = time_s_;
  submap.closed_because = reason;
  submap.state = ekf_.state();
  for (const Tracked& tracked : tracked_) submap.landmarks.push_back(tracked.landmark);
  submap.steps = config_.condition_trajectory ? journal_.steps(submap.state.vehicle()) : journal_.unconditioned_steps();
  return submap;
}

}  // namespace ssjs
