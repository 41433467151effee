#include "ssjs/imaging/highlight_shadow.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>

#include "ssjs/base/error.hpp"
#include "ssjs/imaging/histogram.hpp"
#include "ssjs/imaging/mask_components.hpp"
#include "ssjs/imaging/morphology.hpp"
#include "ssjs/imaging/three_class_otsu.hpp"

namespace ssjs {
namespace {

void check(const SonarImage& image, int nadir_column, const HighlightShadowConfig& config) {
  check_sonar_image(image);
  throw_if_any(violations(config));
  if (nadir_column < 0 || nadir_column > image.intensity.cols)
    throw InvalidArgument("nadir_column", nadir_column,
                          "must lie between 0 and the number of columns, " + std::to_string(image.intensity.cols));
  if (config.median_px % 2 == 0) throw InvalidArgument("median_px", config.median_px, "must be odd");
  if (config.shadow_grey > config.highlight_grey)
    throw InvalidArgument("shadow_grey", config.shadow_grey, "must not be above highlight_grey");
  if (config.shadow_quantile > config.highlight_quantile)
    throw InvalidArgument("shadow_quantile", config.shadow_quantile, "must not be above highlight_quantile");
}

/// The lowest level at or below which this part of the pixels lies; at least one pixel.
int quantile(const Histogram& levels, double part, std::int64_t pixels) {
  std::int64_t below = 0;
  int level = 0;
  for (; level < levels.levels(); ++level) {
    below += levels[level];
    if (static_cast<double>(below) >= part * static_cast<double>(pixels)) break;
  }
  return level;
}

std::int64_t pixels_of(const Histogram& levels) {
  std::int64_t pixels = 0;
  for (const std::int64_t count : levels.counts) pixels += count;
  return pixels;
}

/// Invalid pixels would drag their neighbours along: they take the median level of the valid ones.
SonarImage without_speckle(const SonarImage& image, int median_px) {
  if (median_px == 1) return image;
  SonarImage smooth{image.intensity.clone(), image.valid};
  if (!image.valid.empty()) {
    const Histogram levels = histogram(image);
    smooth.intensity.setTo(quantile(levels, 0.5, pixels_of(levels)), image.valid == 0);
  }
  cv::medianBlur(smooth.intensity, smooth.intensity, median_px);
  return smooth;
}

///
std::optional<EchoThresholds> thresholds_of(const SonarImage& image, const HighlightShadowConfig& config) {
  if (config.levels == EchoLevels::kGrey) return EchoThresholds{config.shadow_grey, config.highlight_grey};
  const Histogram levels = histogram(image);
  if (config.levels == EchoLevels::kOtsu) {
    const std::optional<ThreeClasses> classes = three_class_otsu(levels);
    if (!classes) return std::nullopt;
    return EchoThresholds{classes->lower + 1, classes->upper};
  }
  const std::int64_t pixels = pixels_of(levels);
  return EchoThresholds{quantile(levels, config.shadow_quantile, pixels), quantile(levels, config.highlight_quantile, pixels)};
}

/// One side of the nadir, its columns in the order of range.
struct Swath {
  SonarSide side;
  int nadir_column;

  [[nodiscard]] cv::Mat of(const cv::Mat& image) const {
    if (side == SonarSide::kStarboard) return image.colRange(nadir_column, image.cols);
    cv::Mat mirrored(image.rows, nadir_column, image.type());
    if (!mirrored.empty()) cv::flip(image.colRange(0, nadir_column), mirrored, 1);
    return mirrored;
  }
  /// Puts what of() gave back to its place.
  void into(cv::Mat& image, const cv::Mat& swath) const {
    if (swath.empty()) return;
    if (side == SonarSide::kStarboard) {
      swath.copyTo(image.colRange(nadir_column, image.cols));
    } else {
      cv::Mat place = image.colRange(0, nadir_column);
      cv::flip(swath, place, 1);
    }
  }
  [[nodiscard]] double image_x(double x) const { return side == SonarSide::kStarboard ? nadir_column + x : nadir_column - 1 - x; }
  [[nodiscard]] cv::Rect image_box(const cv::Rect& box) const {
    return {side == SonarSide::kStarboard ? nadir_column + box.x : nadir_column - box.x - box.width, box.y, box.width, box.height};
  }
};

/// Candidates of one kind on one swath: thresholded pixels and the magnified components they make.
struct Candidates {
  cv::Mat pixels;
  cv::Mat magnified;
  MaskComponents components;

