#include "ssjs/joining/nearby_maps.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace ssjs {

std::vector<int> nearby_maps(const std::map<int, LiveMap>& maps, const LiveMap& fresh, const NearbyMapsConfig& config,
                             const std::function<Se2(int)>& global_T_base,
                             const std::function<RelativePlacement(const LiveMap&)>& placement) {
  const int submap = fresh.base;
  const Eigen::Vector2d centre = global_T_base(submap) * fresh.centroid;
  std::vector<std::pair<double, int>> nearby;  // gap of the landmark circles, base
  for (const auto& [base, map] : maps) {
    if (map.landmark_count() < config.min_landmarks) continue;
    const bool adjacent =
        std::any_of(map.members.begin(), map.members.end(), [&](int member) { return std::abs(member - submap) <= config.min_gap; });
    if (adjacent) continue;
    const double gap = (global_T_base(base) * map.centroid - centre).norm() - map.radius - fresh.radius;
    // Beyond the ambiguity gate a pairing would be refused anyway: far maps are dismissed without asking for a covariance.
    if (config.max_sigma_m && gap > kReachSigmas * *config.max_sigma_m) continue;
    if (gap <= 0.0 || gap <= kReachSigmas * placement(map).sigma_m) nearby.emplace_back(gap, base);  // (J-6)
  }
  std::sort(nearby.begin(), nearby.end());
  std::vector<int> bases;
  for (const auto& [gap, base] : nearby) bases.push_back(base);
  return bases;
}

}  // namespace ssjs
