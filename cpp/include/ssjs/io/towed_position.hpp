/// Where a towed sonar is, from the position of what tows it.
#pragma once

#include "ssjs/sensors/side_scan_ping.hpp"

namespace ssjs {

/// Moves the position of a ping, geographic or projected, back along its heading by the layback (m, over ground):
/// fish = position - layback (sin heading, cos heading) in (east, north), on the WGS84 ellipsoid. Nothing changes without a heading.
void apply_layback(SideScanPing& ping, double layback_m);

}  // namespace ssjs
