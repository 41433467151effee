/// The first bottom return: the altitude where a log has none. docs/math/side_scan.md (SS-14) to (SS-16)
#pragma once

#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/sensors/side_scan_ping.hpp"

namespace ssjs {

struct BottomTrackingConfig {
  int channel_pair = 0;
  double least_altitude_m = 0.75;
  double most_altitude_m = 0.0;
  double bin_m = 0.05;
  double window_m = 0.5;
  double step_cost = 0.05;
  double most_step_m = 0.5;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("channel_pair", channel_pair, Rule::at_least(0), "which port and starboard channels");
    v.field("least_altitude_m", least_altitude_m, Rule::not_negative(), "what is nearer is the transmitted pulse and the vehicle itself");
    v.field("most_altitude_m", most_altitude_m, Rule::not_negative(), "what is farther is not the bottom; 0: three quarters of the range");
    v.field("bin_m", bin_m, Rule::positive(), "resolution of the altitude");
    v.field("window_m", window_m, Rule::positive(), "range behind the bottom whose echoes must be strong");
    v.field("step_cost", step_cost, Rule::not_negative(), "price of a change by one bin from ping to ping, in nepers of echo strength");
    v.field("most_step_m", most_step_m, Rule::positive(), "largest change from ping to ping");
  }
};

/// The slant range of the first bottom return, one a ping (altitude_of_first_return_m makes it the altitude): the path through all pings
/// that separates silence from echo best (Viterbi). Both sides are averaged, since the nadir belongs to both. A ping without samples takes
/// part with no say. Throws InvalidArgument where no ping has any.
[[nodiscard]] std::vector<double> track_bottom(const std::vector<SideScanPing>& pings, const BottomTrackingConfig& config);

}  // namespace ssjs
