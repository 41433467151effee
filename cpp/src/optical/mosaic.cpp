#include "ssjs/optical/mosaic.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "ssjs/base/error.hpp"
#include "ssjs/optical/matching.hpp"

namespace ssjs {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kLeastWeight = 1e-6;  // a pixel at the very border counts where nothing else is seen
constexpr double kDarkest = 4.0;       // levels: light weaker than this is not divided out

std::array<cv::Point2d, 4> corners(cv::Size frame) {
  const double right = frame.width - 0.5, bottom = frame.height - 0.5;
  return {cv::Point2d{-0.5, -0.5}, {right, -0.5}, {right, bottom}, {-0.5, bottom}};
}

bool is_ahead(const cv::Matx33d& H, cv::Size frame) {
  const auto depth = [&](cv::Point2d p) { return H(2, 0) * p.x + H(2, 1) * p.y + H(2, 2); };
  const auto all = corners(frame);
  return std::all_of(all.begin(), all.end(), [&](cv::Point2d p) { return depth(p) * H(2, 2) > 0.0 && std::isfinite(depth(p)); });
}

/// Side of the square as large as the frame on the map, by side of the one as large in pixels.
double length_of_pixel(const cv::Matx33d& map_H_frame, cv::Size frame) {
  double twice_area = 0.0;
  const auto all = corners(frame);
  for (std::size_t i = 0; i < all.size(); ++i) {
    twice_area += transformed(map_H_frame, all[i]).cross(transformed(map_H_frame, all[(i + 1) % all.size()]));
  }
  return std::sqrt(0.5 * std::abs(twice_area) / frame.area());
}

/// Map -> pixels of the canvas: row 0 on top, the centre of pixel (0, 0) half a pixel inside the window.
cv::Matx33d canvas_H_map(const MosaicWindow& window) {
  const double s = 1.0 / window.pixel_length, top = window.bottom + window.size_px.height * window.pixel_length;
  return {s, 0.0, -s * window.left - 0.5, 0.0, -s, s * top - 0.5, 0.0, 0.0, 1.0};
}

/// How far each pixel lies from the border, 1 in the middle, to the power that makes seams sharp. CV_32F
cv::Mat feather(cv::Size size, double sharpness) {
  cv::Mat weight(size, CV_32F);
  for (int r = 0; r < size.height; ++r) {
    const double y = std::min(r + 0.5, size.height - r - 0.5) / (0.5 * size.height);
    for (int c = 0; c < size.width; ++c) {
      const double x = std::min(c + 0.5, size.width - c - 0.5) / (0.5 * size.width);
      weight.at<float>(r, c) = static_cast<float>(std::max(kLeastWeight, std::pow(x * y, sharpness)));
    }
  }
  return weight;
}

void check_frame(const cv::Mat& frame) {
  if (frame.empty() || (frame.type() != CV_8U && frame.type() != CV_8UC3)) {
    throw InvalidArgument("frame", frame.channels(), "must be CV_8U with one or three channels");
  }
}

}  // namespace

MosaicWindow mosaic_window(const std::vector<cv::Matx33d>& map_H_frame, cv::Size frame, const MosaicConfig& config) {
  throw_if_any(violations(config));
  if (map_H_frame.empty() || frame.area() <= 0) throw InvalidArgument("map_H_frame", static_cast<int>(map_H_frame.size()), "is empty");
  double left = kInfinity, right = -kInfinity, bottom = kInfinity, top = -kInfinity;
  std::vector<double> lengths;
  for (const cv::Matx33d& H : map_H_frame) {
    if (!is_ahead(H, frame)) {
      throw InvalidArgument("map_H_frame", static_cast<int>(lengths.size()), "takes a corner of this frame to infinity");
    }
    for (const cv::Point2d corner : corners(frame)) {
      const cv::Point2d p = transformed(H, corner);
      left = std::min(left, p.x);
      right = std::max(right, p.x);
      bottom = std::min(bottom, p.y);
      top = std::max(top, p.y);
    }
    lengths.push_back(length_of_pixel(H, frame));
  }
  std::nth_element(lengths.begin(), lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2), lengths.end());
  const double width = right - left, height = top - bottom;
  const double length = std::max({lengths[lengths.size() / 2], std::sqrt(width * height / (config.max_megapixels * 1e6)),
                                  std::max(width, height) / config.max_side_px});  // (V-22)
  if (!(length > 0.0 && std::isfinite(length))) throw InvalidArgument("map_H_frame", length, "must take frames to something finite");
  const auto pixels = [&](double extent) { return std::max(1, static_cast<int>(std::floor(extent / length + 1e-6))); };
  return {left, bottom, length, {pixels(width), pixels(height)}};
}

void LampLight::learn(const cv::Mat& frame) {
  check_frame(frame);
  if (sum_.empty()) sum_ = cv::Mat::zeros(frame.size(), CV_MAKETYPE(CV_32F, frame.channels()));
  if (frame.size() != sum_.size() || frame.channels() != sum_.channels()) {
    throw InvalidArgument("frame", frame.cols, "must be as large as the others and have their channels");
  }
  cv::accumulate(frame, sum_);
  ++count_;
  light_.release();
}

