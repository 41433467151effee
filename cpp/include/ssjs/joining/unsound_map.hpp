/// A levelled map whose covariance is none: what is left of it when nothing it says can be believed. docs/math/ports.md (P-40)
#pragma once

#include "ssjs/mapping/levelled_submap.hpp"

namespace ssjs {

/// Whether mean and covariance are finite and the covariance is positive definite.
[[nodiscard]] bool is_sound(const LevelledSubmap& submap);

/// A map of the same number, times and kind of compass that knows nothing: the vehicle went somewhere, no faster than
/// kFastestVehicle_m_s, and faces anywhere. Without landmarks; its steps stay where they were, as unsure as its exit. The survey goes on
/// behind it and is tied to what was before by the landmarks that are met again.
[[nodiscard]] LevelledSubmap without_knowledge(const LevelledSubmap& submap);

inline constexpr double kFastestVehicle_m_s = 3.0;

}  // namespace ssjs
