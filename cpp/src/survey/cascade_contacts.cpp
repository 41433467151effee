#include "ssjs/survey/cascade_contacts.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <utility>

#include "ssjs/base/error.hpp"
#include "ssjs/imaging/regions.hpp"

namespace ssjs {
namespace {

constexpr int kEchoMedian_px = 3;

/// What the training left in the model; `otherwise` for models of other programs.
double trained_with(const HaarCascade& cascade, const std::string& setting, double otherwise) {
  for (const auto& [key, text] : cascade.provenance.settings) {
    if (key != setting) continue;
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    if (end == text.c_str() + text.size() && !text.empty() && std::isfinite(value)) return value;
    throw InvalidArgument("cascade_model: " + setting, text, "is not a number in the model");
  }
  return otherwise;
}

double margin_of(const HaarCascade& cascade) {
  if (trained_with(cascade, "image.smoothing_px", 1) != 1 || trained_with(cascade, "image.border_px", 0) != 0)
    throw InvalidArgument("cascade_model", "image.smoothing_px or image.border_px",
                          "prepared the pictures of this training; a survey's are as they are: train with 1 and 0");
  return trained_with(cascade, "window.margin", 0);
}

CascadeDetectorConfig detector_config(const CascadeContactsConfig& config, CascadeSide side) {
  CascadeDetectorConfig made;
  made.scale_factor = config.scale_factor;
  made.min_neighbours = config.min_neighbours;
  made.grouping = HitGrouping::kBest;
  made.max_overlap = config.max_overlap;
  made.opencv_grid = false;
  made.side = side;
  made.verify = config.verify;
  made.min_contour_score = config.min_contour_score;
  return made;
}

}  // namespace

cv::Rect object_in_window(const cv::Rect& window, double margin, CascadeSide seen) {
  const auto inner = [&](int length) { return std::max(1, static_cast<int>(std::lround(length / (1 + 2 * margin)))); };
  const cv::Size size(inner(window.width), inner(window.height));
  const int rest = window.width - size.width;
  const int left = seen == CascadeSide::kMirrored ? rest - rest / 2 : rest / 2;
  return {{window.x + left, window.y + (window.height - size.height) / 2}, size};
}

CascadeContacts::CascadeContacts(HaarCascade cascade, const CascadeContactsConfig& config)
    : config_(config),
      margin_(margin_of(cascade)),
      starboard_(cascade, detector_config(config, CascadeSide::kAsTrained)),
      port_(std::move(cascade), detector_config(config, CascadeSide::kMirrored)) {
  throw_if_any(violations(config_));
}

std::vector<cv::Rect> CascadeContacts::echoes(const SonarImage& side, const CascadeDetector& detector, CascadeSide seen) const {
  cv::Mat smooth;
  cv::medianBlur(side.intensity, smooth, kEchoMedian_px);
  std::vector<cv::Rect> found;
  for (const Detection& detection : detector.detect(side)) {
    if (detection.score < config_.min_score) continue;
    const cv::Rect object = object_in_window(detection.box, margin_, seen) & cv::Rect({0, 0}, side.intensity.size());
    if (object.empty()) continue;
    const cv::Mat inside = smooth(object);
    cv::Mat bright = inside > config_.echo_level;
    bright.setTo(0, side.valid(object) == 0);
    const std::vector<Region> regions = find_regions(bright, inside).regions;
    const auto largest =
        std::max_element(regions.begin(), regions.end(), [](const Region& a, const Region& b) { return a.area_px < b.area_px; });
    if (largest == regions.end() || largest->area_px < config_.smallest_echo_px) continue;
    found.push_back(largest->bounding_box + object.tl());
  }
  return found;
}

std::vector<ContactBox> CascadeContacts::boxes(const SonarImage& picture, int nadir_column) const {
  const auto part = [&](int first, int end) {
    return SonarImage{picture.intensity.colRange(first, end).clone(), picture.valid.colRange(first, end).clone()};
  };
  std::vector<ContactBox> all;
  if (nadir_column > 0) {
    for (const cv::Rect& echo : echoes(part(0, nadir_column), port_, CascadeSide::kMirrored)) all.push_back({SonarSide::kPort, echo});
  }
  if (nadir_column < picture.intensity.cols) {
    for (const cv::Rect& echo : echoes(part(nadir_column, picture.intensity.cols), starboard_, CascadeSide::kAsTrained))
      all.push_back({SonarSide::kStarboard, echo + cv::Point(nadir_column, 0)});
  }
  return all;
}

}  // namespace ssjs
