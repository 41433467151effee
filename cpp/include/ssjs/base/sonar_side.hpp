/// The two sides of a side-scan sonar.
#pragma once

namespace ssjs {

enum class SonarSide { kPort, kStarboard };

/// y of the body frame (x forward, y starboard, z down) grows to starboard: the sign of y on that side.
[[nodiscard]] constexpr double starboard_sign(SonarSide side) { return side == SonarSide::kStarboard ? 1.0 : -1.0; }

}  // namespace ssjs
