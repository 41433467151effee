/// How often each level occurs among the valid pixels of a picture.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "ssjs/imaging/sonar_image.hpp"

namespace ssjs {

/// counts[i]: pixels of level i, not negative. 256 levels for 8-bit images, 65536 for 16-bit ones.
struct Histogram {
  std::vector<std::int64_t> counts;

  [[nodiscard]] int levels() const { return static_cast<int>(counts.size()); }
  [[nodiscard]] std::int64_t operator[](int level) const { return counts[static_cast<std::size_t>(level)]; }
};

/// One pass over the image; invalid pixels do not count.
[[nodiscard]] Histogram histogram(const SonarImage& image);

/// The lowest and the highest level that occur from `from_level` on; none if there are none.
[[nodiscard]] std::optional<std::pair<int, int>> occupied_levels(const Histogram& histogram, int from_level = 0);

}  // namespace ssjs
