#include "ssjs/optical/frame_preprocess.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

constexpr double kNoiseSigmaPx = 1.5;  // the noise of the sensor is sharp in every frame: it is smoothed before sharpness is looked for
constexpr double kNoContrast = 1.0;    // added to the local standard deviation: a flat patch is not blown up into its noise
constexpr double kNoLight = 1.0;       // added to the local mean: nor is a dark one

void check_frame(const cv::Mat& frame) {
  if (!frame.empty() && frame.depth() == CV_8U && (frame.channels() == 1 || frame.channels() == 3)) return;
  throw InvalidArgument("frame", frame.empty() ? "empty" : "type " + std::to_string(frame.type()),
                        "must have 8 bits and one or three channels");
}

void check_one_channel(const cv::Mat& grey) {
  check_frame(grey);
  if (grey.channels() != 1) throw InvalidArgument("grey", "three channels", "choose one with frame_channel()");
}

double level_sigma(const cv::Mat& channel) {
  cv::Scalar mean, sigma;
  cv::meanStdDev(channel, mean, sigma);
  return sigma[0];
}

/// A Gaussian of `sigma_px`, on the frame made so much smaller that it spans few pixels: the same to a thousandth, at any width.
cv::Mat smoothed(const cv::Mat& values, double sigma_px) {
  constexpr double kSigmaSmallPx = 4.0;
  const double factor = std::max(1.0, std::floor(sigma_px / kSigmaSmallPx));
  const cv::Size small(std::max(1, static_cast<int>(values.cols / factor)), std::max(1, static_cast<int>(values.rows / factor)));
  cv::Mat reduced, back;
  cv::resize(values, reduced, small, 0, 0, cv::INTER_AREA);
  cv::GaussianBlur(reduced, reduced, cv::Size(), sigma_px / factor, sigma_px / factor, cv::BORDER_REFLECT);
  cv::resize(reduced, back, values.size(), 0, 0, cv::INTER_LINEAR);
  return back;
}

}  // namespace

cv::Mat frame_channel(const cv::Mat& frame, FrameChannel channel) {
  check_frame(frame);
  if (frame.channels() == 1) return frame;
  cv::Mat chosen;
  if (channel == FrameChannel::kGrey) {
    cv::cvtColor(frame, chosen, cv::COLOR_RGB2GRAY);
    return chosen;
  }
  cv::Mat channels[3];
  cv::split(frame, channels);
  if (channel != FrameChannel::kContrast) return channels[static_cast<int>(channel) - static_cast<int>(FrameChannel::kRed)];
  return *std::max_element(std::begin(channels), std::end(channels),
                           [](const cv::Mat& a, const cv::Mat& b) { return level_sigma(a) < level_sigma(b); });
}

cv::Mat evenly_bright(const cv::Mat& grey, const FrameConfig& config) {
  check_one_channel(grey);
  cv::Mat levels, bright, even;
  grey.convertTo(levels, CV_32F);
  const cv::Mat light = smoothed(levels, config.light_scale * grey.cols) + kNoLight;
  cv::divide(levels - light, light, bright);
  cv::Scalar mean, sigma;
  cv::meanStdDev(bright, mean, sigma);
  const double gain = sigma[0] > 0.0 ? config.level_sigma / sigma[0] : 0.0;
  bright.convertTo(even, CV_8U, gain, config.mean_level - gain * mean[0]);  // (V-7)
  return even;
}

cv::Mat evenly_lit(const cv::Mat& grey, const FrameConfig& config) {
  check_one_channel(grey);
  const double sigma_px = config.light_scale * grey.cols;
  cv::Mat levels, deviation, squares, lit;
  grey.convertTo(levels, CV_32F);
  deviation = levels - smoothed(levels, sigma_px);
  cv::sqrt(smoothed(deviation.mul(deviation), sigma_px), squares);
  cv::divide(deviation, squares + kNoContrast, deviation, config.level_sigma);  // (V-6)
  deviation.convertTo(lit, CV_8U, 1.0, config.mean_level);
  return lit;
}

FrameQuality frame_quality(const cv::Mat& grey) {
  check_frame(grey);
  FrameQuality quality;
  quality.mean_level = cv::mean(grey)[0];
  quality.level_sigma = level_sigma(grey);
  cv::Mat smooth, laplacian;
  grey.convertTo(smooth, CV_32F);
  cv::GaussianBlur(smooth, smooth, cv::Size(), kNoiseSigmaPx);
  cv::Laplacian(smooth, laplacian, CV_32F);
  const double rough = level_sigma(laplacian);
  if (quality.level_sigma > 0.0) quality.sharpness = rough * rough / (quality.level_sigma * quality.level_sigma);
  return quality;
}

}  // namespace ssjs
