#include "ssjs/optical/region_of_interest.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "ssjs/base/error.hpp"
#include "ssjs/imaging/morphology.hpp"

namespace ssjs {
namespace {

constexpr double kLowOfHigh = 0.4;
constexpr double kSigmaSmall_px = 2.0;        // of the hue's blur, on the frame made so much smaller that it spans few pixels
constexpr double kMedianOfRayleigh = 1.1774;  // a gradient of noise alone has two normal components: its length has this median, over sigma

/// Half the side of a square that joins what is `part` of the width apart.
int reach_px(const cv::Mat& image, double part) { return std::max(1, static_cast<int>(std::lround(0.5 * part * image.cols))); }

cv::Mat square(int reach) { return cv::getStructuringElement(cv::MORPH_RECT, {2 * reach + 1, 2 * reach + 1}); }

/// Without components too small, or too large to be a thing on the seabed.
cv::Mat significant(const cv::Mat& mask, const RegionOfInterestConfig& config) {
  cv::Mat labels, stats, centroids;
  const int count = cv::connectedComponentsWithStats(mask, labels, stats, centroids, 8, CV_32S);
  const double area = static_cast<double>(mask.total());
  std::vector<unsigned char> keep(static_cast<std::size_t>(count), 0);
  for (int label = 1; label < count; ++label) {
    const double part = stats.at<int>(label, cv::CC_STAT_AREA) / area;
    if (part >= config.smallest_area && part <= config.largest_area) keep[static_cast<std::size_t>(label)] = 255;
  }
  cv::Mat kept(mask.size(), CV_8U);
  for (int r = 0; r < mask.rows; ++r) {
    for (int c = 0; c < mask.cols; ++c) kept.at<unsigned char>(r, c) = keep[static_cast<std::size_t>(labels.at<int>(r, c))];
  }
  return kept;
}

/// From the histogram of the lengths: the exact median to a level.
double median_length(const cv::Mat& dx, const cv::Mat& dy) {
  std::vector<std::size_t> counts;
  for (int r = 0; r < dx.rows; ++r) {
    for (int c = 0; c < dx.cols; ++c) {
      const double x = dx.at<short>(r, c), y = dy.at<short>(r, c);
      const auto length = static_cast<std::size_t>(std::sqrt(x * x + y * y));
      if (length >= counts.size()) counts.resize(length + 1);
      ++counts[length];
    }
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
      difference.at<float>(r, c) = static_cast<float>(std::abs(std::remainder(hue - mean, 2.0 * CV_PI)));
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
  if (frame.channels() == 3) found.hue_mask = hue_regions(frame, config);
  found.mask = found.hue_mask.empty() ? found.edge_mask : significant(found.edge_mask & found.hue_mask, config);  // (V-10)
  found.labelled = find_regions(found.mask, bright);
  return found;
}

}  // namespace ssjs
