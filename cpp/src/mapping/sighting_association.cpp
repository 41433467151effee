#include "ssjs/mapping/sighting_association.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "ssjs/association/joint_compatibility.hpp"
#include "ssjs/association/nearest_neighbour.hpp"
#include "ssjs/base/chi_squared.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

StateRows rows_of(const SideScanSighting& sighting, Eigen::Index landmark, const LevelledFilter& filter, const SideScanConfig& side_scan) {
  const SideScanRows rows = side_scan_rows(filter.vehicle(), sighting, filter.landmark_position(landmark), side_scan);
  return {rows.vehicle, landmark, rows.H_landmark};
}

/// The same identity twice in one ping: the second is neither paired nor new.
bool named_before(const SideScanSightings& sightings, std::size_t i) {
  return std::any_of(sightings.begin(), sightings.begin() + static_cast<std::ptrdiff_t>(i),
                     [&](const SideScanSighting& earlier) { return earlier.landmark_id == sightings[i].landmark_id; });
}

void by_identity(const SideScanSightings& sightings, const LevelledFilter& filter, const std::vector<MapLandmark>& landmarks,
                 const SideScanConfig& side_scan, SightingAssociation& answer) {
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    if (!sightings[i].landmark_id || named_before(sightings, i)) continue;
    const auto same = [&](const MapLandmark& landmark) { return !landmark.of_camera && landmark.source_id == sightings[i].landmark_id; };
    const auto found = std::find_if(landmarks.begin(), landmarks.end(), same);
    const auto sighting = static_cast<Eigen::Index>(i);
    if (found == landmarks.end()) {
      answer.fresh.push_back(sighting);
      continue;
    }
    const StateRows rows = rows_of(sightings[i], found - landmarks.begin(), filter, side_scan);
    const double gate = chi_squared_quantile(side_scan.gate_probability, static_cast<double>(rows.rows()));
    if (filter.squared_distance(rows) <= gate) answer.pairs.push_back({sighting, found - landmarks.begin()});
  }
}

/// Where a landmark should show: x and across track (or slant range with its side), with their rows.
struct PredictedSighting {
  Eigen::Vector2d point;
  StateRows rows;
};

PredictedSighting predict_sighting(const SideScanSighting& like, Eigen::Index landmark, const LevelledFilter& filter,
                                   const SideScanConfig& side_scan) {
  // a landmark is seen on its own side: the side of the slant range is that of the predicted point
  const double y =
      (map_T_vehicle(filter.vehicle()).rotation().transpose() * (filter.landmark_position(landmark) - position_of(filter.vehicle()))).y();
  SideScanSighting probe = like;
  probe.vehicle_p_point = {0.0, y < 0.0 ? -1.0 : 1.0, 0.0};
  PredictedSighting predicted{{}, rows_of(probe, landmark, filter, side_scan)};
  StateRows& rows = predicted.rows;
  predicted.point = probe.vehicle_p_point.head<2>() - rows.vehicle.residual.head<2>();
  if (side_scan.form == SideScanForm::kFlatBottom && y < 0.0) {  // signed range: turn the row of the range around
    predicted.point.y() = -(1.0 - rows.vehicle.residual(1));
    rows.vehicle.H.row(1) *= -1.0;
    rows.H_landmark.row(1) *= -1.0;
  }
  const Eigen::Index seen = 2;
  rows.vehicle.residual.conservativeResize(seen);
  rows.vehicle.H.conservativeResize(seen, Eigen::NoChange);
  rows.H_landmark.conservativeResize(seen, Eigen::NoChange);
  return predicted;
}

Eigen::Matrix2d noise_of(const SideScanSighting& sighting, const LevelledFilter& filter, const SideScanConfig& side_scan) {
  const double range =
      side_scan.form == SideScanForm::kFlatBottom ? std::abs(sighting.vehicle_p_point.y()) : sighting.vehicle_p_point.norm();
  const Eigen::Matrix3d R = sighting.covariance.value_or(side_scan_covariance(range, velocity_of(filter.vehicle()).norm(), side_scan));
  return R.topLeftCorner<2, 2>();
}

void count_wrong_pairs(const SideScanSightings& sightings, const std::vector<MapLandmark>& landmarks, SightingAssociation& answer) {
  for (const Pair& pair : answer.pairs) {
    const auto& known = landmarks[at(pair.prediction)].source_id;
    const auto& seen = sightings[at(pair.observation)].landmark_id;
    if (known && seen && *known != *seen) ++answer.wrong_pairs;
  }
}

