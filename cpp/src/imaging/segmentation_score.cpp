#include "ssjs/imaging/segmentation_score.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <tuple>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

std::optional<double> ratio(std::int64_t part, std::int64_t whole) {
  if (whole == 0) return std::nullopt;
  return static_cast<double>(part) / static_cast<double>(whole);
}

void check_size(const char* what, const cv::Size& size, const cv::Size& expected) {
  if (size == expected) return;
  throw InvalidArgument(what, std::to_string(size.width) + " x " + std::to_string(size.height),
                        "must have the size of the truth, " + std::to_string(expected.width) + " x " + std::to_string(expected.height));
}

cv::Mat pixels_of(const GroundTruth& truth) {
  cv::Mat mask = cv::Mat::zeros(truth.size, CV_8U);
  for (const TruthObject& object : truth.objects) {
    for (const MaskRun& run : object.runs) {
      unsigned char* row = mask.ptr<unsigned char>(run.row);
      std::fill(row + run.first, row + run.end, static_cast<unsigned char>(255));
    }
  }
  return mask;
}

/// A region's centroid as a pixel, to be found by row.
struct CentroidPixel {
  int row = 0;
  int column = 0;
  int label = 0;
  bool operator<(const CentroidPixel& other) const { return std::tie(row, column, label) < std::tie(other.row, other.column, other.label); }
};

std::vector<CentroidPixel> centroid_pixels(const std::vector<Region>& regions) {
  std::vector<CentroidPixel> pixels;
  pixels.reserve(regions.size());
  for (const Region& region : regions) {
    pixels.push_back(
        {static_cast<int>(std::floor(region.centroid_px.y + 0.5)), static_cast<int>(std::floor(region.centroid_px.x + 0.5)), region.label});
  }
  std::sort(pixels.begin(), pixels.end());
  return pixels;
}

/// Pixels that each region shares with the object, by label.
std::map<int, std::int64_t> shared_px(const TruthObject& object, const cv::Mat& labels) {
  std::map<int, std::int64_t> shared;
  for (const MaskRun& run : object.runs) {
    const int* row = labels.ptr<int>(run.row);
    for (int x = run.first; x < run.end;) {
      const int first = x;
      while (x < run.end && row[x] == row[first]) ++x;
      if (row[first] != 0) shared[row[first]] += x - first;
    }
  }
  return shared;
}

///
std::vector<int> labels_of(const TruthObject& object, const std::map<int, std::int64_t>& shared, const std::vector<Region>& regions,
                           const std::vector<CentroidPixel>& centroids, RegionMatch match) {
  std::vector<int> labels;
  if (match == RegionMatch::kMajority) {
    for (const auto& [label, pixels] : shared) {
      if (2 * pixels > regions[static_cast<std::size_t>(label) - 1].area_px) labels.push_back(label);
    }
    return labels;
  }
  for (const MaskRun& run : object.runs) {
    auto found = std::lower_bound(centroids.begin(), centroids.end(), CentroidPixel{run.row, run.first, 0});
    for (; found != centroids.end() && found->row == run.row && found->column < run.end; ++found) labels.push_back(found->label);
  }
  std::sort(labels.begin(), labels.end());
  return labels;
}

/// Of pixels, or of bounding boxes where the truth is no more than a box.
double best_iou(const TruthObject& object, bool is_box, const std::map<int, std::int64_t>& shared, const std::vector<Region>& regions) {
  double best = 0;
  const auto consider = [&](double intersection, double a, double b) { best = std::max(best, intersection / (a + b - intersection)); };
  const auto area = [](const cv::Rect& box) { return static_cast<double>(box.width) * box.height; };
  if (is_box) {
    for (const Region& region : regions)
      consider(area(region.bounding_box & object.bounding_box), area(region.bounding_box), area(object.bounding_box));
  } else {
    for (const auto& [label, pixels] : shared) {
      consider(static_cast<double>(pixels), static_cast<double>(regions[static_cast<std::size_t>(label) - 1].area_px),
               static_cast<double>(object.area_px));
    }
  }
  return best;
}

///
std::optional<double> centroid_error_px(const TruthObject& object, const std::vector<int>& labels, const std::vector<Region>& regions,
                                        CentroidWeighting weighting) {
  if (labels.empty()) return std::nullopt;
  cv::Point2d sum{0, 0};
  double weight = 0;
  for (const int label : labels) {
    const Region& region = regions[static_cast<std::size_t>(label) - 1];
    const double share = weighting == CentroidWeighting::kArea ? static_cast<double>(region.area_px) : 1.0;
    sum += share * region.centroid_px;
    weight += share;
  }
  const cv::Point2d error = sum / weight - object.centroid_px;
  return std::hypot(error.x, error.y);
}

