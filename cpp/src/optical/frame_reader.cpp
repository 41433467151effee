#include "ssjs/optical/frame_reader.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

std::string with_number(const char* format, double value) {
  char text[96];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::optional<std::string> reason_to_leave_out(const FrameQuality& quality, const FrameLimits& limits) {
  if (quality.mean_level < limits.darkest_level) return with_number("dark: mean level %.1f of 255", quality.mean_level);
  if (quality.level_sigma < limits.least_level_sigma) return with_number("blank: levels vary by %.2f of 255", quality.level_sigma);
  if (quality.sharpness < limits.least_sharpness) return with_number("blurred: sharpness %.2g", quality.sharpness);
  return std::nullopt;
}

int label_at(const cv::Mat& labels, cv::Point2d at) {
  const int column = std::clamp(static_cast<int>(std::lround(at.x)), 0, labels.cols - 1);
  const int row = std::clamp(static_cast<int>(std::lround(at.y)), 0, labels.rows - 1);
  return labels.at<int>(row, column);
}

}  // namespace

FrameFeatures straightened(FrameFeatures seen, const CameraCalibration& lens) {
  for (Keypoint& keypoint : seen.keypoints.points) keypoint.position_px = undistorted(lens, keypoint.position_px);
  return seen;
}

FrameReader::FrameReader(const FrameReaderConfig& config, const std::optional<CameraCalibration>& calibration) : config_(config) {
  throw_if_any(violations(config));
  if (calibration) undistortion_.emplace(*calibration);
}

cv::Mat FrameReader::corrected(const cv::Mat& frame) const { return undistortion_ ? undistortion_->apply(frame) : frame; }

cv::Mat FrameReader::lit(const cv::Mat& frame) const {
  return evenly_lit(frame_channel(corrected(frame), config_.light.channel), config_.light);
}

FrameFeatures FrameReader::read(const cv::Mat& frame) const {
  const cv::Mat ideal = corrected(frame);
  const cv::Mat grey = frame_channel(ideal, config_.light.channel);
  FrameFeatures features;
  features.size = ideal.size();
  features.quality = frame_quality(grey);
  features.left_out = reason_to_leave_out(features.quality, config_.limits);
  if (features.left_out) return features;

  const RegionsOfInterest found = regions_of_interest(ideal, evenly_bright(grey, config_.light), config_.regions);
  features.regions = found.labelled.regions;
  const bool inside = config_.places == KeypointPlaces::kRegions && !features.regions.empty();
  const cv::Mat seen = undistortion_ ? undistortion_->valid() : cv::Mat();
  features.keypoints = find_keypoints(evenly_lit(grey, config_.light), inside ? found.mask : seen, config_.keypoints);
  for (const Keypoint& keypoint : features.keypoints.points) {
    features.region_of.push_back(label_at(found.labelled.labels, keypoint.position_px));
  }
  return features;
}

std::optional<Registration> register_frames(const FrameFeatures& first, const FrameFeatures& second, const MatchingConfig& config,
                                            std::uint64_t seed) {
  return register_frames(first.keypoints, second.keypoints, match_descriptors(first.keypoints, second.keypoints, config.ratio), config,
                         seed);
}

}  // namespace ssjs
