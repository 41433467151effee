#include "ssjs/cascade/haar_feature.hpp"

#include <cmath>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

constexpr int kMostDarkToBright = 8;  // thesis 4.3.1: the proportion that told objects from seafloor best

/// The places and sizes of a feature's smallest cell, in the order in which features are numbered.
template <class Visit>
void for_each_cell(cv::Size window, const Visit& visit) {
  for (int x = 0; x < window.width; ++x)
    for (int y = 0; y < window.height; ++y)
      for (int dx = 1; dx <= window.width; ++dx)
        for (int dy = 1; dy <= window.height; ++dy) visit(x, y, dx, dy);
}

class Collector {
 public:
  explicit Collector(cv::Size window) : window_(window) {}

  /// Keeps the feature if its first rectangle, the union of all, lies in the window.
  void add(bool tilted, const WeightedRect& whole, const WeightedRect& part, const WeightedRect& second_part = {}) {
    if (inside(whole.rect, tilted)) features_.push_back({{whole, part, second_part}, tilted});
  }
  [[nodiscard]] bool inside(const cv::Rect& rect, bool tilted) const {
    if (!tilted) return rect.x + rect.width <= window_.width && rect.y + rect.height <= window_.height;
    return rect.x + rect.width <= window_.width && rect.y + rect.width + rect.height <= window_.height && rect.x - rect.height >= 0;
  }
  std::vector<HaarFeature> take() { return std::move(features_); }

 private:
  cv::Size window_;
  std::vector<HaarFeature> features_;
};

void add_tilted(Collector& collect, int x, int y, int dx, int dy) {
  collect.add(true, {{x, y, dx * 2, dy}, -1}, {{x, y, dx, dy}, 2});
  collect.add(true, {{x, y, dx, dy * 2}, -1}, {{x, y, dx, dy}, 2});
  collect.add(true, {{x, y, dx * 3, dy}, -1}, {{x + dx, y + dx, dx, dy}, 3});
  collect.add(true, {{x, y, dx, dy * 3}, -1}, {{x - dy, y + dy, dx, dy}, 3});
  collect.add(true, {{x, y, dx * 4, dy}, -1}, {{x + dx, y + dx, dx * 2, dy}, 2});
  collect.add(true, {{x, y, dx, dy * 4}, -1}, {{x - dy, y + dy, dx, dy * 2}, 2});
}

/// [lienhart2002], numbered as in OpenCV's trainer.
void add_classic(FeatureSet set, cv::Size window, Collector& collect) {
  const bool core = set == FeatureSet::kCore || set == FeatureSet::kAll;
  for_each_cell(window, [&](int x, int y, int dx, int dy) {
    collect.add(false, {{x, y, dx * 2, dy}, -1}, {{x + dx, y, dx, dy}, 2});
    collect.add(false, {{x, y, dx, dy * 2}, -1}, {{x, y + dy, dx, dy}, 2});
    collect.add(false, {{x, y, dx * 3, dy}, -1}, {{x + dx, y, dx, dy}, 3});
    collect.add(false, {{x, y, dx, dy * 3}, -1}, {{x, y + dy, dx, dy}, 3});
    if (core) collect.add(false, {{x, y, dx * 4, dy}, -1}, {{x + dx, y, dx * 2, dy}, 2});
    if (core) collect.add(false, {{x, y, dx, dy * 4}, -1}, {{x, y + dy, dx, dy * 2}, 2});
    collect.add(false, {{x, y, dx * 2, dy * 2}, -1}, {{x, y, dx, dy}, 2}, {{x + dx, y + dy, dx, dy}, 2});
    if (core) collect.add(false, {{x, y, dx * 3, dy * 3}, -1}, {{x + dx, y + dy, dx, dy}, 9});
    if (set == FeatureSet::kAll) add_tilted(collect, x, y, dx, dy);
  });
}

/// (C-6). dx is the width of the bright region; the dark one is `proportion` times as wide, the gap between them as wide as the bright.
void add_side_scan(cv::Size window, Collector& collect) {
  for_each_cell(window, [&](int x, int y, int dx, int dy) {
    for (int proportion = 1; proportion <= kMostDarkToBright; ++proportion) {
      const int dark = dx * proportion;
      const auto weight = static_cast<float>(proportion);
      const cv::Rect touching(x, y, dark + dx, dy);
      if (!collect.inside(touching, false)) break;
      collect.add(false, {touching, -1}, {{x + dark, y, dx, dy}, weight + 1});
      // 1:1 with the bright region on the left is the feature before with its sign changed: the stump's two leaves do that
      if (proportion > 1) collect.add(false, {touching, -1}, {{x, y, dx, dy}, weight + 1});
      const cv::Rect apart(x, y, dark + 2 * dx, dy);
      if (!collect.inside(apart, false)) continue;
      collect.add(false, {apart, -1}, {{x + dark, y, dx, dy}, 1}, {{x + dark + dx, y, dx, dy}, weight + 1});
      if (proportion > 1) collect.add(false, {apart, -1}, {{x + dx, y, dx, dy}, 1}, {{x, y, dx, dy}, weight + 1});
    }
  });
}

}  // namespace

