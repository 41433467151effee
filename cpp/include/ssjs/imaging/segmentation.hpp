/// From a sonar picture to the centroids of its objects. [yuan2016] section 3, docs/math/segmentation.md
/// speckle filter -> gain -> power law -> threshold -> Algorithm 2 (small components away, bridge, dilate, fill) -> regions -> objects
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/imaging/improved_otsu.hpp"
#include "ssjs/imaging/preprocess.hpp"
#include "ssjs/imaging/regions.hpp"
#include "ssjs/imaging/sonar_image.hpp"
#include "ssjs/imaging/speckle_filter.hpp"
#include "ssjs/imaging/threshold.hpp"

namespace ssjs {

enum class ThresholdMethod { kImprovedOtsu, kOtsu, kLocal, kIterative, kMaximumEntropy };

struct SegmentationConfig {
  SpeckleFilterConfig filter;
  GainConfig gain;
  PowerLawConfig power_law;
  ThresholdMethod method = ThresholdMethod::kImprovedOtsu;
  ImprovedOtsuConfig improved_otsu;
  LocalThresholdConfig local;
  std::optional<int> smallest_area_px;
  int dilations = 1;
  double object_gap_px = 20;
  CentroidWeighting object_centroid = CentroidWeighting::kRegions;
  template <class Visitor>
  void visit(Visitor& v) {
    v.section("filter", filter, "against speckle, on the raw image");
    v.section("gain", gain, "against uneven gain");
    v.section("power_law", power_law, "draws bright levels apart");
    v.choice("method", method,
             Choices<ThresholdMethod>{{"improved-otsu", ThresholdMethod::kImprovedOtsu},
                                      {"otsu", ThresholdMethod::kOtsu},
                                      {"local", ThresholdMethod::kLocal},
                                      {"iterative", ThresholdMethod::kIterative},
                                      {"max-entropy", ThresholdMethod::kMaximumEntropy}},
             "what separates foreground from background");
    v.section("improved_otsu", improved_otsu, "when spots ask for a second pass");
    v.section("local", local, "the local mean");
    v.field("smallest_area_px", smallest_area_px, Rule::at_least(1), "smaller components are removed; unset: improved_otsu.spot_px");
    v.field("dilations", dilations, Rule::closed(0, 50), "by a square of 3 pixels, to join what is nearly joined");
    v.field("object_gap_px", object_gap_px, Rule::not_negative(), "regions nearer to each other than this are one object");
    v.choice("object_centroid", object_centroid, kCentroidWeightings, "of an object of several regions: their plain or area-weighted mean");
  }

  /// Every violation, rules beyond single fields included; empty when valid.
  [[nodiscard]] std::vector<std::string> violations() const;
};

/// The paper's settings for its three pictures, automatic ones that follow the size of the image, and the chain that found most with
/// the least false area on real side-scan tiles (docs/segmentation.md), which is not the paper's.
enum class SegmentationPreset { kAutomatic, kSideScanHigh, kSideScanLow, kForwardLooking, kBest };

inline const Choices<SegmentationPreset> kSegmentationPresets = {{"auto", SegmentationPreset::kAutomatic},
                                                                 {"sss-high", SegmentationPreset::kSideScanHigh},
                                                                 {"sss-low", SegmentationPreset::kSideScanLow},
                                                                 {"fls", SegmentationPreset::kForwardLooking},
                                                                 {"best", SegmentationPreset::kBest}};

[[nodiscard]] SegmentationConfig segmentation_preset(SegmentationPreset preset);

/// What the stages hand on, all of the image's size.
struct SegmentationSteps {
  cv::Mat filtered;     ///< depth of the image
  cv::Mat normalised;   ///< 8 bits, after the gain; without one as filtered, in the depth of the image
  cv::Mat contrasted;   ///< 8 bits, after the power law: what the threshold is found on
  cv::Mat thresholded;  ///< masks from here on
  cv::Mat cleaned;      ///< without small components
  cv::Mat bridged;
  cv::Mat dilated;
};

enum class KeepSteps { kNo, kYes };

struct SegmentationResult {
  std::optional<int> threshold;               ///< on 0..255; none for images of one level, and with the local method
  std::optional<ImprovedOtsu> improved_otsu;  ///< first threshold, spots, whether the second pass fired; with that method alone
  int smallest_area_px = 0;
  cv::Mat mask;  ///< 255 where foreground, 0 at invalid pixels
  LabelledRegions regions;
  std::vector<RegionObject> objects;
  std::optional<SegmentationSteps> steps;
};

/// Intensities of regions are those of the image as given. Pixels of images of one level are all background.
[[nodiscard]] SegmentationResult segment(const SonarImage& image, const SegmentationConfig& config, KeepSteps keep = KeepSteps::kNo);

}  // namespace ssjs
