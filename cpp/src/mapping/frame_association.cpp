#include "ssjs/mapping/frame_association.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "ssjs/association/joint_compatibility.hpp"
#include "ssjs/association/joint_factor.hpp"
#include "ssjs/association/nearest_neighbour.hpp"
#include "ssjs/base/chi_squared.hpp"

namespace ssjs {
namespace {

constexpr double kEdgeSigmas = 3.0;  // a landmark predicted beyond the edge may still show

std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

bool lies_within(const PredictedPixel& predicted, const PinholeCamera& camera) {
  const double u = kEdgeSigmas * std::sqrt(predicted.S(0, 0));
  const double v = kEdgeSigmas * std::sqrt(predicted.S(1, 1));
  return predicted.pixel.x() > -u && predicted.pixel.x() < camera.width_px + u && predicted.pixel.y() > -v &&
         predicted.pixel.y() < camera.height_px + v;
}

template <int L>
PredictedPixel predicted_pixel(Eigen::Index landmark, const PixelPrediction<L>& seen, const LevelledFilter& filter, double variance) {
  PredictedPixel predicted{landmark, seen.pixel, {VehicleRows(2)}, Eigen::Matrix2d::Zero()};
  StateRows& rows = predicted.rows;
  rows.vehicle.residual.setZero();
  rows.vehicle.H = seen.H_vehicle;
  rows.vehicle.R = variance * Eigen::Matrix2d::Identity();
  rows.landmark = landmark;
  rows.H_landmark = seen.H_landmark.template leftCols<3>();
  if constexpr (L == 6) rows.H_ray = seen.H_landmark.template rightCols<3>();
  predicted.S = filter.predicted_covariance(rows, rows) + rows.vehicle.R;
  return predicted;
}

/// Every landmark of the camera that the frame may show. (I-11)
std::vector<PredictedPixel> predict_frame(const LevelledFilter& filter, const std::vector<MapLandmark>& landmarks,
                                          const PinholeCamera& camera, const CameraConfig& config) {
  std::vector<PredictedPixel> found;
  const VehicleVector x = filter.vehicle();
  const double variance = config.sigma_px * config.sigma_px;
  for (Eigen::Index i = 0; i < filter.landmarks(); ++i) {
    if (!landmarks[at(i)].of_camera) continue;
    std::optional<PredictedPixel> predicted;
    if (filter.is_ray(i)) {
      if (const auto seen = predict_pixel(x, filter.ray(i), camera, config)) predicted = predicted_pixel(i, *seen, filter, variance);
    } else if (const auto seen = predict_pixel(x, filter.landmark_position(i), camera, config)) {
      predicted = predicted_pixel(i, *seen, filter, variance);
    }
    if (predicted && lies_within(*predicted, camera)) found.push_back(std::move(*predicted));
  }
  return found;
}

/// Candidates of one sighting: inside the gate, and alike. Where the looks tell them apart clearly, the most alike alone. (I-12)
void narrow_by_looks(std::vector<Eigen::Index>& candidates, const CameraSighting& sighting, const std::vector<PredictedPixel>& predicted,
                     const std::vector<MapLandmark>& landmarks, const FrameAssociationConfig& config) {
  const auto unlikeness = [&](Eigen::Index j) {
    return descriptor_distance(sighting.descriptor, landmarks[at(predicted[at(j)].landmark)].descriptor);
  };
  const auto is_unlike = [&](Eigen::Index j) { return unlikeness(j).value_or(0.0) > config.max_descriptor_distance; };
  candidates.erase(std::remove_if(candidates.begin(), candidates.end(), is_unlike), candidates.end());
  if (candidates.size() < 2) return;
  double best = std::numeric_limits<double>::infinity(), next = best;
  Eigen::Index likest = candidates.front();
  for (const Eigen::Index j : candidates) {
    const std::optional<double> distance = unlikeness(j);
    if (!distance) return;  // one of them is not known by its looks
    if (*distance < best) {
      next = std::exchange(best, *distance);
      likest = j;
    } else {
      next = std::min(next, *distance);
    }
  }
  if (best <= config.descriptor_ratio * next) candidates = {likest};
}

PairingProblem pose_problem(const CameraFrame& frame, const std::vector<PredictedPixel>& predicted, const LevelledFilter& filter,
                            double variance) {
  const auto m = static_cast<Eigen::Index>(frame.sightings.size());
  const auto n = static_cast<Eigen::Index>(predicted.size());
  PairingProblem problem;
  problem.observed.resize(2 * m);
  problem.observed_covariance = variance * Eigen::MatrixXd::Identity(2 * m, 2 * m);
  for (Eigen::Index i = 0; i < m; ++i) problem.observed.segment<2>(2 * i) = frame.sightings[at(i)].pixel;
  problem.predicted.resize(2 * n);
  std::vector<StateRows> rows;
  rows.reserve(predicted.size());
  for (Eigen::Index j = 0; j < n; ++j) {
    problem.predicted.segment<2>(2 * j) = predicted[at(j)].pixel;
    rows.push_back(predicted[at(j)].rows);
  }
  problem.predicted_covariance = filter.joint_covariance(rows);
  return problem;
}

/// Pairs by identity, where the gate lets them through.
std::vector<Pair> by_identity(const CameraFrame& frame, const std::vector<MapLandmark>& landmarks, const Compatibility& compatibility,
                              double gate, FrameAssociation& answer) {
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < frame.sightings.size(); ++i) {
    const std::optional<std::int64_t>& id = frame.sightings[i].landmark_id;
    if (!id) continue;
    for (std::size_t j = 0; j < answer.predicted.size(); ++j) {
      if (landmarks[at(answer.predicted[j].landmark)].source_id != id) continue;
      const Pair pair{static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)};
      if (compatibility.squared_distance(pair.observation, pair.prediction) <= gate) {
        pairs.push_back(pair);
      } else {
        ++answer.refused;
      }
      break;
    }
  }
  return pairs;
}

