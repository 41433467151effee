/// An object's echo and shadow followed through the rows of a ground-range picture. docs/math/side_scan.md (SS-17), (SS-19), (SS-33)
#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "ssjs/survey/echo_profile.hpp"

namespace ssjs {

struct TraceLevels {
  double seabed = 0;        ///< grey level
  double shadow = 0;        ///< grey level below which it is dark
  int gap = 0;              ///< columns between echo and shadow that are bridged
  double least_shadow = 0;  ///< columns
};

/// Rows with a fraction: row r covers r .. r + 1.
struct RowExtent {
  double first = 0;
  double end = 0;
};

struct ObjectTrace {
  double middle_row = 0;  ///< the row that the columns are of
  double skew = 0;        ///< columns by which the object moves from row to row
  double near = 0;        ///< column where the echo begins
  ShadowEdges shadow;
  RowExtent rows;         ///< where echo and shadow together stand out half as much as in its middle
  double confidence = 0;  ///< (SS-19)
};

/// Of the object whose echo a detector has found in these rows and columns, which may hold more: speckle that touches it. None without
/// a shadow.
[[nodiscard]] std::optional<ObjectTrace> trace_object(const SwathView& upright, const cv::Range& rows, const cv::Range& echo,
                                                      const TraceLevels& levels);

}  // namespace ssjs
