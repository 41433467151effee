#include "ssjs/imaging/mask_components.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <string>

#include "ssjs/base/error.hpp"
#include "ssjs/imaging/disjoint_sets.hpp"

namespace ssjs {
namespace {

constexpr int kWord = 64;

/// Bit i tells whether pixel i of eight is set.
std::uint64_t eight_bits(const unsigned char* pixels) {
  std::uint64_t eight = 0;
  for (int i = 0; i < 8; ++i) eight |= static_cast<std::uint64_t>(pixels[i]) << (8 * i);
  constexpr std::uint64_t kLow7 = 0x7f7f7f7f7f7f7f7fU, kOnes = 0x0101010101010101U, kGather = 0x0102040810204080U;
  const std::uint64_t set = ((((eight & kLow7) + kLow7) | eight) >> 7) & kOnes;  // one where the byte is not zero
  return (set * kGather) >> 56;
}

bool all_clear(const unsigned char* pixels, int count) {
  if (count < kWord) return false;  // seldom: not worth a second loop
  std::array<std::uint64_t, kWord / 8> words{};
  std::memcpy(words.data(), pixels, kWord);
  std::uint64_t any = 0;
  for (const std::uint64_t word : words) any |= word;
  return any == 0;
}

/// Bit i tells whether pixel i of at most 64 is set.
std::uint64_t word_of(const unsigned char* pixels, int count) {
  std::uint64_t word = 0;
  int i = 0;
  for (; i + 8 <= count; i += 8) word |= eight_bits(pixels + i) << i;
  for (; i < count; ++i) word |= static_cast<std::uint64_t>(pixels[i] != 0 ? 1 : 0) << i;
  return word;
}

/// The columns where set and clear pixels meet, as if what lies left of the row were clear; ends with the number of columns if the
/// last pixel is set. A change is found by its bit, so that noise costs no mispredicted branch a pixel.
void changes_along(const unsigned char* row, int columns, std::vector<int>& changes) {
  changes.clear();
  std::uint64_t before = 0;  // the last pixel of the word before
  for (int first = 0; first < columns; first += kWord) {
    const int count = std::min(kWord, columns - first);
    if (before == 0 && all_clear(row + first, count)) continue;
    const std::uint64_t word = word_of(row + first, count);
    std::uint64_t changed = word ^ ((word << 1) | before);
    before = word >> (kWord - 1);
    if (count < kWord) changed &= (std::uint64_t{1} << count) - 1;
    for (; changed != 0; changed &= changed - 1) changes.push_back(first + __builtin_ctzll(changed));
  }
  if (changes.size() % 2 == 1) changes.push_back(columns);
}

/// The first columns and ends of the runs of set pixels, or those of clear ones.
void run_bounds(const unsigned char* row, int columns, bool of_set_pixels, std::vector<int>& bounds) {
  changes_along(row, columns, bounds);
  if (of_set_pixels) return;
  if (!bounds.empty() && bounds.front() == 0) {
    bounds.erase(bounds.begin());
  } else {
    bounds.insert(bounds.begin(), 0);
  }
  if (!bounds.empty() && bounds.back() == columns) {
    bounds.pop_back();
  } else {
    bounds.push_back(columns);
  }
}

/// Runs of rows one above the other touch when they share a column (reach 0), or when they do after one of them has been
/// drawn out by a pixel at both ends (reach 1).
MaskComponents components(const cv::Mat& mask, bool of_set_pixels, int reach) {
  check_mask(mask, "mask");
  MaskComponents found;
  std::vector<MaskRun>& runs = found.runs;
  DisjointSets sets;
  std::vector<int> bounds;
  std::size_t above = 0;  // the first run of the row above that can touch this or a later run
  for (int row = 0; row < mask.rows; ++row) {
    const unsigned char* pixels = mask.ptr<unsigned char>(row);
    const std::size_t row_begin = runs.size();
    run_bounds(pixels, mask.cols, of_set_pixels, bounds);
    for (std::size_t i = 0; i < bounds.size(); i += 2) {
      if (runs.size() >= static_cast<std::size_t>(std::numeric_limits<int>::max()))
        throw InvalidArgument("mask", std::to_string(mask.cols) + " x " + std::to_string(mask.rows), "has too many runs of pixels");
      const int run = static_cast<int>(runs.size());
      const int first = bounds[i], end = bounds[i + 1];
      runs.push_back({row, first, end, 0});
      sets.add();
      while (above < row_begin && runs[above].end + reach <= first) ++above;
      for (std::size_t k = above; k < row_begin && runs[k].first < end + reach; ++k) sets.unite(static_cast<int>(k), run);
    }
    above = row_begin;
  }
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const auto first = static_cast<std::size_t>(sets.smallest(static_cast<int>(i)));
    runs[i].component = first == i ? found.count++ : runs[first].component;
  }
  return found;
}

}  // namespace

void check_mask(const cv::Mat& mask, const std::string& argument) {
  if (mask.dims > 2) throw InvalidArgument(argument, std::to_string(mask.dims) + " dimensions", "must have rows and columns");
  if (mask.type() != CV_8UC1) throw InvalidArgument(argument, cv::typeToString(mask.type()), "must be a mask of 8-bit integers (CV_8UC1)");
}

MaskComponents foreground_components(const cv::Mat& mask) { return components(mask, true, 1); }

MaskComponents background_components(const cv::Mat& mask) { return components(mask, false, 0); }

std::vector<std::int64_t> component_areas_px(const MaskComponents& components) {
  std::vector<std::int64_t> areas_px(static_cast<std::size_t>(components.count), 0);
  for (const MaskRun& run : components.runs) areas_px[static_cast<std::size_t>(run.component)] += run.end - run.first;
  return areas_px;
}

}  // namespace ssjs
