#include "ssjs/cascade/cascade_detector.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "ssjs/base/error.hpp"
#include "ssjs/cascade/parallel_blocks.hpp"
#include "ssjs/cascade/row_scan.hpp"

namespace ssjs {
namespace {

constexpr int kRowsPerStripe = 48;  // rows of windows, px; what a stripe needs of the integral images stays in a core's cache

struct Level {
  cv::Mat picture;
  cv::Mat invalid;  ///< 0 or 1; empty: none
  float scale = 1;
  int step = 1;
  int row_end = 0;  ///< tops of windows lie above this row
};

/// (C-14): the scales at which windows of the allowed sizes fit into the picture.
std::vector<float> scales_of(cv::Size picture, cv::Size window, const CascadeDetectorConfig& config) {
  constexpr std::size_t kMostScales = 1024;
  const cv::Size smallest(config.min_width_px.value_or(0), config.min_height_px.value_or(0));
  const cv::Size largest(std::min(config.max_width_px.value_or(picture.width), picture.width),
                         std::min(config.max_height_px.value_or(picture.height), picture.height));
  std::vector<float> scales;
  for (double factor = 1; scales.size() < kMostScales; factor *= config.scale_factor) {
    const cv::Size size(cvRound(window.width * factor), cvRound(window.height * factor));
    if (size.width > largest.width || size.height > largest.height) break;
    if (size.width >= smallest.width && size.height >= smallest.height) scales.push_back(static_cast<float>(factor));
  }
  return scales;
}

Level level_of(const SonarImage& image, float scale) {
  const cv::Size size(cvRound(static_cast<float>(image.intensity.cols) / scale), cvRound(static_cast<float>(image.intensity.rows) / scale));
  Level level;
  level.scale = scale;
  level.step = scale >= 2 ? 1 : 2;
  if (size == image.intensity.size())
    level.picture = image.intensity;
  else
    cv::resize(image.intensity, level.picture, size, 0, 0, cv::INTER_LINEAR_EXACT);
  if (!image.valid.empty()) {
    cv::Mat valid;
    cv::resize(image.valid, valid, size, 0, 0, cv::INTER_NEAREST);
    level.invalid = (valid == 0) / 255;
  }
  return level;
}

/// What the scan sees: 8 bits, mirrored if the side is, invalid pixels at the mean of the valid ones.
SonarImage prepared(const SonarImage& image, CascadeSide side) {
  SonarImage seen = in_8_bits(image);
  if (!seen.valid.empty() && cv::countNonZero(seen.valid) == static_cast<int>(seen.valid.total())) seen.valid.release();
  if (!seen.valid.empty()) {
    seen.intensity = seen.intensity.clone();
    seen.intensity.setTo(cv::mean(seen.intensity, seen.valid), seen.valid == 0);
  }
  if (side == CascadeSide::kMirrored) {
    cv::Mat flipped;
    cv::flip(seen.intensity, flipped, 1);
    seen.intensity = std::move(flipped);
    if (!seen.valid.empty()) {
      cv::Mat flipped_mask;
      cv::flip(seen.valid, flipped_mask, 1);
      seen.valid = std::move(flipped_mask);
    }
  }
  return seen;
}

/// Beyond the last row of windows that OpenCV comes to: it cuts the rows into stripes of equal height, by the width at the first
/// scale, and drops what an odd number of rows leaves over.
int opencv_row_end(cv::Size first_level, cv::Size level, cv::Size window, int step) {
  const int stripes = std::max(1, (first_level.width + 1 - window.width + 31) / 32);
  const int rows = level.height + 1 - window.height;
  const int stripe = std::max((rows / step + stripes - 1) / stripes, 1) * step;
  return std::min(stripes * stripe, rows);
}

struct StripeHits {
  std::vector<LevelHits::Hit> hits;
  double windows = 0;
};

/// What one thread uses again and again.
struct Workspace {
  IntegralImage integral;
  IntegralImage invalid;
  RowScan::Scratch row;
};

/// The windows whose tops lie in [top, top + kRowsPerStripe).
StripeHits scan_stripe(cv::Size window, bool tilted, const RowScan& row_scan, const CascadeDetectorConfig& config, const Level& level,
                       int top, Workspace& workspace) {
  const int last_top = std::min(top + kRowsPerStripe, level.row_end) - 1;
  const cv::Rect rows(0, top, level.picture.cols, last_top - top + window.height);
  IntegralImage& integral = workspace.integral;
  integral.assign(level.picture(rows), tilted ? IntegralImage::Diagonal::kWith : IntegralImage::Diagonal::kWithout, level.step);
  const bool some_invalid = !level.invalid.empty();
  if (some_invalid) workspace.invalid.assign(level.invalid(rows), IntegralImage::Diagonal::kWithout, 1);
  const double most_invalid = config.max_invalid_fraction * window.area();

  std::vector<unsigned char> usable(static_cast<std::size_t>((level.picture.cols - window.width) / level.step + 1), 1);
  std::vector<RowScan::Hit> row_hits;
  StripeHits found;
  for (int y = top; y <= last_top; y += level.step) {
    if (some_invalid) {
      for (std::size_t i = 0; i < usable.size(); ++i) {
        const cv::Rect box({static_cast<int>(i) * level.step, y - top}, window);
        usable[i] = static_cast<double>(workspace.invalid.sum_in(box)) <= most_invalid ? 1 : 0;
      }
    }
    found.windows += static_cast<double>(std::count(usable.begin(), usable.end(), static_cast<unsigned char>(1)));
    row_hits.clear();
    row_scan.scan(integral, y - top, usable, config.opencv_grid, workspace.row, row_hits);
    for (const RowScan::Hit& hit : row_hits) found.hits.push_back({{hit.index * level.step, y}, hit.score});
  }
  return found;
}

}  // namespace

CascadeDetector::CascadeDetector(HaarCascade cascade, const CascadeDetectorConfig& config) : cascade_(std::move(cascade)), config_(config) {
  throw_if_any(violations(config_));
  check_cascade(cascade_);
  if (config_.verify == DetectionVerifier::kContour && !cascade_.contour)
    throw InvalidArgument("verify", "contour", "the model holds no contours of known objects");
}

std::vector<LevelHits> CascadeDetector::scan(const SonarImage& image, int threads) const {
  check_sonar_image(image);
  return scan_prepared(prepared(image, config_.side), threads);
}

std::vector<LevelHits> CascadeDetector::scan_prepared(const SonarImage& seen, int threads) const {
  const std::vector<float> scales = scales_of(seen.intensity.size(), cascade_.window, config_);
  std::vector<Level> levels(scales.size());
  parallel_blocks(levels.size(), threads, [&](std::size_t l) { levels[l] = level_of(seen, scales[l]); });

  struct Task {
    std::size_t level;
    int top;
  };
  std::vector<Task> tasks;
  for (std::size_t l = 0; l < levels.size(); ++l) {
    Level& level = levels[l];
    if (level.picture.cols < cascade_.window.width || level.picture.rows < cascade_.window.height) continue;  // by rounding
    level.row_end = config_.opencv_grid ? opencv_row_end(levels.front().picture.size(), level.picture.size(), cascade_.window, level.step)
                                        : level.picture.rows + 1 - cascade_.window.height;
    for (int top = 0; top < level.row_end; top += kRowsPerStripe) tasks.push_back({l, top});
  }
  const bool tilted =
      std::any_of(cascade_.features.begin(), cascade_.features.end(), [](const HaarFeature& feature) { return feature.tilted; });
  std::vector<StripeHits> found(tasks.size());
  std::vector<std::unique_ptr<RowScan>> row_scans(levels.size());
  parallel_blocks(levels.size(), threads, [&](std::size_t l) {
    if (levels[l].row_end == 0) return;
    const cv::Mat one_row = levels[l].picture.rowRange(0, 1);
    row_scans[l] = std::make_unique<RowScan>(cascade_, IntegralImage(one_row, IntegralImage::Diagonal::kWithout, levels[l].step));
  });
  std::vector<Workspace> workspaces(static_cast<std::size_t>(threads));
  parallel_blocks(tasks.size(), threads, [&](std::size_t t, std::size_t thread) {
    found[t] =
        scan_stripe(cascade_.window, tilted, *row_scans[tasks[t].level], config_, levels[tasks[t].level], tasks[t].top, workspaces[thread]);
  });

  std::vector<LevelHits> result(levels.size());
  for (std::size_t l = 0; l < levels.size(); ++l) {
    result[l].picture = levels[l].picture;
    result[l].scale = static_cast<double>(levels[l].scale);
  }
  for (std::size_t t = 0; t < tasks.size(); ++t) {
    LevelHits& level = result[tasks[t].level];
    level.hits.insert(level.hits.end(), found[t].hits.begin(), found[t].hits.end());
    level.windows += found[t].windows;
  }
  return result;
}

std::vector<Detection> CascadeDetector::detect(const SonarImage& image, int threads) const {
  check_sonar_image(image);
  const SonarImage seen = prepared(image, config_.side);
  std::vector<WindowHit> hits;
  for (const LevelHits& level : scan_prepared(seen, threads)) {
    const auto scale = static_cast<float>(level.scale);
    const auto scaled = [&](int length) { return cvRound(static_cast<float>(length) * scale); };
    const cv::Size size(scaled(cascade_.window.width), scaled(cascade_.window.height));
    for (const LevelHits::Hit& hit : level.hits) hits.push_back({{{scaled(hit.top_left.x), scaled(hit.top_left.y)}, size}, hit.score});
  }
  std::vector<Detection> kept;
  const bool alike = config_.grouping == HitGrouping::kAlike;
  for (Detection detection : alike ? group_hits(hits, config_.min_neighbours, config_.similarity)
                                   : best_hits(hits, config_.min_neighbours, config_.max_overlap)) {
    detection.box &= cv::Rect({0, 0}, seen.intensity.size());  // scaled sizes are rounded
    if (config_.verify == DetectionVerifier::kContour) {
      detection.contour = contour_in(seen, detection.box);
      if (detection.contour->score < config_.min_contour_score) continue;  // (C-24)
    }
    if (config_.side == CascadeSide::kMirrored) detection.box.x = seen.intensity.cols - detection.box.x - detection.box.width;
    kept.push_back(detection);
  }
  return kept;
}

ContourVerdict CascadeDetector::contour_in(const SonarImage& seen, const cv::Rect& box) const {
  const std::optional<ContourSignature> signature = echo_signature(seen, box);
  if (!signature) return {};
  const double distance = contour_distance(signature->spectrum, *cascade_.contour);
  return {distance, contour_score(distance, *cascade_.contour)};
}

}  // namespace ssjs
