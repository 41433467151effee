/// Two thresholds that split grey levels into three classes: shadow, seabed, highlight. docs/math/regions.md
#pragma once

#include <optional>

#include "ssjs/imaging/histogram.hpp"

namespace ssjs {

/// Classes: up to `lower`, from `lower` + 1 up to `upper`, and above.
struct ThreeClasses {
  int lower = 0;
  int upper = 0;
};

/// The split of at most 256 levels with the largest variance between the classes, none of them empty; of equal splits the one with
/// the lowest thresholds. None if fewer than three levels occur. [otsu1979] section IV
/// A class of few pixels hardly weighs: where targets cover far less than a hundredth of the image, the split is one of the seabed.
[[nodiscard]] std::optional<ThreeClasses> three_class_otsu(const Histogram& histogram);

}  // namespace ssjs