/// The nearest first, one to one.
std::vector<Pair> greedy(const Compatibility& compatibility) {
  std::vector<Pair> all, pairs;
  for (std::size_t i = 0; i < compatibility.candidates.size(); ++i) {
    for (const Eigen::Index j : compatibility.candidates[i]) all.push_back({static_cast<Eigen::Index>(i), j});
  }
  const auto distance = [&](const Pair& pair) { return compatibility.squared_distance(pair.observation, pair.prediction); };
  std::stable_sort(all.begin(), all.end(), [&](const Pair& a, const Pair& b) { return distance(a) < distance(b); });
  for (const Pair& pair : all) {
    const auto meets = [&](const Pair& p) { return p.observation == pair.observation || p.prediction == pair.prediction; };
    if (std::none_of(pairs.begin(), pairs.end(), meets)) pairs.push_back(pair);
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

/// Sightings far from every landmark, and from each other. (I-13)
std::vector<Eigen::Index> fresh_sightings(const CameraFrame& frame, const std::vector<bool>& taken, const Compatibility& compatibility,
                                          const std::vector<PredictedPixel>& predicted, const FrameAssociationConfig& config,
                                          double dead_band) {
  std::vector<Eigen::Index> fresh;
  const auto full = [&] {
    return static_cast<int>(fresh.size()) >= config.new_per_frame ||
           static_cast<int>(predicted.size() + fresh.size()) >= config.landmarks_in_view;
  };
  const auto lies_near = [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return (a - b).norm() < config.spacing_px; };
  for (std::size_t i = 0; i < frame.sightings.size() && !full(); ++i) {
    const auto sighting = static_cast<Eigen::Index>(i);
    const Eigen::Vector2d& pixel = frame.sightings[i].pixel;
    if (taken[i] || (!predicted.empty() && compatibility.squared_distance.row(sighting).minCoeff() <= dead_band)) continue;
    const auto by_landmark = [&](const PredictedPixel& other) { return lies_near(pixel, other.pixel); };
    const auto by_fresh = [&](Eigen::Index other) { return lies_near(pixel, frame.sightings[at(other)].pixel); };
    if (std::any_of(predicted.begin(), predicted.end(), by_landmark) || std::any_of(fresh.begin(), fresh.end(), by_fresh)) continue;
    fresh.push_back(sighting);
  }
  return fresh;
}

}  // namespace

FrameAssociation associate_frame(const CameraFrame& frame, const LevelledFilter& filter, const std::vector<MapLandmark>& landmarks,
                                 const PinholeCamera& camera, const CameraConfig& of_camera, const FrameAssociationConfig& config,
                                 const ScanAssociationConfig& method) {
  FrameAssociation answer;
  answer.predicted = predict_frame(filter, landmarks, camera, of_camera);
  const std::size_t m = frame.sightings.size();
  const double gate = chi_squared_quantile(of_camera.gate_probability, 2.0);
  const bool is_known = method.method == AssociationMethod::kKnown;
  Compatibility compatibility;
  std::vector<bool> taken(m, false);  // neither paired nor new
  if (m > 0 && !answer.predicted.empty()) {
    const PairingProblem problem = pose_problem(frame, answer.predicted, filter, of_camera.sigma_px * of_camera.sigma_px);
    compatibility = individual_compatibility(problem, gate);
    if (is_known) {
      answer.pairs = by_identity(frame, landmarks, compatibility, gate, answer);
    } else {
      std::vector<Eigen::Index> observations;
      for (std::size_t i = 0; i < m; ++i) {
        narrow_by_looks(compatibility.candidates[i], frame.sightings[i], answer.predicted, landmarks, config);
        if (!compatibility.candidates[i].empty()) observations.push_back(static_cast<Eigen::Index>(i));
      }
      if (method.method == AssociationMethod::kNearestNeighbour) {
        answer.pairs = greedy(compatibility);
      } else {
        const JointCompatibilityConfig joint{of_camera.gate_probability, method.joint_gate_probability, method.node_budget};
        Hypothesis hypothesis = joint_compatibility(problem, compatibility, observations, joint);
        answer.pairs = std::move(hypothesis.pairs);
        answer.budget_exhausted = hypothesis.budget_exhausted;
      }
      answer.refused += static_cast<int>(observations.size() - answer.pairs.size());
    }
    // the frame as a whole, whatever chose its pairs
    const auto frame_gate = [&] {
      return chi_squared_quantile(of_camera.gate_probability, 2.0 * static_cast<double>(answer.pairs.size()));
    };
    if (!answer.pairs.empty() && !(joint_squared_distance(problem, answer.pairs) <= frame_gate())) {
      for (const Pair& pair : answer.pairs) taken[at(pair.observation)] = true;
      answer.refused += static_cast<int>(answer.pairs.size());
      answer.pairs.clear();
    }
  }
  for (const Pair& pair : answer.pairs) {
    taken[at(pair.observation)] = true;
    const auto& known = landmarks[at(answer.predicted[at(pair.prediction)].landmark)].source_id;
    const auto& seen = frame.sightings[at(pair.observation)].landmark_id;
    if (known && seen && *known != *seen) ++answer.wrong_pairs;
  }
  if (is_known) {
    for (std::size_t i = 0; i < m; ++i) {
      const auto& id = frame.sightings[i].landmark_id;
      const auto same = [&](const MapLandmark& landmark) { return landmark.source_id == id; };
      if (!id || std::any_of(landmarks.begin(), landmarks.end(), same)) taken[i] = true;
    }
  }
  answer.fresh =
      fresh_sightings(frame, taken, compatibility, answer.predicted, config, is_known ? 0.0 : method.new_landmark_squared_distance);
  return answer;
}

}  // namespace ssjs
