#include "ssjs/imaging/segmentation.hpp"

#include "ssjs/base/error.hpp"
#include "ssjs/imaging/histogram.hpp"
#include "ssjs/imaging/morphology.hpp"

namespace ssjs {
namespace {

std::int64_t valid_px(const SonarImage& image) {
  return image.valid.empty() ? static_cast<std::int64_t>(image.intensity.total()) : cv::countNonZero(image.valid);
}

/// Finds the threshold, notes it in the result and returns the foreground.
cv::Mat apply_threshold(const SonarImage& image, const SegmentationConfig& config, SegmentationResult& result) {
  switch (config.method) {
    case ThresholdMethod::kImprovedOtsu:
      result.improved_otsu = improved_otsu(image, config.improved_otsu);
      if (result.improved_otsu) result.threshold = result.improved_otsu->threshold;
      break;
    case ThresholdMethod::kOtsu:
      result.threshold = otsu_threshold(histogram(image));
      break;
    case ThresholdMethod::kIterative:
      result.threshold = iterative_threshold(histogram(image));
      break;
    case ThresholdMethod::kMaximumEntropy:
      result.threshold = maximum_entropy_threshold(histogram(image));
      break;
    case ThresholdMethod::kLocal:
      return local_foreground(image, config.local);
  }
  if (!result.threshold) return cv::Mat::zeros(image.intensity.size(), CV_8U);
  return foreground(image, *result.threshold);
}

void require_odd(const char* key, int value, std::vector<std::string>& violations) {
  if (value % 2 == 0) violations.push_back(std::string(key) + " = " + std::to_string(value) + ": must be odd");
}

}  // namespace

std::vector<std::string> SegmentationConfig::violations() const {
  std::vector<std::string> all = ssjs::violations(*this);
  require_odd("filter.median_px", filter.median_px, all);
  require_odd("gain.window_px", gain.window_px, all);
  require_odd("local.window_px", local.window_px, all);
  return all;
}

SegmentationConfig segmentation_preset(SegmentationPreset preset) {
  SegmentationConfig config;
  switch (preset) {
    case SegmentationPreset::kAutomatic:
      break;
    case SegmentationPreset::kSideScanHigh:
      config.improved_otsu = {30, 300, 0.33};
      break;
    case SegmentationPreset::kSideScanLow:
      config.improved_otsu = {15, 100, 0.1255};
      break;
    case SegmentationPreset::kForwardLooking:
      config.improved_otsu = {40, 600, 0.13};
      config.dilations = 2;
      break;
    case SegmentationPreset::kBest:
      config.filter.kind = SpeckleFilter::kGaussian;
      config.filter.sigma_px = 2.5;
      config.power_law.enabled = false;
      config.method = ThresholdMethod::kLocal;
      config.local = {51, 16};
      config.smallest_area_px = 30;
      break;
  }
  return config;
}

SegmentationResult segment(const SonarImage& image, const SegmentationConfig& config, KeepSteps keep) {
  check_sonar_image(image);
  throw_if_any(config.violations());
  SegmentationResult result;
  result.smallest_area_px = config.smallest_area_px.value_or(config.improved_otsu.spot_px.value_or(automatic_spot_px(valid_px(image))));
  if (keep == KeepSteps::kYes) result.steps.emplace();
  const auto note = [&](cv::Mat SegmentationSteps::*step, const cv::Mat& picture) {
    if (result.steps) (*result.steps).*step = picture;
  };

  SonarImage picture = image;
  if (config.filter.kind != SpeckleFilter::kNone) picture.intensity = smooth_speckle(picture, config.filter);
  note(&SegmentationSteps::filtered, picture.intensity);
  if (config.gain.kind != GainNormalisation::kNone) picture.intensity = normalise_gain(picture, config.gain);
  note(&SegmentationSteps::normalised, picture.intensity);
  picture.intensity = power_law(picture, config.power_law);
  note(&SegmentationSteps::contrasted, picture.intensity);

  result.mask = apply_threshold(picture, config, result);
  note(&SegmentationSteps::thresholded, result.mask);
  picture.intensity.release();

  result.mask = remove_small_components(result.mask, result.smallest_area_px);  // Algorithm 2
  note(&SegmentationSteps::cleaned, result.mask);
  result.mask = bridge(result.mask);
  note(&SegmentationSteps::bridged, result.mask);
  result.mask = dilate(result.mask, config.dilations);
  note(&SegmentationSteps::dilated, result.mask);
  result.mask = fill_holes(result.mask);
  if (!image.valid.empty()) result.mask.setTo(0, image.valid == 0);

  result.regions = find_regions(result.mask, image.intensity);
  result.objects = group_regions(result.regions, config.object_gap_px, config.object_centroid);
  return result;
}

}  // namespace ssjs
