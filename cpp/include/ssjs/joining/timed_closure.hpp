/// A loop closure as a place recogniser states it: between two moments of the mission. docs/math/closures.md (C-13).
#pragma once

#include <deque>
#include <optional>
#include <string>

#include "ssjs/joining/closure.hpp"

namespace ssjs {

/// Where the vehicle was at to_time_s, seen from where it was at from_time_s, both levelled: x ahead m, y starboard m, yaw rad.
struct TimedClosure {
  double from_time_s = 0.0;
  double to_time_s = 0.0;  ///< later
  GaussianSe2 from_T_to{};
  std::string source{};

  void archive(Archive& a) {
    a("from_time_s", from_time_s);
    a("to_time_s", to_time_s);
    a("from_T_to", from_T_to);
    a("source", source);
  }
};

/// Throws InvalidArgument naming what is wrong: times that are not finite or in the wrong order, a pose that is not finite or off the
/// earth, a covariance that is none (measurement_noise.hpp).
void check(const TimedClosure& closure);

/// The same between the bases of the two maps (C-13). Nothing where a moment lies in no map, both lie in one, or no remembered step of the
/// way is near.
[[nodiscard]] std::optional<Closure> between_bases(const TimedClosure& closure, const std::deque<PortMap>& maps);

}  // namespace ssjs
