#include "ssjs/imaging/mask_components.hpp"

#include <cstring>
#include <limits>
#include <string>

#include "ssjs/base/error.hpp"
#include "ssjs/imaging/disjoint_sets.hpp"

namespace ssjs {
namespace {

/// The first column from `column` on that is set, or `columns`.
int next_set(const unsigned char* row, int column, int columns) {
  std::uint64_t eight = 0;
  for (; column + 8 <= columns; column += 8) {
    std::memcpy(&eight, row + column, sizeof eight);
    if (eight != 0) break;
  }
  while (column < columns && row[column] == 0) ++column;
  return column;
}

/// The first column from `column` on that is clear, or `columns`.
int next_clear(const unsigned char* row, int column, int columns) {
  if (column >= columns) return columns;
  const void* found = std::memchr(row + column, 0, static_cast<std::size_t>(columns - column));
  return found == nullptr ? columns : static_cast<int>(static_cast<const unsigned char*>(found) - row);
}

/// Runs of rows one above the other touch when they share a column (reach 0), or when they do after one of them has been
/// drawn out by a pixel at both ends (reach 1).
MaskComponents components(const cv::Mat& mask, bool of_set_pixels, int reach) {
  check_mask(mask, "mask");
  MaskComponents found;
  std::vector<MaskRun>& runs = found.runs;
  DisjointSets sets;
  std::size_t above = 0;  // the first run of the row above that can touch this or a later run
  for (int row = 0; row < mask.rows; ++row) {
    const unsigned char* pixels = mask.ptr<unsigned char>(row);
    const std::size_t row_begin = runs.size();
    int column = of_set_pixels ? next_set(pixels, 0, mask.cols) : next_clear(pixels, 0, mask.cols);
    while (column < mask.cols) {
      const int end = of_set_pixels ? next_clear(pixels, column, mask.cols) : next_set(pixels, column, mask.cols);
      if (runs.size() >= static_cast<std::size_t>(std::numeric_limits<int>::max()))
        throw InvalidArgument("mask", std::to_string(mask.cols) + " x " + std::to_string(mask.rows), "has too many runs of pixels");
      const int run = static_cast<int>(runs.size());
      runs.push_back({row, column, end, 0});
      sets.add();
      while (above < row_begin && runs[above].end + reach <= column) ++above;
      for (std::size_t k = above; k < row_begin && runs[k].first < end + reach; ++k) sets.unite(static_cast<int>(k), run);
      column = of_set_pixels ? next_set(pixels, end, mask.cols) : next_clear(pixels, end, mask.cols);
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
