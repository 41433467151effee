/// Where the middle of an object lies, from the ranges between which it echoes and is dark. docs/math/side_scan.md (SS-18), (SS-32), (SS-34), (SS-35)
#pragma once

namespace ssjs {

/// Slant ranges in the plane of the fan, m, over flat ground whose shortest range is `first_return_m`.
struct ObjectRanges {
  double first_return_m = 0;
  double near_m = 0;    ///< of the first echo
  double behind_m = 0;  ///< of the last echo before the shadow
  double tip_m = 0;     ///< of the end of the shadow
};

struct ObjectCentre {
  double ground_range_m = 0;  ///< of the middle of its foot
  double sigma_m = 0;         ///< of that, by what is not known of its shape
  double height_m = 0;        ///< of the last point that echoes
  double width_m = 0;         ///< across track, of its foot
};

/// Throws InvalidArgument unless first_return < behind <= tip. A near edge that is not before `behind` is taken for it.
[[nodiscard]] ObjectCentre centre_of_object(const ObjectRanges& ranges);

}  // namespace ssjs
