/// What a report keeps of a survey's pictures: a row a ping, and the pings around each contact. docs/math/side_scan.md (SS-12)
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "ssjs/survey/contact.hpp"
#include "ssjs/survey/side_scan_survey.hpp"

namespace ssjs {

/// A ping's place in the survey and what was looked at on either side of it.
struct PingReach {
  double time_s = SideScanPing::kUnknown;
  double altitude_m = SideScanPing::kUnknown;  ///< the one that was used: of the log, or of bottom tracking
  /// Ground ranges between which the sonar was listened to: port near, far, starboard near, far; NaN on a side without a valid pixel
  /// (turns, pings without altitude).
  std::array<double, 4> reach_m{};
};

/// Rows of a ground-range picture, gain normalised: CV_8U, 0 where not valid. Port on the left, as in Waterfall.
struct PictureRows {
  cv::Mat grey;
  std::uint64_t first_index = 0;  ///< of the first row's ping
  int nadir_column = 0;
  double column_m = 0.0;
};

/// The block's own pings, without those it shares with its neighbours.
[[nodiscard]] std::vector<PingReach> own_reach(const FinishedBlock& finished);
[[nodiscard]] PictureRows own_rows(const FinishedBlock& finished);

/// The pings around a contact of the block, `around` of them before and after the ping it is abeam of as far as the block holds them.
[[nodiscard]] PictureRows rows_around(const FinishedBlock& finished, const SideScanContact& contact, int around);

}  // namespace ssjs
