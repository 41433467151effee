#include "ssjs/imaging/histogram.hpp"

#include <array>

namespace ssjs {
namespace {

/// Neighbouring pixels are often equal; counting them in turn in separate tables spares the wait for the last increment.
constexpr int kTables = 4;
constexpr std::size_t kLevels8 = 256, kLevels16 = 65536;

void count_row_8(const unsigned char* row, int columns, std::array<std::array<std::int64_t, kLevels8>, kTables>& tables) {
  int c = 0;
  for (; c + kTables <= columns; c += kTables) {
    for (int t = 0; t < kTables; ++t) ++tables[static_cast<std::size_t>(t)][row[c + t]];
  }
  for (; c < columns; ++c) ++tables[0][row[c]];
}

std::vector<std::int64_t> count_all_8(const cv::Mat& intensity) {
  std::array<std::array<std::int64_t, kLevels8>, kTables> tables{};
  for (int r = 0; r < intensity.rows; ++r) count_row_8(intensity.ptr(r), intensity.cols, tables);
  std::vector<std::int64_t> counts(kLevels8);
  for (std::size_t level = 0; level < kLevels8; ++level) {
    for (const auto& table : tables) counts[level] += table[level];
  }
  return counts;
}

template <class Pixel>
std::vector<std::int64_t> count(const cv::Mat& intensity, const cv::Mat& valid, std::size_t levels) {
  std::vector<std::int64_t> counts(levels);
  for (int r = 0; r < intensity.rows; ++r) {
    const Pixel* row = intensity.ptr<Pixel>(r);
    const unsigned char* row_valid = valid.empty() ? nullptr : valid.ptr(r);
    for (int c = 0; c < intensity.cols; ++c) {
      if (!row_valid || row_valid[c] != 0) ++counts[row[c]];
    }
  }
  return counts;
}

}  // namespace

Histogram histogram(const SonarImage& image) {
  check_sonar_image(image);
  if (image.intensity.depth() == CV_16U) return {count<std::uint16_t>(image.intensity, image.valid, kLevels16)};
  if (image.valid.empty()) return {count_all_8(image.intensity)};
  return {count<std::uint8_t>(image.intensity, image.valid, kLevels8)};
}

std::optional<std::pair<int, int>> occupied_levels(const Histogram& histogram, int from_level) {
  std::optional<std::pair<int, int>> occupied;
  for (int level = from_level; level < histogram.levels(); ++level) {
    if (histogram[level] == 0) continue;
    if (!occupied) occupied = {level, level};
    occupied->second = level;
  }
  return occupied;
}

}  // namespace ssjs
