/// Pings one below the other: the sonar picture of a stretch of track. docs/math/side_scan.md (SS-10) to (SS-12)
///
/// Port on the left, far range outside, nadir in the middle, the oldest ping at the top. Column `nadir_column` + k and column
/// `nadir_column` - 1 - k hold the ranges from k to k + 1 times `column_m`, starboard and port.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/base/sonar_side.hpp"
#include "ssjs/imaging/sonar_image.hpp"
#include "ssjs/sensors/side_scan_ping.hpp"

namespace ssjs {

struct Waterfall {
  cv::Mat echo;   ///< CV_32F, linear echo strength, 0 where not valid
  cv::Mat valid;  ///< CV_8U, 255 where a ping holds a sample
  int nadir_column = 0;
  double column_m = 0.0;  ///< range that a column covers

  [[nodiscard]] double range_m(int column) const;  ///< of the column's middle
  [[nodiscard]] SonarSide side(int column) const { return column < nadir_column ? SonarSide::kPort : SonarSide::kStarboard; }
  [[nodiscard]] double column(SonarSide side, double range_m) const;  ///< with a fraction, pixel centres at whole numbers
};

/// Which channels of a ping make the picture: the i-th of those on each side, in the order of the ping (0: usually the low frequency).
struct WaterfallConfig {
  int channel_pair = 0;
  double column_m = 0.0;
  double range_m = 0.0;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("channel_pair", channel_pair, Rule::at_least(0), "which port and starboard channels, where a sonar has several frequencies");
    v.field("column_m", column_m, Rule::not_negative(), "range of a column; 0: that of a sample of the first ping");
    v.field("range_m", range_m, Rule::not_negative(), "of each side; 0: that of the farthest sample");
  }
};

/// In slant range. Every column takes the mean of the samples it covers, or the nearest one. A side that a ping lacks is not valid.
/// Throws InvalidArgument on no pings, on channels without a sample interval and where nothing was recorded on either side.
[[nodiscard]] Waterfall slant_waterfall(const std::vector<SideScanPing>& pings, const WaterfallConfig& config);

/// In ground range over a flat seabed, by the first return of each ping: rows of pings without altitude, and columns out of reach, are
/// not valid. (SS-12)
[[nodiscard]] Waterfall ground_waterfall(const std::vector<SideScanPing>& pings, const WaterfallConfig& config);

/// The channel of a side that the configuration asks for; none if the ping lacks it.
[[nodiscard]] const SideScanChannel* channel_of(const SideScanPing& ping, SonarSide side, int channel_pair);

enum class ToneCurve { kPercentile, kLogarithmic };

struct ToneConfig {
  ToneCurve curve = ToneCurve::kLogarithmic;
  double dark_percent = 1.0;
  double bright_percent = 99.7;
  template <class Visitor>
  void visit(Visitor& v) {
    v.choice("curve", curve, Choices<ToneCurve>{{"percentile", ToneCurve::kPercentile}, {"logarithmic", ToneCurve::kLogarithmic}},
             "how echo strengths become grey levels");
    v.field("dark_percent", dark_percent, Rule{0, 100, false, true}, "so many percent of the valid pixels are black");
    v.field("bright_percent", bright_percent, Rule{0, 100, true, false}, "beyond so many percent they are white");
  }
};

/// 8 bits from the echo strength or its logarithm between two of its percentiles. (SS-11) A constant picture is black.
[[nodiscard]] SonarImage in_grey(const Waterfall& waterfall, const ToneConfig& config);

/// 16 bits for what follows in imaging/: linear, the median of the valid pixels at 4096, saturated. Black where the median is 0.
[[nodiscard]] SonarImage in_16_bits(const Waterfall& waterfall);

}  // namespace ssjs
