#include "ssjs/io/towed_position.hpp"

#include <cmath>

namespace ssjs {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kEquatorialRadius_m = 6378137.0;
constexpr double kEccentricitySquared = 6.69437999014e-3;

}  // namespace

void apply_layback(SideScanPing& ping, double layback_m) {
  if (!std::isfinite(ping.heading_rad)) return;
  const double east = -layback_m * std::sin(ping.heading_rad);
  const double north = -layback_m * std::cos(ping.heading_rad);
  ping.east_m += east;
  ping.north_m += north;

  // The radii of curvature along the meridian and across it turn metres into angles.
  const double latitude_rad = ping.latitude_deg * kPi / 180.0;
  const double w = 1.0 - kEccentricitySquared * std::sin(latitude_rad) * std::sin(latitude_rad);
  const double across_m = kEquatorialRadius_m / std::sqrt(w);
  const double along_m = across_m * (1.0 - kEccentricitySquared) / w;
  ping.latitude_deg += north / along_m * 180.0 / kPi;
  ping.longitude_deg += east / (across_m * std::cos(latitude_rad)) * 180.0 / kPi;
}

}  // namespace ssjs
