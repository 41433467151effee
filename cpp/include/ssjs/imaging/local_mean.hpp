/// Sums over a square window around every pixel, row by row.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "ssjs/imaging/sonar_image.hpp"

namespace ssjs {

/// One row: for each pixel the sum of the levels of the valid pixels in its window, and how many they are.
struct LocalSums {
  std::vector<std::int64_t> sum;
  std::vector<std::int64_t> count;
};

/// Calls `use(row, sums)` for every row from the first on. The window is cut off at the borders of the image. Exact, in time
/// independent of the window; holds a few rows, whatever the size of the image. window_px: odd.
void for_each_row_of_local_sums(const SonarImage& image, int window_px, const std::function<void(int row, const LocalSums&)>& use);

}  // namespace ssjs