  Candidates(const cv::Mat& thresholded, int dilations, int smallest_area_px)
      : pixels(thresholded),
        magnified(remove_small_components(dilate(thresholded, dilations), smallest_area_px)),
        components(foreground_components(magnified)) {}
};

/// Of the thresholded pixels inside one magnified component.
struct Extent {
  std::int64_t area_px = 0;
  double x = 0;
  double y = 0;
  cv::Rect box;
};

std::vector<Extent> extents(const Candidates& candidates) {
  std::vector<Extent> found(static_cast<std::size_t>(candidates.components.count));
  for (const MaskRun& run : candidates.components.runs) {
    Extent& extent = found[static_cast<std::size_t>(run.component)];
    const unsigned char* pixels = candidates.pixels.ptr<unsigned char>(run.row);
    for (int x = run.first; x < run.end; ++x) {
      if (pixels[x] == 0) continue;
      ++extent.area_px;
      extent.x += x;
      extent.y += run.row;
      extent.box |= cv::Rect(x, run.row, 1, 1);
    }
  }
  return found;
}

/// Where one shadow touches one highlight.
struct Contact {
  int rows = 0;
  int start = 0;  ///< of the longest shadow
  int end = 0;
  bool is_cut = false;
};

/// The thresholded shadow in a magnified run.
void measure(Contact& contact, const MaskRun& shadow, const cv::Mat& dark, const cv::Mat& valid) {
  ++contact.rows;
  const unsigned char* pixels = dark.ptr<unsigned char>(shadow.row);
  int start = shadow.first;
  int end = shadow.end;
  while (start < end && pixels[start] == 0) ++start;
  while (end > start && pixels[end - 1] == 0) --end;
  if (end - start <= contact.end - contact.start) return;
  contact.start = start;
  contact.end = end;
  contact.is_cut = end == dark.cols || (!valid.empty() && valid.at<unsigned char>(shadow.row, end) == 0);
}

/// Keys are (highlight, shadow). In a row the shadow of a highlight is the first that ends beyond it; the two touch when it
/// begins beyond the highlight's beginning, and no later than right after its end.
std::map<std::pair<int, int>, Contact> contacts(const Candidates& highlights, const Candidates& shadows, const cv::Mat& valid) {
  std::map<std::pair<int, int>, Contact> found;
  const std::vector<MaskRun>& dark = shadows.components.runs;
  std::size_t behind = 0;
  for (const MaskRun& bright : highlights.components.runs) {
    while (behind < dark.size() && (dark[behind].row < bright.row || (dark[behind].row == bright.row && dark[behind].end <= bright.end)))
      ++behind;
    if (behind == dark.size()) break;
    const MaskRun& shadow = dark[behind];
    if (shadow.row == bright.row && shadow.first > bright.first && shadow.first <= bright.end)
      measure(found[{bright.component, shadow.component}], shadow, shadows.pixels, valid);
  }
  return found;
}

void add_objects(HighlightShadows& result, const Swath& swath, const Candidates& highlights, const Candidates& shadows,
                 const cv::Mat& valid, int smallest_contact_px) {
  const std::vector<Extent> bright = extents(highlights);
  const std::vector<Extent> dark = extents(shadows);
  const auto touching = contacts(highlights, shadows, valid);
  for (auto first = touching.begin(); first != touching.end();) {
    auto best = first;
    auto next = first;
    for (; next != touching.end() && next->first.first == first->first.first; ++next) {
      if (next->second.rows > best->second.rows) best = next;
    }
    first = next;
    const Contact& contact = best->second;
    if (contact.rows < smallest_contact_px || contact.end == contact.start) continue;
    const Extent& highlight = bright[static_cast<std::size_t>(best->first.first)];
    const Extent& shadow = dark[static_cast<std::size_t>(best->first.second)];
    const auto area = static_cast<double>(highlight.area_px);
    result.objects.push_back({swath.side,
                              {swath.image_x(highlight.x / area), highlight.y / area},
                              swath.image_box(highlight.box),
                              swath.image_box(shadow.box),
                              highlight.area_px,
                              shadow.area_px,
                              contact.rows,
                              static_cast<double>(contact.start),
                              static_cast<double>(contact.end),
                              contact.is_cut});
  }
}

}  // namespace

HighlightShadows highlight_shadow(const SonarImage& image, int nadir_column, const HighlightShadowConfig& config) {
  check(image, nadir_column, config);
  HighlightShadows result;
  result.highlights = cv::Mat::zeros(image.intensity.size(), CV_8U);
  result.shadows = cv::Mat::zeros(image.intensity.size(), CV_8U);
  if (!intensity_range(image)) return result;

  const SonarImage smooth = without_speckle(in_8_bits(image), config.median_px);
  result.thresholds = thresholds_of(smooth, config);
  if (!result.thresholds) return result;
  cv::Mat bright = smooth.intensity > result.thresholds->highlight_above;
  cv::Mat dark = smooth.intensity < result.thresholds->shadow_below;
  if (!image.valid.empty()) {
    bright.setTo(0, image.valid == 0);
    dark.setTo(0, image.valid == 0);
  }

  for (const SonarSide side : {SonarSide::kPort, SonarSide::kStarboard}) {
    const Swath swath{side, nadir_column};
    const Candidates highlights(swath.of(bright), config.highlight_dilations, config.smallest_highlight_px);
    const Candidates shadows(swath.of(dark), config.shadow_dilations, config.smallest_shadow_px);
    add_objects(result, swath, highlights, shadows, image.valid.empty() ? cv::Mat() : swath.of(image.valid), config.smallest_contact_px);
    swath.into(result.highlights, highlights.magnified);
    swath.into(result.shadows, shadows.magnified);
  }
  return result;
}

}  // namespace ssjs
