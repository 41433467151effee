/// A frame as taken to what is met again: lens, light, regions of interest, keypoints. Thesis 4.4.1, docs/math/optical.md
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/optical/frame_preprocess.hpp"
#include "ssjs/optical/keypoints.hpp"
#include "ssjs/optical/lens.hpp"
#include "ssjs/optical/matching.hpp"
#include "ssjs/optical/region_of_interest.hpp"

namespace ssjs {

enum class KeypointPlaces {
  kRegions,  ///< in the regions of interest; in the whole frame where there are none
  kFrame,    ///< in the whole frame
};

/// Frames that no keypoint of which would be worth anything.
struct FrameLimits {
  double darkest_level = 6.0;
  double least_level_sigma = 1.5;
  double least_sharpness = 0.002;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("darkest_level", darkest_level, Rule::closed(0, 255), "a frame of a lower mean level is dark and left out");
    v.field("least_level_sigma", least_level_sigma, Rule::not_negative(), "one whose levels vary by less is blank");
    v.field("least_sharpness", least_sharpness, Rule::not_negative(),
            "one whose Laplacian has less than this part of the variance of the levels is blurred");
  }
};

struct FrameReaderConfig {
  FrameConfig light;
  FrameLimits limits;
  RegionOfInterestConfig regions;
  KeypointConfig keypoints;
  KeypointPlaces places = KeypointPlaces::kRegions;
  template <class Visitor>
  void visit(Visitor& v) {
    v.choice("places", places, Choices<KeypointPlaces>{{"regions", KeypointPlaces::kRegions}, {"frame", KeypointPlaces::kFrame}},
             "regions: keypoints in the regions of interest, in the whole frame where there are none; frame: always in the whole frame");
    v.section("light", light, "even light");
    v.section("limits", limits, "frames that are left out");
    v.section("regions", regions, "regions of interest");
    v.section("keypoints", keypoints, "keypoints");
  }
};

/// What one frame holds. Pixels are those of the frame with its lens corrected.
struct FrameFeatures {
  cv::Size size;
  FrameQuality quality;
  std::optional<std::string> left_out;  ///< why it holds nothing: "dark: mean level 2.1 of 255", ...
  std::vector<Region> regions;
  Keypoints keypoints;
  std::vector<int> region_of;  ///< by keypoint: label of its region, 0 outside all of them
};

/// The same features without a lens that was not known when the frame was read. Regions stay as they were seen.
[[nodiscard]] FrameFeatures straightened(FrameFeatures seen, const CameraCalibration& lens);

class FrameReader {
 public:
  /// Throws InvalidArgument listing every violation of the configuration, or naming what is wrong with the calibration.
  explicit FrameReader(const FrameReaderConfig& config, const std::optional<CameraCalibration>& calibration = std::nullopt);

  /// frame: CV_8U, one channel, or three in the order red, green, blue; of the calibrated size where there is a calibration.
  [[nodiscard]] FrameFeatures read(const cv::Mat& frame) const;
  /// The frame without its lens.
  [[nodiscard]] cv::Mat corrected(const cv::Mat& frame) const;
  /// What keypoints are looked for in.
  [[nodiscard]] cv::Mat lit(const cv::Mat& frame) const;

 private:
  FrameReaderConfig config_;
  std::optional<Undistortion> undistortion_;
};

/// The motion between two frames that were read alike; none when they share nothing. (V-12..V-14)
[[nodiscard]] std::optional<Registration> register_frames(const FrameFeatures& first, const FrameFeatures& second,
                                                          const MatchingConfig& config, std::uint64_t seed = 1);

}  // namespace ssjs
