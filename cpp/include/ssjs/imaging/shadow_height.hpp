/// The height of an object above a flat seabed from the length of its shadow. docs/math/regions.md to
#pragma once

namespace ssjs {

/// What the two ranges of a shadow are.
enum class ShadowRanges {
  kGround,     ///< on the seabed: from the point below the caster to the tip
  kSlantTop,   ///< of the echo of the caster's top, and of the tip: objects whose far upper edge is the last that echoes
  kSlantFoot,  ///< of the echo of the foot below the caster, and of the tip: walls, posts, whose top echoes before their foot
};

/// altitude_m of the sonar above the seabed. Throws InvalidArgument unless 0 < altitude, start <= tip, and for slant ranges what is
/// measured can be reached at this altitude. A shadow that is cut off gives a lower bound. Seabed that falls away from the sonar by
/// a slope draws shadows out, and the height comes out too large; rising seabed, too small.
[[nodiscard]] double height_from_shadow_m(double altitude_m, double shadow_start_m, double shadow_tip_m, ShadowRanges ranges);

/// The range on a flat seabed of what echoes from it. Throws InvalidArgument unless 0 <= altitude <= slant range.
[[nodiscard]] double ground_range_m(double slant_range_m, double altitude_m);

}  // namespace ssjs
