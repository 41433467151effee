#include "ssjs/joining/port_estimate.hpp"

#include <algorithm>
#include <map>
#include <string>

#include "ssjs/base/angle.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/joining/port_association.hpp"

namespace ssjs {
namespace {

/// The base of a map and the first entries of its state together, as the survey knows them.
struct CorrectedState {
  Eigen::VectorXd shift;       ///< of the entries, against what the map says
  Eigen::MatrixXd covariance;  ///< of (base, entries), 3 + n
};

CorrectedState correct(const PortMap& map, Eigen::Index entries, const PortKnowledge& level) {
  const Eigen::VectorXi rows = Eigen::VectorXi::LinSpaced(entries, 0, static_cast<int>(entries) - 1);
  const ConditionalPlacement m = place_rows(map, rows, level.values());
  CorrectedState state{m.mean - map.submap.mean.head(entries), {}};
  for (Eigen::Index i = 2; i < std::min(entries, 3 + map.submap.compass_rows()); ++i) state.shift(i) = wrap_angle(state.shift(i));
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(3 + entries, m.J.cols());
  J.topLeftCorner<3, 3>().setIdentity();  // the base is the first of the unknowns
  J.bottomRows(entries) = m.J;
  state.covariance = J * level.covariance(m.unknowns) * J.transpose();
  state.covariance.bottomRightCorner(entries, entries) += m.noise;
  return state;
}

}  // namespace

std::vector<SurveyLandmark> landmarks_in_world(const std::deque<PortMap>& maps, const PortLevel& level) {
  std::vector<SurveyLandmark> shared(level.values().landmarks.size());
  std::vector<SurveyLandmark> single;
  for (const PortMap& map : maps) {
    std::vector<Sighting> alone;
    for (Eigen::Index i = 0; i < map.submap.landmark_count(); ++i) {
      const Sighting sighting{&map, i};
      const MapLandmark& landmark = map.submap.landmarks[static_cast<std::size_t>(i)];
      const std::optional<Unknown> port = sighting.port();
      if (!port) {
        alone.push_back(sighting);
        continue;
      }
      SurveyLandmark& known = shared[static_cast<std::size_t>(port->index)];
      if (known.maps.empty()) {
        known.position = level.values().landmark(port->index);
        known.covariance = level.covariance({*port});
        known.landmark = landmark;
      } else {
        known.landmark.take(landmark);
      }
      const std::vector<double> seen_s = map.submap.times_seen_s(i);
      known.seen_s.insert(known.seen_s.end(), seen_s.begin(), seen_s.end());
      if (known.maps.empty() || known.maps.back() != map.base()) known.maps.push_back(map.base());
    }
    if (alone.empty()) continue;
    const std::vector<Unknown> unknowns = unknowns_of(alone);
    const PlacedSightings placed = place_sightings(alone, unknowns, level.values());
    const Eigen::MatrixXd P = placed.J * level.covariance(unknowns) * placed.J.transpose() + placed.noise;  // (P-13)
    for (std::size_t i = 0; i < alone.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(3 * i);
      single.push_back({placed.mean.segment<3>(at),
                        P.block<3, 3>(at, at),
                        map.submap.landmarks[static_cast<std::size_t>(alone[i].landmark)],
                        {map.base()},
                        map.submap.times_seen_s(alone[i].landmark)});
    }
  }
  for (SurveyLandmark& landmark : shared) std::sort(landmark.seen_s.begin(), landmark.seen_s.end());
  const auto is_merged = [](const SurveyLandmark& landmark) { return landmark.maps.empty(); };  // into another
  shared.erase(std::remove_if(shared.begin(), shared.end(), is_merged), shared.end());
  shared.insert(shared.end(), single.begin(), single.end());
  return shared;
}

Eigen::MatrixXd joint_landmark_covariance(const std::deque<PortMap>& maps, const PortLevel& level) {
  std::map<int, Sighting> shared;
  std::vector<Sighting> single;
  for (const PortMap& map : maps) {
    for (Eigen::Index i = 0; i < map.submap.landmark_count(); ++i) {
      const Sighting sighting{&map, i};
      if (const std::optional<Unknown> port = sighting.port()) {
        shared.try_emplace(port->index, sighting);
      } else {
        single.push_back(sighting);
      }
    }
  }
  std::vector<Sighting> all;
  for (const auto& [index, sighting] : shared) all.push_back(sighting);
  all.insert(all.end(), single.begin(), single.end());
  if (all.empty()) return {};
  const std::vector<Unknown> unknowns = unknowns_of(all);
  const PlacedSightings placed = place_sightings(all, unknowns, level.values());
  const Eigen::MatrixXd P = placed.J * level.covariance(unknowns) * placed.J.transpose() + placed.noise;
  return 0.5 * (P + P.transpose());
}

std::vector<SurveyStep> steps_in_world(const PortMap& map, const PortKnowledge& level) {
  std::map<Eigen::Index, CorrectedState> states;  // by how many entries a step follows: the same for nearly all
  const Se2& global_T_base = level.values().base(map.base());
  const Eigen::Matrix2d R = global_T_base.rotation();
  std::vector<SurveyStep> steps;
  for (const LevelledStep& local : map.submap.steps) {
    const Eigen::Index entries = local.gain.cols();
    if (entries < 3 || entries > map.submap.mean.size()) {
      throw InvalidArgument(
          "step.gain", std::to_string(entries) + " columns",
          "map " + std::to_string(map.base()) + ": 3 to the size of its state, " + std::to_string(map.submap.mean.size()));
    }
    auto found = states.find(entries);
    if (found == states.end()) found = states.emplace(entries, correct(map, entries, level)).first;
    const CorrectedState& state = found->second;

    Eigen::Matrix<double, 6, 1> pose = local.base_T_vehicle + local.gain * state.shift;  // (P-14)
    Eigen::Matrix<double, 6, Eigen::Dynamic> J = Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, 3 + entries);
    J.rightCols(entries) = local.gain;
    J.topRightCorner(2, entries) = R * local.gain.topRows<2>();  // (P-15)
    J.block<2, 3>(0, 0) = act_jacobian(global_T_base, pose.head<2>());
    J(5, 2) = 1.0;
    Matrix6d turn = Matrix6d::Identity();
    turn.topLeftCorner<2, 2>() = R;
    SurveyStep step;
    step.time_s = local.time_s;
    step.global_T_vehicle = pose;
    step.global_T_vehicle.head<2>() = global_T_base * Eigen::Vector2d(pose.head<2>());
    for (Eigen::Index angle = 3; angle < 5; ++angle) step.global_T_vehicle(angle) = wrap_angle(pose(angle));
    step.global_T_vehicle(5) = wrap_angle(pose(5) + global_T_base.heading);
    step.covariance = J * state.covariance * J.transpose() + turn * local.conditional_covariance * turn.transpose();
    step.covariance = (0.5 * (step.covariance + step.covariance.transpose())).eval();
    steps.push_back(step);
  }
  return steps;
}

}  // namespace ssjs
