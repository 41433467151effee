#include "ssjs/joining/timed_closure.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "ssjs/base/angle.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/geometry/measurement_noise.hpp"

namespace ssjs {
namespace {

constexpr double kFarthest_m = 1e7;  // of one place from another on the earth
constexpr double kMaxGap_s = 5.0;    // between remembered steps, for a straight line between them

struct TimedPose {
  double time_s;
  GaussianSe2 base_T_vehicle;
};

GaussianSe2 levelled(const LevelledStep& step) {
  const Eigen::Vector3i rows(0, 1, 5);  // x, y, yaw
  return {Se2::from_vector(step.base_T_vehicle(rows)), step.covariance(rows, rows)};
}

/// On the straight line between the two remembered poses around this moment, as sure as the nearer one is.
std::optional<GaussianSe2> pose_at(const LevelledSubmap& map, double time_s) {
  std::vector<TimedPose> way{{map.start_time_s, {}}};
  for (const LevelledStep& step : map.steps) {
    if (step.time_s > way.back().time_s) way.push_back({step.time_s, levelled(step)});
  }
  if (map.end_time_s > way.back().time_s) way.push_back({map.end_time_s, {map.base_T_exit(), map.covariance.topLeftCorner<3, 3>()}});
  const auto after = std::find_if(way.begin(), way.end(), [&](const TimedPose& pose) { return pose.time_s >= time_s; });
  if (after == way.end()) return std::nullopt;
  if (after == way.begin()) return after->base_T_vehicle;
  const TimedPose& a = *(after - 1);
  const TimedPose& b = *after;
  if (b.time_s - a.time_s > kMaxGap_s) return std::nullopt;
  const double part = (time_s - a.time_s) / (b.time_s - a.time_s);
  const Eigen::Vector3d step = additive_difference(b.base_T_vehicle.mean, a.base_T_vehicle.mean);
  return GaussianSe2{additive_step(a.base_T_vehicle.mean, part * step), (part < 0.5 ? a : b).base_T_vehicle.covariance};
}

/// The map in which this moment lies; of two that meet there the later one.
const LevelledSubmap* map_at(const std::deque<PortMap>& maps, double time_s) {
  const auto after =
      std::upper_bound(maps.begin(), maps.end(), time_s, [](double time, const PortMap& map) { return time < map.submap.start_time_s; });
  if (after == maps.begin()) return nullptr;
  const LevelledSubmap& map = (after - 1)->submap;
  return time_s <= map.end_time_s ? &map : nullptr;
}

}  // namespace

void check(const TimedClosure& closure) {
  if (!(closure.to_time_s > closure.from_time_s) || !std::isfinite(closure.from_time_s) || !std::isfinite(closure.to_time_s)) {
    throw InvalidArgument("closure.to_time_s", closure.to_time_s, "must be later than from_time_s");
  }
  const Eigen::Vector3d pose = closure.from_T_to.mean.vector();
  if (!pose.allFinite()) throw InvalidArgument("closure.from_T_to", "not finite", "the pose must be");
  if (const double far_m = pose.head<2>().norm(); far_m > kFarthest_m) {
    throw InvalidArgument("closure.from_T_to", far_m, "must be a pose within 10,000 km");
  }
  if (!is_measurement_noise(closure.from_T_to.covariance)) {
    throw InvalidArgument("closure.from_T_to", "its covariance",
                          "must be symmetric and positive definite, of standard deviations that a sensor may have");
  }
}

std::optional<Closure> between_bases(const TimedClosure& closure, const std::deque<PortMap>& maps) {
  const LevelledSubmap* const from = map_at(maps, closure.from_time_s);
  const LevelledSubmap* const to = map_at(maps, closure.to_time_s);
  if (from == nullptr || to == nullptr || from->index >= to->index) return std::nullopt;
  const std::optional<GaussianSe2> from_T_then = pose_at(*from, closure.from_time_s);
  const std::optional<GaussianSe2> to_T_now = pose_at(*to, closure.to_time_s);
  if (!from_T_then || !to_T_now) return std::nullopt;
  const GaussianSe2 from_T_now = compose_independent(*from_T_then, closure.from_T_to);
  return Closure{from->index, to->index, compose_independent(from_T_now, to_T_now->inverse()), {}, closure.source};  // (C-13)
}

}  // namespace ssjs
