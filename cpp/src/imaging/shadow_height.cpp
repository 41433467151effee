#include "ssjs/imaging/shadow_height.hpp"

#include <cmath>

#include "ssjs/base/error.hpp"

namespace ssjs {

double ground_range_m(double slant_range_m, double altitude_m) {
  if (!(altitude_m >= 0) || !std::isfinite(altitude_m)) throw InvalidArgument("altitude_m", altitude_m, "must be finite and not negative");
  if (!(slant_range_m >= altitude_m) || !std::isfinite(slant_range_m))
    throw InvalidArgument("slant_range_m", slant_range_m, "must be finite and at least the altitude");
  return std::sqrt((slant_range_m - altitude_m) * (slant_range_m + altitude_m));
}

double height_from_shadow_m(double altitude_m, double shadow_start_m, double shadow_tip_m, ShadowRanges ranges) {
  if (!(altitude_m > 0) || !std::isfinite(altitude_m)) throw InvalidArgument("altitude_m", altitude_m, "must be finite and positive");
  if (!(shadow_start_m >= 0)) throw InvalidArgument("shadow_start_m", shadow_start_m, "must not be negative");
  if (!(shadow_tip_m > 0) || !(shadow_tip_m >= shadow_start_m) || !std::isfinite(shadow_tip_m))
    throw InvalidArgument("shadow_tip_m", shadow_tip_m, "must be finite, positive and not before the start of the shadow");
  double start_m = shadow_start_m;
  double tip_m = shadow_tip_m;
  if (ranges == ShadowRanges::kSlantTop && tip_m < altitude_m)
    throw InvalidArgument("shadow_tip_m", tip_m, "lies on the seabed and must be at least the altitude away");
  if (ranges == ShadowRanges::kSlantFoot) {
    start_m = ground_range_m(start_m, altitude_m);
    tip_m = ground_range_m(tip_m, altitude_m);
    if (tip_m == 0) throw InvalidArgument("shadow_tip_m", shadow_tip_m, "must lie beyond the nadir");
  }
  return altitude_m * (tip_m - start_m) / tip_m;
}

}  // namespace ssjs
