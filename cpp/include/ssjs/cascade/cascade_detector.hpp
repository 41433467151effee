/// Objects in a whole picture: the cascade run over a pyramid of scaled pictures. Thesis 4.3.2, docs/math/cascade.md (C-14), (C-15),
/// (C-24).
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/cascade/detection_grouping.hpp"
#include "ssjs/cascade/haar_cascade.hpp"
#include "ssjs/imaging/sonar_image.hpp"

namespace ssjs {

/// Which side the picture is of. A shadow points away from the vehicle: on the other side the picture is mirrored first.
enum class CascadeSide { kAsTrained, kMirrored };

/// What looks at the grouped detections once more.
enum class DetectionVerifier { kNone, kContour };

/// How windows are brought together: OpenCV's groups of boxes that are alike (C-15), or the best of those that overlap (C-26).
enum class HitGrouping { kAlike, kBest };

struct CascadeDetectorConfig {
  double scale_factor = 1.1;
  int min_neighbours = 3;
  double similarity = 0.2;
  HitGrouping grouping = HitGrouping::kAlike;
  double max_overlap = 0.5;
  std::optional<int> min_width_px;
  std::optional<int> min_height_px;
  std::optional<int> max_width_px;
  std::optional<int> max_height_px;
  double max_invalid_fraction = 0.0;
  bool opencv_grid = true;
  CascadeSide side = CascadeSide::kAsTrained;
  DetectionVerifier verify = DetectionVerifier::kNone;
  double min_contour_score = 0.05;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("scale_factor", scale_factor, Rule{1.0, 4.0, true, false}, "each scale is so many times the one before it");
    v.field("min_neighbours", min_neighbours, Rule::not_negative(),
            "a detection is made of more windows than this; 0: every window is one");
    v.field("similarity", similarity, Rule::closed(0, 1), "sides of windows of one detection differ by at most this part of their length");
    v.choice("grouping", grouping, Choices<HitGrouping>{{"alike", HitGrouping::kAlike}, {"best", HitGrouping::kBest}},
             "alike: windows alike to alike are one detection, as in OpenCV; best: the best window takes those that it overlaps");
    v.field("max_overlap", max_overlap, Rule::closed(0, 1),
            "best: windows that share more than this part of the lesser one are one detection");
    v.field("min_width_px", min_width_px, Rule::at_least(1), "narrower boxes are not looked for");
    v.field("min_height_px", min_height_px, Rule::at_least(1), "lower boxes are not looked for");
    v.field("max_width_px", max_width_px, Rule::at_least(1), "wider boxes are not looked for");
    v.field("max_height_px", max_height_px, Rule::at_least(1), "higher boxes are not looked for");
    v.field("max_invalid_fraction", max_invalid_fraction, Rule::closed(0, 1), "windows with more invalid pixels are not looked at");
    v.field("opencv_grid", opencv_grid,
            "look at the windows OpenCV looks at: not at the neighbour of one that fails the first stage, nor always at the last row");
    v.choice("side", side, Choices<CascadeSide>{{"as_trained", CascadeSide::kAsTrained}, {"mirrored", CascadeSide::kMirrored}},
             "mirrored: shadows fall the other way than in training");
    v.choice("verify", verify, Choices<DetectionVerifier>{{"none", DetectionVerifier::kNone}, {"contour", DetectionVerifier::kContour}},
             "contour: compare the boundary of the echo in each box with those of the objects trained on");
    v.field("min_contour_score", min_contour_score, Rule::closed(0, 1),
            "contour: boxes that less than this part of known objects are as unlike the others as are dropped; 0: none is");
  }
};

/// One scale of the pyramid and the windows that passed there.
struct LevelHits {
  cv::Mat picture;  ///< the scaled picture in which the windows lie; mirrored if the side is
  double scale = 1;
  struct Hit {
    cv::Point top_left;  ///< in `picture`
    double score = 0;
  };
  std::vector<Hit> hits;  ///< by row, then by column
  double windows = 0;     ///< how many could have passed: of the grid, on valid ground, skipped or not
};

/// Without grouping, every window that passes is one that cv::CascadeClassifier of OpenCV 4 finds with minNeighbors 0, and the
/// other way round, as long as all pixels are valid and `opencv_grid` holds. The result does not depend on `threads`.
class CascadeDetector {
 public:
  /// Throws InvalidArgument if the cascade or the configuration contradicts itself, or if contours are to be verified and the model
  /// knows none.
  CascadeDetector(HaarCascade cascade, const CascadeDetectorConfig& config);

  [[nodiscard]] const HaarCascade& cascade() const { return cascade_; }

  /// Best score first. Pictures smaller than the smallest window hold nothing. A mirrored picture seen with `side` the other way
  /// round gives exactly the mirrored boxes.
  [[nodiscard]] std::vector<Detection> detect(const SonarImage& image, int threads = 1) const;

  /// Every window that passes, scale by scale, not grouped.
  [[nodiscard]] std::vector<LevelHits> scan(const SonarImage& image, int threads = 1) const;

 private:
  [[nodiscard]] std::vector<LevelHits> scan_prepared(const SonarImage& seen, int threads) const;
  [[nodiscard]] ContourVerdict contour_in(const SonarImage& seen, const cv::Rect& box) const;

  HaarCascade cascade_;
  CascadeDetectorConfig config_;
};

}  // namespace ssjs
