#include "ssjs/joining/season.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "ssjs/base/error.hpp"
#include "ssjs/geometry/gaussian.hpp"
#include "ssjs/joining/port_estimate.hpp"

namespace ssjs {
namespace {

constexpr double kReachSigmas = 3.0;

Eigen::Index count_of(const MissionMap& mission) { return mission.mean.size() / 3; }

void check(const MissionMap& mission, std::size_t number) {
  const std::string name = "mission " + std::to_string(number);
  const Eigen::Index n = mission.mean.size();
  if (n % 3 != 0 || mission.covariance.rows() != n || mission.covariance.cols() != n) {
    throw InvalidArgument(name,
                          std::to_string(n) + " entries, covariance " + std::to_string(mission.covariance.rows()) + " x " +
                              std::to_string(mission.covariance.cols()),
                          "3 entries a landmark, and their joint covariance");
  }
  if (!mission.mean.allFinite() || !mission.covariance.allFinite() || !mission.world_T_mission.covariance.allFinite()) {
    throw InvalidArgument(name, "not finite", "mean and covariances must be");
  }
}

/// Where the landmarks of a mission may be by its origin alone, as a box along the axes of the world. (W-2)
struct Box {
  Eigen::Array2d low = Eigen::Array2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Array2d high = -Eigen::Array2d::Constant(std::numeric_limits<double>::infinity());
};

Box box_of(const MissionMap& mission) {
  Box box;
  const Se2& X = mission.world_T_mission.mean;
  const Eigen::Matrix2d R = X.rotation();
  for (Eigen::Index i = 0; i < count_of(mission); ++i) {
    const Eigen::Vector2d p = mission.mean.segment<2>(3 * i);
    const Eigen::Matrix<double, 2, 3> J = act_jacobian(X, p);
    const Eigen::Matrix2d P =
        J * mission.world_T_mission.covariance * J.transpose() + R * mission.covariance.block<2, 2>(3 * i, 3 * i) * R.transpose();
    const Eigen::Array2d world_p = (X * p).array();
    const Eigen::Array2d reach = kReachSigmas * P.diagonal().array().sqrt();
    box.low = box.low.min(world_p - reach);
    box.high = box.high.max(world_p + reach);
  }
  return box;
}

/// Numbers of the sites, counted in the order of their first missions: boxes that overlap, directly or by others, are one site.
std::vector<int> sites_of(const std::vector<MissionMap>& missions) {
  std::vector<Box> boxes;
  for (const MissionMap& mission : missions) boxes.push_back(box_of(mission));
  std::vector<std::size_t> root(missions.size());
  std::iota(root.begin(), root.end(), std::size_t{0});
  const auto root_of = [&root](std::size_t i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  std::vector<std::size_t> from_west = root;  // a sweep: only boxes that are still open are compared
  std::sort(from_west.begin(), from_west.end(), [&](std::size_t a, std::size_t b) {
    return boxes[a].low.x() != boxes[b].low.x() ? boxes[a].low.x() < boxes[b].low.x() : a < b;
  });
  std::vector<std::size_t> open;
  for (const std::size_t next : from_west) {
    if (count_of(missions[next]) == 0) continue;
    const auto ended = [&](std::size_t i) { return boxes[i].high.x() < boxes[next].low.x(); };
    open.erase(std::remove_if(open.begin(), open.end(), ended), open.end());
    for (const std::size_t other : open) {
      if (boxes[other].low.y() > boxes[next].high.y() || boxes[other].high.y() < boxes[next].low.y()) continue;
      const std::size_t a = root_of(other);
      const std::size_t b = root_of(next);
      root[std::max(a, b)] = std::min(a, b);
    }
    open.push_back(next);
  }
  std::vector<int> sites(missions.size());
  std::map<std::size_t, int> numbers;
  for (std::size_t i = 0; i < missions.size(); ++i) {
    sites[i] = numbers.emplace(root_of(i), static_cast<int>(numbers.size())).first->second;
  }
  return sites;
}

LevelledSubmap map_of(const MissionMap& mission, int index) {
  LevelledSubmap submap;
  submap.index = index;
  const Eigen::Index n = mission.mean.size();
  submap.mean = Eigen::VectorXd::Zero(3 + n);  // of no use here: where the mission ended
  submap.mean.tail(n) = mission.mean;
  submap.covariance = Eigen::MatrixXd::Identity(3 + n, 3 + n);
  submap.covariance.bottomRightCorner(n, n) = mission.covariance;
  submap.landmarks.resize(static_cast<std::size_t>(count_of(mission)));
  // A mission has told its own landmarks apart: as those that one ping showed they are different objects. (W-4)
  submap.seen_s.assign(submap.landmarks.size(), {static_cast<double>(index)});
  return submap;
}

PortJoinerConfig joiner_config(const SeasonConfig& config) {
  PortJoinerConfig joiner;
  joiner.gate_probability = config.gate_probability;
  joiner.joint_gate_probability = config.joint_gate_probability;
  joiner.node_budget = config.node_budget;
  joiner.max_chance_odds = config.max_chance_odds;
  joiner.max_chance_alignments = config.max_chance_alignments;
  joiner.duplicate_probability = config.duplicate_probability;
  return joiner;
}

/// What a site ended with, `members` being the places of its missions.
void put_site(SeasonEstimate& season, const std::vector<std::size_t>& members, const PortJoiner& joiner) {
  const PortLevel& level = joiner.level();
  for (std::size_t i = 0; i < members.size(); ++i) {
    const int base = static_cast<int>(i) + 1;
    season.world_T_mission[members[i]] = {level.values().base(base), level.covariance({{UnknownKind::kBase, base}})};
  }
  const std::vector<SurveyLandmark> landmarks = landmarks_in_world(joiner.maps(), level);
  std::map<int, std::vector<MissionLandmark>> shared;  // by unknown, the order in which they are listed
  std::vector<std::vector<MissionLandmark>> sightings;
  for (const PortMap& map : joiner.maps()) {
    for (Eigen::Index i = 0; i < map.submap.landmark_count(); ++i) {
      const MissionLandmark sighting{members[static_cast<std::size_t>(map.base()) - 1], static_cast<std::size_t>(i)};
      if (const std::optional<Unknown> port = Sighting{&map, i}.port()) {
        shared[port->index].push_back(sighting);
      } else {
        sightings.push_back({sighting});
      }
    }
  }
  std::vector<std::vector<MissionLandmark>> all;
  for (auto& [index, seen] : shared) all.push_back(std::move(seen));
  all.insert(all.end(), sightings.begin(), sightings.end());
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    season.contacts.push_back({landmarks[i].position, landmarks[i].covariance, std::move(all[i])});
  }
}

}  // namespace

SeasonEstimate join_missions(const std::vector<MissionMap>& missions, const SeasonConfig& config, const ProgressSink& progress) {
  throw_if_any(violations(config));
  for (std::size_t i = 0; i < missions.size(); ++i) check(missions[i], i);
  SeasonEstimate season;
  season.world_T_mission.resize(missions.size());
  season.sites = sites_of(missions);
  std::vector<std::vector<std::size_t>> members;
  for (std::size_t i = 0; i < missions.size(); ++i) {
    const auto site = static_cast<std::size_t>(season.sites[i]);
    if (site == members.size()) members.emplace_back();
    members[site].push_back(i);
  }
  std::size_t joined = 0;
  for (const std::vector<std::size_t>& site : members) {
    PortJoiner joiner(joiner_config(config));
    std::vector<GaussianSe2> frames;
    for (const std::size_t i : site) frames.push_back(missions[i].world_T_mission);
    joiner.stand_on(frames);  // (W-1)
    for (std::size_t k = 0; k < site.size(); ++k) {
      if (progress && !progress(static_cast<double>(joined++) / static_cast<double>(missions.size()))) throw Cancelled();
      season.budget_exhausted += joiner.take(map_of(missions[site[k]], static_cast<int>(k) + 1)).budget_exhausted ? 1 : 0;  // (W-3)
    }
    joiner.finish();
    put_site(season, site, joiner);
  }
  const auto by_first = [](const SeasonContact& a, const SeasonContact& b) {
    const MissionLandmark& first = a.sightings.front();
    const MissionLandmark& second = b.sightings.front();
    return first.mission != second.mission ? first.mission < second.mission : first.landmark < second.landmark;
  };
  std::sort(season.contacts.begin(), season.contacts.end(), by_first);
  return season;
}

}  // namespace ssjs
