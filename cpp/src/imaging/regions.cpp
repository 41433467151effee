#include "ssjs/imaging/regions.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "ssjs/base/error.hpp"
#include "ssjs/imaging/disjoint_sets.hpp"
#include "ssjs/imaging/mask_components.hpp"

namespace ssjs {
namespace {

/// Sums over the pixels of a region, with coordinates relative to its first pixel. Second moments are sums of integers in floating
/// point: exact up to 2^53, and free of overflow in images of any length.
struct PixelSums {
  int x_first = 0;
  int y_first = 0;
  std::int64_t pixels = 0;
  std::int64_t x = 0;
  std::int64_t y = 0;
  double xx = 0;
  double xy = 0;
  double yy = 0;
  std::int64_t intensity = 0;
  int brightest = 0;
  int left = 0, right = 0, bottom = 0;  ///< of the image, right and bottom exclusive
};

/// A run of n pixels from x0 on adds closed sums: sum x = n x0 + n(n-1)/2, sum x^2 = n x0^2 + x0 n(n-1) + (n-1)n(2n-1)/6.
void add_run(PixelSums& sums, const MaskRun& run) {
  const std::int64_t n = run.end - run.first;
  const std::int64_t x0 = run.first - sums.x_first;
  const std::int64_t y = run.row - sums.y_first;
  const std::int64_t sum_x = n * x0 + n * (n - 1) / 2;
  sums.pixels += n;
  sums.x += sum_x;
  sums.y += n * y;
  const auto m = static_cast<double>(n);
  const auto x = static_cast<double>(x0);
  sums.xx += m * x * x + x * m * (m - 1) + (m - 1) * m * (2 * m - 1) / 6;
  sums.xy += static_cast<double>(y) * static_cast<double>(sum_x);
  sums.yy += static_cast<double>(y) * static_cast<double>(n * y);
  sums.left = std::min(sums.left, run.first);
  sums.right = std::max(sums.right, run.end);
  sums.bottom = run.row + 1;
}

template <class Pixel>
void add_intensity(PixelSums& sums, const cv::Mat& intensity, const MaskRun& run) {
  const Pixel* pixels = intensity.ptr<Pixel>(run.row);
  std::int64_t sum = 0;
  int brightest = 0;
  for (int x = run.first; x < run.end; ++x) {
    sum += pixels[x];
    brightest = std::max(brightest, static_cast<int>(pixels[x]));
  }
  sums.intensity += sum;
  sums.brightest = std::max(sums.brightest, brightest);
}

Region region_of(const PixelSums& sums, int label) {
  const auto n = static_cast<double>(sums.pixels);
  const auto x = static_cast<double>(sums.x);
  const auto y = static_cast<double>(sums.y);
  // central second moments of unit squares; differences of integers before the division, so that symmetry gives a true zero
  const double xx = (n * sums.xx - x * x) / (n * n) + 1.0 / 12.0;
  const double yy = (n * sums.yy - y * y) / (n * n) + 1.0 / 12.0;
  const double xy = (n * sums.xy - x * y) / (n * n);
  const double half_spread = std::hypot(0.5 * (xx - yy), xy);
  const double mean = 0.5 * (xx + yy);

  Region region;
  region.label = label;
  region.area_px = sums.pixels;
  region.centroid_px = {sums.x_first + x / n, sums.y_first + y / n};
  region.bounding_box = {sums.left, sums.y_first, sums.right - sums.left, sums.bottom - sums.y_first};
  region.orientation_rad = 0.5 * std::atan2(2.0 * xy, xx - yy);
  region.major_axis_px = 4.0 * std::sqrt(mean + half_spread);
  region.minor_axis_px = 4.0 * std::sqrt(std::max(mean - half_spread, 1.0 / 12.0));  // no shape is thinner than a pixel
  region.mean_intensity = static_cast<double>(sums.intensity) / n;
  region.max_intensity = sums.brightest;
  return region;
}

/// One pass from top to bottom which knows the lowest pixel so far of every column. A pixel is compared with its own column,
/// and the ends of a run with the columns towards the next run of the row: everything else follows from shorter distances, so that
/// every pixel is looked at three times at most, whatever the gap.
class NearRegions {
 public:
  NearRegions(const cv::Mat& labels, std::size_t regions, double gap_px)
      : labels_(labels), gap_px_(gap_px), lowest_(static_cast<std::size_t>(labels.cols)), objects_(regions) {}

  DisjointSets objects() && {
    for (int row = 0; row < labels_.rows; ++row) add_row(row);
    return std::move(objects_);
  }

 private:
  struct LowestPixel {
    int row = 0;
    int label = 0;  ///< 0: the column has been empty so far
  };

  void unite_if_near(int label, int other, double dx, double dy) {
    if (label != other && dx * dx + dy * dy < gap_px_ * gap_px_) objects_.unite(label - 1, other - 1);
  }

  void compare_with_column(int label, int row, int column, int dx) {
    const LowestPixel& lowest = lowest_[static_cast<std::size_t>(column)];
    if (lowest.label != 0) unite_if_near(label, lowest.label, dx, static_cast<double>(row) - lowest.row);
  }

