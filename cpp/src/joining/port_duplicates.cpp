#include "ssjs/joining/port_duplicates.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "ssjs/base/angle.hpp"
#include "ssjs/base/chi_squared.hpp"
#include "ssjs/geometry/gaussian.hpp"
#include "ssjs/geometry/point_grid.hpp"

namespace ssjs {
namespace {

constexpr double kNeighbourhood_m = 25.0;  // radius in which landmarks are counted: a swath

/// A landmark of the survey, each once.
struct Known {
  Sighting sighting;
  Eigen::Vector2d position;
  double sigma_m;
  std::vector<double> seen_s;  ///< by whichever map, ascending
};

void add_times(std::vector<double>& times, const Sighting& sighting) {
  const std::vector<double> more = sighting.map->submap.times_seen_s(sighting.landmark);
  times.insert(times.end(), more.begin(), more.end());
}

std::vector<Known> known_landmarks(const std::deque<PortMap>& maps, const std::vector<int>& among, const PortLevel& level) {
  std::vector<Known> all;
  std::map<int, std::vector<double>> port_times;
  for (const PortMap& map : maps) {
    for (Eigen::Index i = 0; i < map.submap.landmark_count(); ++i) {
      const Sighting sighting{&map, i};
      if (const std::optional<Unknown> port = sighting.port()) add_times(port_times[port->index], sighting);
    }
  }
  std::map<int, bool> listed;
  for (const int k : among) {
    const PortMap& map = maps[static_cast<std::size_t>(k)];
    std::vector<Sighting> sightings;
    for (Eigen::Index i = 0; i < map.submap.landmark_count(); ++i) {
      const Sighting sighting{&map, i};
      const std::optional<Unknown> port = sighting.port();
      if (!port || listed.emplace(port->index, true).second) sightings.push_back(sighting);
    }
    if (sightings.empty()) continue;
    const std::vector<Unknown> unknowns = unknowns_of(sightings);
    const PlacedSightings placed = place_sightings(sightings, unknowns, level.values());
    const Eigen::MatrixXd P = level.covariance(unknowns);
    for (std::size_t i = 0; i < sightings.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(3 * i);
      const Eigen::MatrixXd J = placed.J.middleRows<2>(at);
      const double sigma_m = largest_sigma(J * P * J.transpose() + placed.noise.block<2, 2>(at, at));
      Known known{sightings[i], placed.mean.segment<2>(at), sigma_m, {}};
      if (const std::optional<Unknown> port = sightings[i].port()) {
        known.seen_s = port_times[port->index];
      } else {
        add_times(known.seen_s, sightings[i]);
      }
      std::sort(known.seen_s.begin(), known.seen_s.end());
      all.push_back(std::move(known));
    }
  }
  return all;
}

/// One ping shows an object once. (P-18)
bool seen_together(const Known& a, const Known& b) {
  return std::any_of(a.seen_s.begin(), a.seen_s.end(),
                     [&](double time_s) { return std::binary_search(b.seen_s.begin(), b.seen_s.end(), time_s); });
}

/// Other landmarks around this one that could be it, per square metre; at least one.
double density_around(const Known& centre, const std::vector<Known>& all, const PointGrid& grid, double max_descriptor_distance) {
  const auto around = grid.within(centre.position, kNeighbourhood_m);
  const auto near = std::count_if(around.begin(), around.end(),
                                  [&](Eigen::Index i) {
                                    return may_be_one(centre.sighting, all[static_cast<std::size_t>(i)].sighting, max_descriptor_distance);
                                  }) -
                    1;
  return static_cast<double>(std::max<std::ptrdiff_t>(near, 1)) / (kPi * kNeighbourhood_m * kNeighbourhood_m);
}

/// Those that share no map with a likelier one.
std::vector<Duplicate> apart(const std::vector<Duplicate>& likeliest_first) {
  std::vector<Duplicate> kept;
  std::set<const PortMap*> tied;
  for (const Duplicate& duplicate : likeliest_first) {
    if (tied.count(duplicate.a.map) + tied.count(duplicate.b.map) > 0) continue;
    tied.insert({duplicate.a.map, duplicate.b.map});
    kept.push_back(duplicate);
  }
  return kept;
}

}  // namespace

std::vector<Duplicate> likely_duplicates(const std::deque<PortMap>& maps, const std::vector<int>& among, const PortLevel& level,
                                         const DuplicateConfig& config) {
  const std::vector<Known> all = known_landmarks(maps, among, level);
  const double gate = chi_squared_quantile(config.gate_probability, 2.0);
  const double depth_gate = chi_squared_quantile(config.gate_probability, 1.0);
  const double rarity = (1.0 - config.duplicate_probability) / config.duplicate_probability;
  std::vector<Duplicate> found;
  Eigen::Matrix2Xd positions(2, static_cast<Eigen::Index>(all.size()));
  double largest_sigma_m = 0.0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    positions.col(static_cast<Eigen::Index>(i)) = all[i].position;
    largest_sigma_m = std::max(largest_sigma_m, all[i].sigma_m);
  }
  const PointGrid grid(positions, kNeighbourhood_m);
  for (std::size_t j = 0; j < all.size(); ++j) {
    const double reach_m = std::nextafter(std::sqrt(gate) * (all[j].sigma_m + largest_sigma_m), std::numeric_limits<double>::infinity());
    for (const Eigen::Index near : grid.within(all[j].position, reach_m)) {
      const auto i = static_cast<std::size_t>(near);
      if (i >= j) break;
      const double apart_m = (all[i].position - all[j].position).norm();
      if (apart_m > std::sqrt(gate) * (all[i].sigma_m + all[j].sigma_m) || seen_together(all[i], all[j])) continue;
      if (!may_be_one(all[i].sighting, all[j].sighting, config.max_descriptor_distance)) continue;
      const std::vector<Sighting> pair{all[i].sighting, all[j].sighting};
      const std::vector<Unknown> unknowns = unknowns_of(pair);
      const PlacedSightings placed = place_sightings(pair, unknowns, level.values());
      const Eigen::Vector3d difference = placed.mean.tail<3>() - placed.mean.head<3>();
      const Eigen::MatrixXd J = placed.J.bottomRows<3>() - placed.J.topRows<3>();
      const Eigen::Matrix3d cross = placed.noise.block<3, 3>(0, 3);
      const Eigen::Matrix3d S = J * level.covariance(unknowns) * J.transpose() + placed.noise.block<3, 3>(0, 0) +
                                placed.noise.block<3, 3>(3, 3) - cross - cross.transpose();  // (P-16)
      if (!(difference.z() * difference.z() <= depth_gate * S(2, 2))) continue;
      const Eigen::Matrix2d S_plane = S.topLeftCorner<2, 2>();
      const double squared_distance = difference.head<2>().dot(S_plane.ldlt().solve(difference.head<2>()));
      if (!(squared_distance <= gate)) continue;
      const double density = density_around(all[i], all, grid, config.max_descriptor_distance);
      const double odds = rarity * density * 2.0 * kPi * std::sqrt(S_plane.determinant()) * std::exp(0.5 * squared_distance);  // (P-17)
      if (odds <= config.max_chance_odds) found.push_back({all[i].sighting, all[j].sighting, squared_distance, odds});
    }
  }
  std::stable_sort(found.begin(), found.end(), [](const Duplicate& a, const Duplicate& b) { return a.chance_odds < b.chance_odds; });
  return apart(found);
}

}  // namespace ssjs
