#include "ssjs/optical/region_of_interest.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "ssjs/base/error.hpp"
#include "ssjs/imaging/mask_components.hpp"
#include "ssjs/imaging/morphology.hpp"

namespace ssjs {
namespace {

constexpr double kLowOfHigh = 0.4;
constexpr double kSigmaSmall_px = 2.0;        // of the hue's blur, on the frame made so much smaller that it spans few pixels
constexpr double kMedianOfRayleigh = 1.1774;  // a gradient of noise alone has two normal components: its length has this median, over sigma

constexpr std::size_t kLongestGradient = 1443;  // of Sobel's 3 x 3 on levels up to 255: 1020 sqrt 2

/// Half the side of a square that joins what is `part` of the width apart.
int reach_px(const cv::Mat& image, double part) { return std::max(1, static_cast<int>(std::lround(0.5 * part * image.cols))); }

cv::Mat square(int reach) { return cv::getStructuringElement(cv::MORPH_RECT, {2 * reach + 1, 2 * reach + 1}); }

/// Without components too small, or too large to be a thing on the seabed.
cv::Mat significant(const cv::Mat& mask, const RegionOfInterestConfig& config) {
  const MaskComponents components = foreground_components(mask);
  const std::vector<std::int64_t> area_px = component_areas_px(components);
  const auto total_px = static_cast<double>(mask.total());
  cv::Mat kept = cv::Mat::zeros(mask.size(), CV_8U);
  for (const MaskRun& run : components.runs) {
    const double part = static_cast<double>(area_px[static_cast<std::size_t>(run.component)]) / total_px;
    if (part >= config.smallest_area && part <= config.largest_area) kept.row(run.row).colRange(run.first, run.end).setTo(255);
  }
  return kept;
}

/// From the histogram of the lengths: the exact median to a level.
double median_length(const cv::Mat& dx, const cv::Mat& dy) {
  std::vector<std::size_t> counts(kLongestGradient + 1, 0);
  std::vector<int> length(static_cast<std::size_t>(dx.cols));
  for (int r = 0; r < dx.rows; ++r) {
    const short *x = dx.ptr<short>(r), *y = dy.ptr<short>(r);
    // Whole numbers below 2^24 are exact as float, and the root of one below a square stays below its root.
    for (int c = 0; c < dx.cols; ++c)
      length[static_cast<std::size_t>(c)] = static_cast<int>(std::sqrt(static_cast<float>(x[c] * x[c] + y[c] * y[c])));
    for (const int whole : length) ++counts[static_cast<std::size_t>(whole)];
  }
  std::size_t below = 0, level = 0;
  while (2 * (below + counts[level]) < dx.total()) below += counts[level++];
  return static_cast<double>(level) + 0.5;
}

}  // namespace

cv::Mat edge_regions(const cv::Mat& bright, const RegionOfInterestConfig& config) {
  if (bright.empty() || bright.type() != CV_8U)
    throw InvalidArgument("bright", bright.empty() ? "empty" : "another type", "must be CV_8U with one channel");
  cv::Mat smooth, dx, dy, edges, joined;
  cv::GaussianBlur(bright, smooth, cv::Size(), config.smoothing * bright.cols);
  cv::Sobel(smooth, dx, CV_16S, 1, 0);
  cv::Sobel(smooth, dy, CV_16S, 0, 1);
  const double high = config.edge_sigmas * median_length(dx, dy) / kMedianOfRayleigh;
  cv::Canny(dx, dy, edges, kLowOfHigh * high, high, true);
  const cv::Mat element = square(reach_px(bright, config.joining));
  cv::morphologyEx(edges, joined, cv::MORPH_CLOSE, element);
  cv::morphologyEx(fill_holes(joined), joined, cv::MORPH_OPEN, square(1));  // edges that enclose nothing are no region
  return significant(joined, config);
}

cv::Mat hue_regions(const cv::Mat& colour, const RegionOfInterestConfig& config) {
  if (colour.type() != CV_8UC3) throw InvalidArgument("colour", "another type", "must be CV_8U with the channels red, green, blue");
  // What is blurred by so much has as much to say with fewer pixels.
  const double sigma = config.hue_smoothing * colour.cols;
  const double shrink = std::max(1.0, std::floor(sigma / kSigmaSmall_px));
  const cv::Size size(std::max(1, static_cast<int>(colour.cols / shrink)), std::max(1, static_cast<int>(colour.rows / shrink)));
  cv::Mat small;
  cv::resize(colour, small, size, 0, 0, cv::INTER_AREA);
  // Hue as a direction, as long as the colour is saturated: the blur has no seam at red, and grey has no say. (V-9)
  cv::Mat cosine(size, CV_32F), sine(size, CV_32F);
  double saturation = 0.0;
  for (int r = 0; r < small.rows; ++r) {
    for (int c = 0; c < small.cols; ++c) {
      const cv::Vec3b& rgb = small.at<cv::Vec3b>(r, c);
      const float value = std::max({rgb[0], rgb[1], rgb[2], static_cast<unsigned char>(1)});
      cosine.at<float>(r, c) = (static_cast<float>(rgb[0]) - 0.5F * static_cast<float>(rgb[1] + rgb[2])) / value;
      sine.at<float>(r, c) = 0.8660254F * static_cast<float>(rgb[1] - rgb[2]) / value;
      saturation += 1.0 - std::min({rgb[0], rgb[1], rgb[2]}) / static_cast<double>(value);
    }
  }
  if (saturation / static_cast<double>(small.total()) < config.least_saturation) return {};
  cv::GaussianBlur(cosine, cosine, cv::Size(), sigma / shrink);
  cv::GaussianBlur(sine, sine, cv::Size(), sigma / shrink);
  const double mean = std::atan2(cv::sum(sine)[0], cv::sum(cosine)[0]);
  cv::Mat difference(size, CV_32F);
  for (int r = 0; r < small.rows; ++r) {
    for (int c = 0; c < small.cols; ++c) {
      const double hue = std::atan2(sine.at<float>(r, c), cosine.at<float>(r, c));
      const double turn = std::abs(hue - mean);
      difference.at<float>(r, c) = static_cast<float>(turn > CV_PI ? 2.0 * CV_PI - turn : turn);
    }
  }
  const double least = config.hue_factor * cv::mean(difference)[0];
  cv::resize(difference, difference, colour.size(), 0, 0, cv::INTER_LINEAR);
  return significant(difference > least, config);
}

RegionsOfInterest regions_of_interest(const cv::Mat& frame, const cv::Mat& bright, const RegionOfInterestConfig& config) {
  if (frame.size() != bright.size()) throw InvalidArgument("bright", bright.cols, "must be as large as the frame");
  RegionsOfInterest found;
  found.edge_mask = edge_regions(bright, config);
  const bool has_edges = cv::countNonZero(found.edge_mask) > 0;
  if (frame.channels() == 3 && has_edges) found.hue_mask = hue_regions(frame, config);
  found.mask = found.hue_mask.empty() ? found.edge_mask : significant(found.edge_mask & found.hue_mask, config);  // (V-10)
  found.labelled = find_regions(found.mask, bright);
  return found;
}

}  // namespace ssjs