/// Candidates that share no pixel with an object, nor with a detected region.
std::int64_t untouched_components(const cv::Mat& pool, const cv::Mat& on_object, const cv::Mat& labels) {
  const MaskComponents candidates = foreground_components(pool);
  std::vector<bool> touched(static_cast<std::size_t>(candidates.count), false);
  for (const MaskRun& run : candidates.runs) {
    const unsigned char* objects = on_object.ptr<unsigned char>(run.row);
    const int* detected = labels.ptr<int>(run.row);
    for (int x = run.first; x < run.end; ++x) {
      if (objects[x] != 0 || detected[x] != 0) touched[static_cast<std::size_t>(run.component)] = true;
    }
  }
  return std::count(touched.begin(), touched.end(), false);
}

///
void add_pixels(SegmentationScore& score, const cv::Mat& labels, const cv::Mat& on_object, bool is_boxes) {
  std::int64_t truth_px = 0;
  for (int row = 0; row < labels.rows; ++row) {
    const int* detected = labels.ptr<int>(row);
    const unsigned char* objects = on_object.ptr<unsigned char>(row);
    for (int x = 0; x < labels.cols; ++x) {
      const bool is_detected = detected[x] != 0;
      const bool is_object = objects[x] != 0;
      truth_px += is_object ? 1 : 0;
      score.intersection_px += is_detected && is_object ? 1 : 0;
      score.union_px += is_detected || is_object ? 1 : 0;
      score.false_area_px += is_detected && !is_object ? 1 : 0;
      score.background_px += is_object ? 0 : 1;
    }
  }
  if (is_boxes) return;
  score.mask_iou = ratio(score.intersection_px, score.union_px);
  score.pixel_recall = ratio(score.intersection_px, truth_px);
}

}  // namespace

std::optional<double> ConfusionMatrix::false_positive_rate() const {
  if (!true_negatives) return std::nullopt;
  return ratio(false_positives, false_positives + *true_negatives);
}

std::optional<double> ConfusionMatrix::precision() const { return ratio(true_positives, true_positives + false_positives); }

std::optional<double> ConfusionMatrix::recall() const { return ratio(true_positives, true_positives + false_negatives); }

ConfusionMatrix& ConfusionMatrix::operator+=(const ConfusionMatrix& other) {
  true_positives += other.true_positives;
  false_positives += other.false_positives;
  false_negatives += other.false_negatives;
  true_negatives = true_negatives && other.true_negatives ? std::optional(*true_negatives + *other.true_negatives) : std::nullopt;
  return *this;
}

std::optional<double> SegmentationScore::hit_rate() const { return ratio(hits, static_cast<std::int64_t>(objects.size())); }

std::optional<double> SegmentationScore::false_area_fraction() const { return ratio(false_area_px, background_px); }

SegmentationScore segmentation_score(const LabelledRegions& detected, const GroundTruth& truth, const cv::Mat& pool,
                                     const SegmentationScoreConfig& config) {
  throw_if_any(violations(config));
  check_labelled_regions(detected);
  check_size("labels", detected.labels.size(), truth.size);
  if (!pool.empty()) check_size("pool", pool.size(), truth.size);

  SegmentationScore score;
  const cv::Mat on_object = pixels_of(truth);
  add_pixels(score, detected.labels, on_object, truth.is_boxes);

  const std::vector<CentroidPixel> centroids = centroid_pixels(detected.regions);
  std::vector<bool> is_objects(detected.regions.size(), false);
  double error_sum_px = 0;
  std::int64_t found = 0;
  for (const TruthObject& object : truth.objects) {
    const std::map<int, std::int64_t> shared = shared_px(object, detected.labels);
    ObjectScore of_object;
    of_object.labels = labels_of(object, shared, detected.regions, centroids, config.match);
    of_object.best_iou = best_iou(object, truth.is_boxes, shared, detected.regions);
    of_object.centroid_error_px = centroid_error_px(object, of_object.labels, detected.regions, config.weighting);
    for (const int label : of_object.labels) is_objects[static_cast<std::size_t>(label) - 1] = true;
    if (of_object.centroid_error_px) {
      ++found;
      error_sum_px += *of_object.centroid_error_px;
    }
    if (of_object.best_iou > config.hit_iou) ++score.hits;
    score.objects.push_back(std::move(of_object));
  }
  if (found > 0) score.mean_centroid_error_px = error_sum_px / static_cast<double>(found);

  score.confusion.true_positives = std::count(is_objects.begin(), is_objects.end(), true);
  score.confusion.false_positives = std::count(is_objects.begin(), is_objects.end(), false);
  score.confusion.false_negatives = static_cast<std::int64_t>(truth.objects.size()) - found;
  if (!pool.empty()) score.confusion.true_negatives = untouched_components(pool, on_object, detected.labels);
  return score;
}

}  // namespace ssjs
