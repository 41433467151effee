#include "ssjs/mapping/scan_association.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <chrono>
#include <cmath>

#include "ssjs/association/compatibility.hpp"
#include "ssjs/association/joint_compatibility.hpp"
#include "ssjs/association/nearest_neighbour.hpp"
#include "ssjs/association/randomized_joint_compatibility.hpp"
#include "ssjs/base/chi_squared.hpp"

namespace ssjs {
namespace {

constexpr double kPreselectionSigmas = 6.0;  // beyond the dead band's 5 sigma, so that preselection never decides

std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

double normalized_squared(const Eigen::Vector2d& residual, const Eigen::Matrix2d& covariance) {
  return residual.dot(covariance.llt().solve(residual));
}

}  // namespace

ScanAssociator::ScanAssociator(const ScanAssociationConfig& config, std::uint64_t seed)
    : config_(config), rng_(Rng(seed).stream("scan association")) {
  if (config_.identity_gate_probability) identity_gate_ = chi_squared_quantile(*config_.identity_gate_probability, 2.0);
}

const ScanAssociation& ScanAssociator::associate(const Features& scan, Ekf& filter, const std::vector<MapLandmark>& landmarks) {
  const auto begin = std::chrono::steady_clock::now();
  answer_.selected.clear();
  if (config_.method == AssociationMethod::kKnown) {
    pair_by_identity(scan, filter, landmarks);
  } else {
    preselect(scan, filter);
    pose_problem(scan, filter);
    const JointCompatibilityConfig joint{config_.gate_probability, config_.joint_gate_probability, config_.node_budget};
    if (config_.method == AssociationMethod::kNearestNeighbour) {
      answer_.hypothesis = nearest_neighbour(problem_, config_.gate_probability);
    } else if (config_.method == AssociationMethod::kRandomizedJointCompatibility) {
      RandomizedJointCompatibilityConfig randomized;
      randomized.joint = joint;
      answer_.hypothesis = randomized_joint_compatibility(problem_, randomized, rng_);
    } else {
      answer_.hypothesis = joint_compatibility(problem_, joint);
    }
  }
  answer_.time_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();

  answer_.is_paired.assign(scan.size(), false);
  answer_.wrong_pairs = 0;
  for (const Pair& pair : answer_.hypothesis.pairs) {
    answer_.is_paired[at(pair.observation)] = true;
    const auto& known = landmarks[at(answer_.selected[at(pair.prediction)])].source_id;
    const auto& seen = scan[at(pair.observation)].landmark_id;
    if (known && seen && *known != *seen) ++answer_.wrong_pairs;
  }
  answer_.fresh.clear();
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (answer_.is_paired[i]) continue;
    const auto& nearest = answer_.hypothesis.nearest_squared_distance[i];
    if (!nearest || *nearest > config_.new_landmark_squared_distance) answer_.fresh.push_back(static_cast<Eigen::Index>(i));
  }
  return answer_;
}

void ScanAssociator::pair_by_identity(const Features& scan, Ekf& filter, const std::vector<MapLandmark>& landmarks) {
  Hypothesis& hypothesis = answer_.hypothesis;
  hypothesis = {};
  hypothesis.nearest_squared_distance.resize(scan.size());
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (!scan[i].landmark_id) continue;
    const auto here = scan.begin() + static_cast<std::ptrdiff_t>(i);
    if (std::any_of(scan.begin(), here, [&](const Feature& earlier) { return earlier.landmark_id == scan[i].landmark_id; })) {
      hypothesis.nearest_squared_distance[i] = 0.0;  // the same identity twice in one scan: the second is neither paired nor new
      continue;
    }
    const auto same = [&](const MapLandmark& landmark) { return landmark.source_id == scan[i].landmark_id; };
    const auto found = std::find_if(landmarks.begin(), landmarks.end(), same);
    if (found == landmarks.end()) continue;
    hypothesis.pairs.push_back({static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(answer_.selected.size())});
    answer_.selected.push_back(found - landmarks.begin());
  }
  if (!identity_gate_ || answer_.selected.empty()) return;
  pose_problem(scan, filter);
  const auto misread = [&](const Pair& pair) {
    const Eigen::Vector2d residual = pair_residual(problem_, pair.observation, pair.prediction);
    const double distance = normalized_squared(residual, pair_covariance(problem_, pair, pair));
    if (distance <= *identity_gate_) return false;
    hypothesis.nearest_squared_distance[at(pair.observation)] = 0.0;  // not a new landmark either
    return true;
  };
  hypothesis.pairs.erase(std::remove_if(hypothesis.pairs.begin(), hypothesis.pairs.end(), misread), hypothesis.pairs.end());
}

void ScanAssociator::pose_problem(const Features& scan, Ekf& filter) {
  const auto m = static_cast<Eigen::Index>(scan.size());
  problem_.observed.resize(2 * m);
  problem_.observed_covariance.setZero(2 * m, 2 * m);
  for (Eigen::Index i = 0; i < m; ++i) {
    problem_.observed.segment<2>(2 * i) = scan[at(i)].range_bearing;
    problem_.observed_covariance.block<2, 2>(2 * i, 2 * i) = scan[at(i)].covariance;
  }
  filter.predict_observations(answer_.selected, problem_);
}

ScanReach::ScanReach(const Features& scan, const Ekf& filter)
    : vehicle_variance_(filter.vehicle_covariance().topLeftCorner<2, 2>().trace()) {
  for (const Feature& feature : scan) {
    farthest_m_ = std::max(farthest_m_, feature.range());
    sigma_range_m_ = std::max(sigma_range_m_, std::sqrt(feature.covariance(0, 0)));
  }
}

double ScanReach::radius_m(double position_variance) const {
  const double spread = std::sqrt(vehicle_variance_ + position_variance) + sigma_range_m_;
  return farthest_m_ + kPreselectionSigmas * spread;
}

void ScanAssociator::preselect(const Features& scan, const Ekf& filter) {
  const ScanReach reach(scan, filter);
  const Se2& pose = filter.vehicle_pose();
  for (Eigen::Index i = 0; i < filter.landmarks(); ++i) {
    const double distance = (filter.landmark_position(i) - pose.translation()).norm();
    if (distance <= reach.radius_m(filter.landmark_covariance(i).trace()) && distance > 1e-6) answer_.selected.push_back(i);
  }
}

}  // namespace ssjs