std::string to_string(FeatureSet set) {
  switch (set) {
    case FeatureSet::kBasic:
      return "basic";
    case FeatureSet::kCore:
      return "core";
    case FeatureSet::kAll:
      return "all";
    case FeatureSet::kSideScan:
      return "side_scan";
    case FeatureSet::kSideScanBasic:
      return "side_scan_basic";
  }
  return "unknown";
}

std::vector<HaarFeature> enumerate_features(FeatureSet set, cv::Size window) {
  if (window.width < 3 || window.height < 3)
    throw InvalidArgument("window", std::to_string(window.width) + " x " + std::to_string(window.height), "must be at least 3 x 3 pixels");
  Collector collect(window);
  if (set == FeatureSet::kSideScan || set == FeatureSet::kSideScanBasic) add_side_scan(window, collect);
  if (set != FeatureSet::kSideScan) add_classic(set, window, collect);
  return collect.take();
}

void check_feature(const HaarFeature& feature, cv::Size window) {
  for (std::size_t i = 0; i < feature.rects.size(); ++i) {
    const WeightedRect& part = feature.rects[i];
    const cv::Rect& rect = part.rect;
    if (part.weight == 0 && i > 0 && rect == cv::Rect()) continue;
    if (!std::isfinite(part.weight)) throw InvalidArgument("rectangle " + std::to_string(i), part.weight, "its weight must be finite");
    const bool sized = rect.width > 0 && rect.height > 0 && rect.width <= window.width && rect.height <= window.height;
    bool inside = sized && rect.x >= 0 && rect.y >= 0 && rect.x <= window.width && rect.y <= window.height;
    if (inside) {
      for (const cv::Point& corner : corners(rect, feature.tilted))
        inside = inside && corner.x >= 0 && corner.x <= window.width && corner.y >= 0 && corner.y <= window.height;
    }
    if (!inside)
      throw InvalidArgument(
          "rectangle " + std::to_string(i),
          std::to_string(rect.x) + " " + std::to_string(rect.y) + " " + std::to_string(rect.width) + " " + std::to_string(rect.height),
          "must lie in the window of " + std::to_string(window.width) + " x " + std::to_string(window.height));
  }
}

std::optional<HaarFeature> mirrored(const HaarFeature& feature, cv::Size window) {
  HaarFeature mirror = feature;
  for (WeightedRect& part : mirror.rects) {
    cv::Rect& rect = part.rect;
    if (part.weight == 0) continue;
    if (!feature.tilted) {
      rect.x = window.width - rect.x - rect.width;
      continue;
    }
    if (rect.x - rect.height < 1) return std::nullopt;
    rect = cv::Rect(window.width - rect.x + 1, rect.y, rect.height, rect.width);
  }
  return mirror;
}

std::optional<float> reciprocal_deviation(double variance, double area) {
  constexpr double kFlattest = 0.1;  // reciprocal of the standard deviation, 1 / grey levels
  if (variance <= 0) return std::nullopt;
  const auto norm = static_cast<float>(1.0 / std::sqrt(variance));
  if (!(area * static_cast<double>(norm) < kFlattest)) return std::nullopt;
  return norm;
}

std::optional<float> normalisation(const IntegralImage& image, cv::Point top_left, cv::Size window) {
  const cv::Rect inner(top_left.x + 1, top_left.y + 1, window.width - 2, window.height - 2);
  const auto sum = static_cast<double>(image.sum_in(inner));
  const double area = inner.area();
  return reciprocal_deviation(area * image.squares_in(inner) - sum * sum, area);
}

float feature_value(const HaarFeature& feature, const IntegralImage& image, cv::Point top_left, float norm) {
  const auto term = [&](const WeightedRect& part) {
    const cv::Rect rect = part.rect + top_left;
    return part.weight * static_cast<float>(static_cast<std::int32_t>(feature.tilted ? image.diagonal_sum_in(rect) : image.sum_in(rect)));
  };
  float value = term(feature.rects[0]) + term(feature.rects[1]);
  if (feature.rects[2].weight != 0) value += term(feature.rects[2]);
  return value * norm;
}

std::array<cv::Point, 4> corners(const cv::Rect& rect, bool tilted) {
  const int x = rect.x;
  const int y = rect.y;
  const int w = rect.width;
  const int h = rect.height;
  if (!tilted) return {cv::Point(x, y), cv::Point(x + w, y), cv::Point(x, y + h), cv::Point(x + w, y + h)};
  return {cv::Point(x, y), cv::Point(x - h, y + h), cv::Point(x + w, y + w), cv::Point(x + w - h, y + w + h)};
}

}  // namespace ssjs