  void add_row(int row) {
    const int* labels = labels_.ptr<int>(row);
    const int columns = labels_.cols;
    const double reach = std::min(gap_px_, static_cast<double>(columns));
    int last_end = 0;    // of the run before
    int last_label = 0;  // 0: no run yet
    for (int first = next_run(labels, 0, columns); first < columns;) {
      const int label = labels[first];
      for (int column = first - 1; column >= last_end && first - column < reach; --column)
        compare_with_column(label, row, column, first - column);
      if (last_label != 0) unite_if_near(label, last_label, static_cast<double>(first) - (last_end - 1), 0);
      int end = first;
      for (; end < columns && labels[end] == label; ++end) {
        compare_with_column(label, row, end, 0);
        lowest_[static_cast<std::size_t>(end)] = {row, label};
      }
      const int next = next_run(labels, end, columns);
      for (int column = end; column < next && column - (end - 1) < reach; ++column)
        compare_with_column(label, row, column, column - (end - 1));
      last_end = end;
      last_label = label;
      first = next;
    }
  }

  static int next_run(const int* labels, int column, int columns) {
    return static_cast<int>(std::find_if(labels + column, labels + columns, [](int label) { return label != 0; }) - labels);
  }

  const cv::Mat& labels_;
  double gap_px_;
  std::vector<LowestPixel> lowest_;
  DisjointSets objects_;
};

}  // namespace

void check_labelled_regions(const LabelledRegions& labelled) {
  if (labelled.labels.type() != CV_32SC1)
    throw InvalidArgument("labels", cv::typeToString(labelled.labels.type()), "must hold 32-bit integers (CV_32SC1)");
  for (std::size_t i = 0; i < labelled.regions.size(); ++i) {
    if (labelled.regions[i].label != static_cast<int>(i) + 1)
      throw InvalidArgument("regions[" + std::to_string(i) + "].label", labelled.regions[i].label, "must be the index plus one");
  }
  const int largest = static_cast<int>(labelled.regions.size());
  for (int row = 0; row < labelled.labels.rows; ++row) {
    const int* labels = labelled.labels.ptr<int>(row);
    int lowest = 0;
    int highest = 0;
    for (int x = 0; x < labelled.labels.cols; ++x) {
      lowest = std::min(lowest, labels[x]);
      highest = std::max(highest, labels[x]);
    }
    if (lowest < 0 || highest > largest)
      throw InvalidArgument("labels", lowest < 0 ? lowest : highest,
                            "must lie between 0 and the number of regions, " + std::to_string(largest));
  }
}

LabelledRegions find_regions(const cv::Mat& mask, const cv::Mat& intensity) {
  const MaskComponents components = foreground_components(mask);
  if (intensity.type() != CV_8UC1 && intensity.type() != CV_16UC1)
    throw InvalidArgument("intensity", cv::typeToString(intensity.type()), "must hold 8- or 16-bit unsigned integers, one channel");
  if (intensity.size() != mask.size())
    throw InvalidArgument("intensity", std::to_string(intensity.cols) + " x " + std::to_string(intensity.rows),
                          "must have the size of the mask, " + std::to_string(mask.cols) + " x " + std::to_string(mask.rows));

  LabelledRegions found{cv::Mat::zeros(mask.size(), CV_32S), {}};
  std::vector<PixelSums> sums(static_cast<std::size_t>(components.count));
  for (const MaskRun& run : components.runs) {
    PixelSums& of_region = sums[static_cast<std::size_t>(run.component)];
    if (of_region.pixels == 0) {
      of_region.x_first = of_region.left = run.first;
      of_region.y_first = run.row;
    }
    add_run(of_region, run);
    if (intensity.depth() == CV_8U) {
      add_intensity<unsigned char>(of_region, intensity, run);
    } else {
      add_intensity<unsigned short>(of_region, intensity, run);
    }
    int* labels = found.labels.ptr<int>(run.row);
    std::fill(labels + run.first, labels + run.end, run.component + 1);
  }
  found.regions.reserve(sums.size());
  for (const PixelSums& of_region : sums) found.regions.push_back(region_of(of_region, static_cast<int>(found.regions.size()) + 1));
  return found;
}

std::vector<RegionObject> group_regions(const LabelledRegions& labelled, double gap_px, CentroidWeighting weighting) {
  if (!(gap_px >= 0)) throw InvalidArgument("gap_px", gap_px, "must not be negative");
  check_labelled_regions(labelled);

  DisjointSets sets = NearRegions(labelled.labels, labelled.regions.size(), gap_px).objects();
  std::vector<int> object_of(labelled.regions.size(), 0);
  std::vector<RegionObject> objects;
  std::vector<double> weight;
  for (std::size_t i = 0; i < labelled.regions.size(); ++i) {
    const Region& region = labelled.regions[i];
    const auto first = static_cast<std::size_t>(sets.smallest(static_cast<int>(i)));
    if (first == i) {
      object_of[i] = static_cast<int>(objects.size());
      objects.push_back({{}, 0, {0, 0}, region.bounding_box});
      weight.push_back(0);
    }
    const auto k = static_cast<std::size_t>(object_of[first]);
    const double share = weighting == CentroidWeighting::kArea ? static_cast<double>(region.area_px) : 1.0;
    objects[k].labels.push_back(region.label);
    objects[k].area_px += region.area_px;
    objects[k].centroid_px += share * region.centroid_px;
    objects[k].bounding_box |= region.bounding_box;
    weight[k] += share;
  }
  for (std::size_t k = 0; k < objects.size(); ++k) objects[k].centroid_px /= weight[k];
  return objects;
}

}  // namespace ssjs