/// What every method comes to for a single point: the nearest landmark, if it passes the gates.
void single(const SideScanSighting& sighting, const LevelledFilter& filter, const std::vector<MapLandmark>& landmarks,
            const SideScanConfig& side_scan, const ScanAssociationConfig& config, SightingAssociation& answer) {
  const Eigen::Matrix2d R = noise_of(sighting, filter, side_scan);
  std::optional<double> nearest;
  Eigen::Index nearest_landmark = 0;
  for (Eigen::Index j = 0; j < filter.landmarks(); ++j) {
    if (landmarks[at(j)].of_camera) continue;
    const PredictedSighting predicted = predict_sighting(sighting, j, filter, side_scan);
    const Eigen::Vector2d r = sighting.vehicle_p_point.head<2>() - predicted.point;
    const Eigen::Matrix2d S = R + filter.predicted_covariance(predicted.rows, predicted.rows);
    const double determinant = S(0, 0) * S(1, 1) - S(0, 1) * S(1, 0);
    if (!(S(0, 0) > 0.0) || !(determinant > 0.0)) {
      throw NotPositiveDefinite("residual covariance", "sighting of landmark " + std::to_string(j) + " of the map");
    }
    const double squared_distance =
        (S(1, 1) * r.x() * r.x() - (S(0, 1) + S(1, 0)) * r.x() * r.y() + S(0, 0) * r.y() * r.y()) / determinant;
    if (nearest && !(squared_distance < *nearest)) continue;
    nearest = squared_distance;
    nearest_landmark = j;
  }
  double gate = chi_squared_quantile(config.gate_probability, 2.0);
  if (config.method != AssociationMethod::kNearestNeighbour) {
    gate = std::min(gate, chi_squared_quantile(config.joint_gate_probability, 2.0));
  }
  if (nearest && *nearest <= gate) {
    answer.pairs.push_back({0, nearest_landmark});
  } else if (!nearest || *nearest > config.new_landmark_squared_distance) {
    answer.fresh.push_back(0);
  }
}

}  // namespace

void associate_sightings(const SideScanSightings& sightings, const LevelledFilter& filter, const std::vector<MapLandmark>& landmarks,
                         const SideScanConfig& side_scan, const ScanAssociationConfig& config, SightingAssociation& answer) {
  answer.pairs.clear();
  answer.fresh.clear();
  answer.wrong_pairs = 0;
  if (sightings.empty()) return;
  if (config.method == AssociationMethod::kKnown) return by_identity(sightings, filter, landmarks, side_scan, answer);
  if (sightings.size() == 1) {
    single(sightings.front(), filter, landmarks, side_scan, config, answer);
    return count_wrong_pairs(sightings, landmarks, answer);
  }
  const auto m = static_cast<Eigen::Index>(sightings.size());
  std::vector<Eigen::Index> of_sonar;
  for (Eigen::Index j = 0; j < filter.landmarks(); ++j) {
    if (!landmarks[at(j)].of_camera) of_sonar.push_back(j);
  }
  const auto n = static_cast<Eigen::Index>(of_sonar.size());
  PairingProblem problem;
  problem.observed.resize(2 * m);
  problem.observed_covariance.setZero(2 * m, 2 * m);
  problem.predicted.resize(2 * n);
  problem.predicted_covariance.resize(2 * n, 2 * n);
  std::vector<StateRows> predictions;
  for (Eigen::Index j = 0; j < n; ++j) {
    const PredictedSighting predicted = predict_sighting(sightings.front(), of_sonar[at(j)], filter, side_scan);
    problem.predicted.segment<2>(2 * j) = predicted.point;
    predictions.push_back(predicted.rows);
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) {
      const Eigen::Matrix2d block = filter.predicted_covariance(predictions[at(i)], predictions[at(j)]);
      problem.predicted_covariance.block<2, 2>(2 * i, 2 * j) = block;
      problem.predicted_covariance.block<2, 2>(2 * j, 2 * i) = block.transpose();
    }
  }
  for (Eigen::Index i = 0; i < m; ++i) {
    problem.observed.segment<2>(2 * i) = sightings[at(i)].vehicle_p_point.head<2>();
    problem.observed_covariance.block<2, 2>(2 * i, 2 * i) = noise_of(sightings[at(i)], filter, side_scan);
  }
  const JointCompatibilityConfig joint{config.gate_probability, config.joint_gate_probability, config.node_budget};
  const Hypothesis hypothesis = config.method == AssociationMethod::kNearestNeighbour ? nearest_neighbour(problem, config.gate_probability)
                                                                                      : joint_compatibility(problem, joint);
  answer.pairs = hypothesis.pairs;
  for (Pair& pair : answer.pairs) pair.prediction = of_sonar[at(pair.prediction)];
  std::vector<bool> paired(sightings.size(), false);
  for (const Pair& pair : answer.pairs) paired[at(pair.observation)] = true;
  count_wrong_pairs(sightings, landmarks, answer);
  for (Eigen::Index i = 0; i < m; ++i) {
    const std::optional<double>& nearest = hypothesis.nearest_squared_distance[at(i)];
    if (!paired[at(i)] && (!nearest || *nearest > config.new_landmark_squared_distance)) answer.fresh.push_back(i);
  }
}

}  // namespace ssjs