const cv::Mat& LampLight::light() const {
  if (light_.empty()) {
    const double sigma = config_.light_scale * sum_.cols;
    cv::GaussianBlur(sum_ * (1.0 / count_), light_, cv::Size(), sigma, sigma, cv::BORDER_REFLECT_101);
    light_ = cv::max(light_, kDarkest);
  }
  return light_;
}

cv::Mat LampLight::evened(const cv::Mat& frame) const {
  check_frame(frame);
  if (count_ == 0 || frame.size() != sum_.size() || frame.channels() != sum_.channels()) {
    throw InvalidArgument("frame", frame.cols, "must be like those that the light was learnt from");
  }
  cv::Mat floating;
  frame.convertTo(floating, CV_32F);
  cv::divide(floating, light(), floating);
  const cv::Scalar usual = cv::mean(light()), here = cv::mean(floating);  // (V-23)
  cv::Scalar gain;
  for (int c = 0; c < frame.channels(); ++c) gain[c] = here[c] > 1e-6 ? usual[c] / here[c] : usual[c];
  cv::multiply(floating, gain, floating);
  cv::Mat evened;
  floating.convertTo(evened, CV_8U);
  return evened;
}

MosaicCanvas::MosaicCanvas(const MosaicWindow& window, int channels, const MosaicConfig& config) : window_(window), config_(config) {
  throw_if_any(violations(config));
  if (window.size_px.area() <= 0) throw InvalidArgument("window", window.size_px.width, "must have pixels");
  if (channels != 1 && channels != 3) throw InvalidArgument("channels", channels, "must be 1 or 3");
  sum_ = cv::Mat::zeros(window.size_px, CV_MAKETYPE(CV_32F, channels));
  weight_ = cv::Mat::zeros(window.size_px, CV_32F);
}

void MosaicCanvas::add(const cv::Mat& frame, const cv::Matx33d& map_H_frame, const cv::Mat& valid) {
  check_frame(frame);
  if (frame.channels() != sum_.channels()) throw InvalidArgument("frame", frame.channels(), "must have the channels of the canvas");
  if (!is_ahead(map_H_frame, frame.size())) throw InvalidArgument("map_H_frame", map_H_frame(2, 2), "takes a corner to infinity");
  if (!valid.empty() && (valid.size() != frame.size() || valid.type() != CV_8U)) {
    throw InvalidArgument("valid", valid.cols, "must be CV_8U and as large as the frame");
  }
  cv::Matx33d canvas_H_frame = canvas_H_map(window_) * map_H_frame;
  cv::Mat pixels = frame, weight = feather(frame.size(), config_.sharpness);
  if (!valid.empty()) weight.setTo(0.0, valid == 0);
  const double shrink = length_of_pixel(canvas_H_frame, frame.size());
  if (shrink < 0.7) {  // drawn much smaller: every pixel of the frame counts, not one in a few
    const cv::Size size(std::max(1, cvRound(frame.cols * shrink)), std::max(1, cvRound(frame.rows * shrink)));
    cv::resize(pixels, pixels, size, 0, 0, cv::INTER_AREA);
    cv::resize(weight, weight, size, 0, 0, cv::INTER_AREA);
    const double sx = static_cast<double>(frame.cols) / size.width, sy = static_cast<double>(frame.rows) / size.height;
    canvas_H_frame = canvas_H_frame * cv::Matx33d(sx, 0, 0.5 * sx - 0.5, 0, sy, 0.5 * sy - 0.5, 0, 0, 1);
  }
  double left = kInfinity, right = -kInfinity, top = kInfinity, bottom = -kInfinity;
  for (const cv::Point2d corner : corners(pixels.size())) {
    const cv::Point2d p = transformed(canvas_H_frame, corner);
    left = std::min(left, p.x);
    right = std::max(right, p.x);
    top = std::min(top, p.y);
    bottom = std::max(bottom, p.y);
  }
  const auto on = [](double value, int size) { return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(size))); };
  const cv::Rect part(cv::Point(on(std::floor(left), sum_.cols), on(std::floor(top), sum_.rows)),
                      cv::Point(on(std::ceil(right) + 1.0, sum_.cols), on(std::ceil(bottom) + 1.0, sum_.rows)));
  if (part.empty()) return;
  const cv::Matx33d part_H_frame = cv::Matx33d(1, 0, -part.x, 0, 1, -part.y, 0, 0, 1) * canvas_H_frame;
  cv::Mat drawn, drawn_weight;
  cv::warpPerspective(pixels, drawn, part_H_frame, part.size(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  cv::warpPerspective(weight, drawn_weight, part_H_frame, part.size(), cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  drawn.convertTo(drawn, CV_32F);
  cv::Mat spread;  // the weight in every channel (V-24)
  cv::merge(std::vector<cv::Mat>(static_cast<std::size_t>(drawn.channels()), drawn_weight), spread);
  sum_(part) += drawn.mul(spread);
  weight_(part) += drawn_weight;
}

cv::Mat MosaicCanvas::picture() const {
  cv::Mat spread, mean, picture;
  cv::merge(std::vector<cv::Mat>(static_cast<std::size_t>(sum_.channels()), cv::max(weight_, 1e-12)), spread);
  cv::divide(sum_, spread, mean);
  mean.convertTo(picture, CV_8U);
  return picture;
}

cv::Mat MosaicCanvas::seen() const { return weight_ > 0.0; }

}  // namespace ssjs
