/// Some rows of one side of a ground-range picture with the range growing, and the edges of an object in them.
/// docs/math/side_scan.md (SS-17), (SS-33)
///
/// Columns are counted from the nadir and rows from the top, with a fraction: column k covers k .. k + 1, its level is that of its middle.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "ssjs/base/sonar_side.hpp"
#include "ssjs/survey/waterfall.hpp"

namespace ssjs {

/// One side of a picture. An object that lies askew to the track moves by `skew` columns from row to row: a column of this view is one of
/// row `middle_row`, and is followed along the object in the others.
class SwathView {
 public:
  /// grey: CV_8U of the waterfall's size; both are referred to, not copied.
  SwathView(const Waterfall& waterfall, const cv::Mat& grey, SonarSide side, double middle_row = 0, double skew = 0)
      : waterfall_(waterfall), grey_(grey), side_(side), middle_row_(middle_row), skew_(skew) {}

  [[nodiscard]] int columns() const {
    return side_ == SonarSide::kStarboard ? grey_.cols - waterfall_.nadir_column : waterfall_.nadir_column;
  }
  [[nodiscard]] int rows() const { return grey_.rows; }
  [[nodiscard]] double middle_row() const { return middle_row_; }
  [[nodiscard]] double skew() const { return skew_; }
  /// None where nothing was recorded.
  [[nodiscard]] std::optional<double> level(int row, int column) const;

 private:
  const Waterfall& waterfall_;
  const cv::Mat& grey_;
  SonarSide side_;
  double middle_row_;
  double skew_;
};

/// Skew of the pixels at least as bright as `level` in these rows and columns: their regression of column on row; 0 where it is not
/// larger than three of its standard errors.
[[nodiscard]] double skew_of(const SwathView& upright, const cv::Range& rows, const cv::Range& columns, double level);

/// Mean grey level over rows, and whether any of them was recorded there.
struct RangeProfile {
  std::vector<double> grey;
  std::vector<bool> recorded;

  [[nodiscard]] int columns() const { return static_cast<int>(grey.size()); }
  [[nodiscard]] double operator[](int column) const { return grey[static_cast<std::size_t>(column)]; }
  [[nodiscard]] bool is_recorded(int column) const { return recorded[static_cast<std::size_t>(column)]; }
  [[nodiscard]] int brightest(const cv::Range& columns) const;
};

[[nodiscard]] RangeProfile range_profile(const SwathView& view, const cv::Range& rows);

struct ShadowEdges {
  double start = 0;
  double end = 0;
  double mean_grey = 0;
  bool is_cut = false;  ///< it ends where nothing was recorded
};

/// The shadow that begins behind the brightest column of the echo and at most `gap` columns behind all of it: where the profile stays
/// below `level`. None without one.
[[nodiscard]] std::optional<ShadowEdges> shadow_behind(const RangeProfile& profile, const cv::Range& echo, int gap, double level);

/// Where the echo begins that ends at `start`: at most `gap` columns before `echo`.
[[nodiscard]] double near_edge(const RangeProfile& profile, const cv::Range& echo, int gap, double start, double seabed_level);

struct RowExtent {
  double first = 0;
  double end = 0;
};

/// Where along track the object is: from the middle of its rows to both sides until echo (columns near .. start) and shadow (start ..
/// end) together stand out half as much as in the middle half of the rows, or three rows beyond them.
[[nodiscard]] RowExtent along_extent(const SwathView& view, const cv::Range& rows, double near, const ShadowEdges& shadow,
                                     double seabed_level);

}  // namespace ssjs
