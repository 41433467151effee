#include "ssjs/survey/object_centre.hpp"

#include <algorithm>
#include <cmath>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

constexpr int kBisections = 40;

double square(double x) { return x * x; }

/// Ground range of what echoes at this slant range, so far below the sonar.
double across(double slant_m, double below_m) { return std::sqrt(std::max(0.0, square(slant_m) - square(below_m))); }

/// (SS-34) The upper half of an ellipse of half axes a across and b upwards, under sound that falls by `fall` for a metre across.
struct RoundObject {
  double half_width_m;
  double behind_middle_m;  ///< from its middle to the last point that echoes
  double reach_m;          ///< from its middle towards the sonar, along the sound
};

/// touch_m: height of the last point that echoes.
RoundObject round_object(double half_width_m, double fall, double touch_m) {
  const double lean_square = square(half_width_m * fall);
  const double b_square = 0.5 * (square(touch_m) + touch_m * std::sqrt(square(touch_m) + 4.0 * lean_square));
  const double root = std::sqrt(lean_square + b_square);
  return {half_width_m, root > 0 ? square(half_width_m) * fall / root : 0.0,
          std::sqrt((square(half_width_m) + b_square * square(fall)) / (1.0 + square(fall)))};
}

}  // namespace

ObjectCentre centre_of_object(const ObjectRanges& ranges) {
  if (!(ranges.first_return_m > 0) || !(ranges.behind_m > ranges.first_return_m) || !(ranges.tip_m >= ranges.behind_m))
    throw InvalidArgument("behind_m", ranges.behind_m, "must lie beyond the first return and not beyond the shadow's tip");
  const double h = ranges.first_return_m;
  ObjectCentre centre;
  centre.height_m = h * (1.0 - ranges.behind_m / ranges.tip_m);
  const double behind_m = across(ranges.behind_m, h - centre.height_m);
  const double near_m = std::min(ranges.near_m, ranges.behind_m);

  // (SS-32) a box: the near edge is that of its top
  const double half_box_m = 0.5 * std::max(0.0, behind_m - across(near_m, h - centre.height_m));

  // (SS-34) something round: the wider it is, the farther its middle from the last echo and the nearer its first
  const double fall = (h - centre.height_m) / behind_m;
  double least_m = 0;
  double most_m = std::max(0.0, behind_m - across(near_m, h));
  for (int i = 0; i < kBisections; ++i) {
    const double half_m = 0.5 * (least_m + most_m);
    const RoundObject tried = round_object(half_m, fall, centre.height_m);
    const bool is_too_wide = std::hypot(behind_m - tried.behind_middle_m, h) - tried.reach_m < near_m;
    (is_too_wide ? most_m : least_m) = half_m;
  }
  const RoundObject round = round_object(least_m, fall, centre.height_m);

  // (SS-35)
  centre.ground_range_m = behind_m - 0.5 * (half_box_m + round.behind_middle_m);
  centre.sigma_m = 0.5 * std::abs(half_box_m - round.behind_middle_m);
  centre.width_m = half_box_m + round.half_width_m;
  return centre;
}

}  // namespace ssjs
