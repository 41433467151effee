#include "ssjs/imaging/sonar_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "ssjs/base/error.hpp"
#include "ssjs/imaging/speckle.hpp"

namespace ssjs {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kSpotClearancePx = 6;   // between spots and the object or its shadow
constexpr double kLargeSpots = 0.03;  // of all spots
constexpr double kFanHalfAngleDeg = 60;
constexpr double kFanRangeOfRows = 0.98;

/// A part of an object: a line with round ends. Lengths are in those of the object, the origin is its middle.
struct Stroke {
  cv::Point2d from;
  cv::Point2d to;
  double width = 0;
  double level = 1;  ///< of the object's
};

std::vector<Stroke> strokes(SceneObject object) {
  switch (object) {
    case SceneObject::kShip:
      return {{{-0.4, 0}, {0.3, 0}, 0.2, 0.92}, {{0.3, 0}, {0.46, 0}, 0.09, 0.92}, {{-0.2, 0}, {0.05, 0}, 0.1, 1}};
    case SceneObject::kBranch:
      return {{{-0.46, 0}, {0.1, 0.06}, 0.09, 1},
              {{0.1, 0.06}, {0.46, -0.05}, 0.07, 1},
              {{-0.1, 0.03}, {0.12, -0.2}, 0.06, 0.95},
              {{0.12, 0.06}, {0.3, 0.22}, 0.06, 0.95}};
    case SceneObject::kBody:
      return {{{-0.36, 0}, {-0.36, 0}, 0.13, 1},      {{-0.36, 0}, {-0.2, 0}, 0.07, 0.95},     {{-0.15, 0}, {0.12, 0}, 0.17, 1},
              {{-0.14, 0}, {0.08, 0.24}, 0.07, 0.95}, {{-0.14, 0}, {0.08, -0.24}, 0.07, 0.95}, {{0.12, 0}, {0.46, 0.1}, 0.09, 0.95},
              {{0.12, 0}, {0.46, -0.1}, 0.09, 0.95}};
  }
  throw InvalidArgument("object", static_cast<double>(object), "must be a kind of object");
}

/// Where an object lies in the picture.
struct Placement {
  cv::Point2d middle;
  double length_px = 0;
  double heading_rad = 0;

  [[nodiscard]] cv::Point pixel(const cv::Point2d& p) const {
    const double c = std::cos(heading_rad), s = std::sin(heading_rad);
    return {cvRound(middle.x + length_px * (c * p.x - s * p.y)), cvRound(middle.y + length_px * (s * p.x + c * p.y))};
  }
  void draw(cv::Mat& canvas, const Stroke& stroke, double value, const cv::Point& shift = {0, 0}) const {
    cv::line(canvas, pixel(stroke.from) + shift, pixel(stroke.to) + shift, value, std::max(1, cvRound(length_px * stroke.width)));
  }
};

cv::Mat fan(const SpottedSceneConfig& config) {
  cv::Mat valid = cv::Mat::zeros(config.rows, config.columns, CV_8U);
  const int range_px = cvRound(kFanRangeOfRows * config.rows);
  cv::ellipse(valid, {config.columns / 2, config.rows - 1}, {range_px, range_px}, 270, -kFanHalfAngleDeg, kFanHalfAngleDeg, 255,
              cv::FILLED);
  return valid;
}

/// The pixels of a spot: those nearest to its middle in an oval of any direction.
std::vector<cv::Point> spot(int area_px, Rng& rng) {
  const double aspect = rng.uniform(1, 2.5);
  const double heading = rng.uniform(0, kPi);
  const int reach = static_cast<int>(std::ceil(std::sqrt(area_px * aspect))) + 1;
  std::vector<std::pair<double, cv::Point>> pixels;
  for (int y = -reach; y <= reach; ++y) {
    for (int x = -reach; x <= reach; ++x) {
      const double along = std::cos(heading) * x + std::sin(heading) * y;
      const double across = std::cos(heading) * y - std::sin(heading) * x;
      pixels.emplace_back(along * along / aspect + across * across * aspect, cv::Point(x, y));
    }
  }
  std::stable_sort(pixels.begin(), pixels.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<cv::Point> nearest;
  for (int i = 0; i < area_px; ++i) nearest.push_back(pixels[static_cast<std::size_t>(i)].second);
  return nearest;
}

/// (O-14) 2 to 0.9 spot_px pixels, 0.3 spot_px on average; a few are as large as what is looked for.
int spot_area_px(const SpottedSceneConfig& config, Rng& rng) {
  const double u = rng.uniform();
  const double area_px = rng.uniform() < kLargeSpots ? (1.2 + 1.8 * u) * config.spot_px : 2 + (0.9 * config.spot_px - 2) * u * u;
  return static_cast<int>(std::lround(area_px));
}

void draw_spots(const SpottedSceneConfig& config, const cv::Mat& free, Rng rng, cv::Mat& levels) {
  if (config.spots > 0 && cv::countNonZero(free) == 0) throw InvalidArgument("spots", config.spots, "find no place beside the object");
  for (int drawn = 0; drawn < config.spots;) {
    const cv::Point middle(static_cast<int>(rng.below(static_cast<std::uint64_t>(config.columns))),
                           static_cast<int>(rng.below(static_cast<std::uint64_t>(config.rows))));
    if (free.at<unsigned char>(middle) == 0) continue;
    const double level = rng.uniform(config.dimmest_spot_level, config.brightest_spot_level);
    for (const cv::Point& offset : spot(spot_area_px(config, rng), rng)) {
      const cv::Point p = middle + offset;
      if (cv::Rect({0, 0}, free.size()).contains(p) && free.at<unsigned char>(p) != 0) levels.at<float>(p) = static_cast<float>(level);
    }
    ++drawn;
  }
}

}  // namespace

SpottedSceneConfig ship_scene() { return {}; }

SpottedSceneConfig branch_scene() {
  SpottedSceneConfig config;
  config.rows = 228;
  config.columns = 417;
  config.object = SceneObject::kBranch;
  config.object_length_px = 95;
  config.spots = 350;
  config.spot_px = 15;
  return config;
}

SpottedSceneConfig body_scene() {
  SpottedSceneConfig config;
  config.rows = 932;
  config.columns = 1920;
  config.object = SceneObject::kBody;
  config.object_length_px = 230;
  config.looks = 12;
  config.spots = 1800;
  config.spot_px = 40;
  config.fan = true;
  return config;
}

SonarScene simulate_spotted_scene(const SpottedSceneConfig& config, const Rng& rng) {
  throw_if_any(violations(config));
  Rng pose = rng.stream("pose");
  Placement placement;
  placement.middle = {config.columns * pose.uniform(0.42, 0.58), config.rows * pose.uniform(0.42, 0.58)};
  placement.length_px = config.object_length_px;
  placement.heading_rad = pose.uniform(-kPi, kPi);

  const cv::Size size(config.columns, config.rows);
  SonarScene scene{{cv::Mat(), config.fan ? fan(config) : cv::Mat()}, cv::Mat::zeros(size, CV_8U)};
  cv::Mat shadow = cv::Mat::zeros(size, CV_8U);
  const cv::Point away = config.fan ? cv::Point(0, -1) : cv::Point(1, 0);  // from the sonar
  for (const Stroke& stroke : strokes(config.object)) {
    placement.draw(scene.object, stroke, 255);
    for (int i = 0; i < cvRound(config.object_length_px / 3); ++i) placement.draw(shadow, stroke, 255, i * away);
  }
  shadow.setTo(0, scene.object);

  cv::Mat levels(size, CV_32F, cv::Scalar(config.background_level));
  cv::Mat free = (scene.object | shadow) == 0;
  cv::erode(free, free, cv::Mat::ones(2 * kSpotClearancePx + 1, 2 * kSpotClearancePx + 1, CV_8U));
  if (config.fan) free.setTo(0, scene.image.valid == 0);
  draw_spots(config, free, rng.stream("spots"), levels);
  levels.setTo(config.shadow * config.background_level, shadow);
  for (const Stroke& stroke : strokes(config.object)) placement.draw(levels, stroke, stroke.level * config.object_level);

  cv::Mat looks(size, CV_8U, cv::Scalar(config.looks));
  looks.setTo(config.object_looks, scene.object);
  scene.image.intensity = speckled(levels, looks, rng.stream("speckle"));
  if (config.fan) scene.image.intensity.setTo(0, scene.image.valid == 0);
  return scene;
}

SonarScene simulate_uneven_gain_scene(const UnevenGainSceneConfig& config, const Rng& rng) {
  throw_if_any(violations(config));
  const cv::Size size(config.columns, config.rows);
  SonarScene scene{{cv::Mat(), cv::Mat()}, cv::Mat::zeros(size, CV_8U)};
  cv::Mat levels(size, CV_32F);
  const double x_middle = 0.45 * config.columns, y_middle = 0.5 * config.rows;
  const double x_half = 0.05 * config.columns, y_half = 0.06 * config.rows;
  for (int r = 0; r < config.rows; ++r) {
    for (int c = 0; c < config.columns; ++c) {
      const double gain = 1 + config.gradient * (2.0 * c / config.columns - 1);  // (O-15)
      const double x = (c - x_middle) / x_half, y = (r - y_middle) / y_half;
      const double x_shadow = (x - 1.9) / 1.1;
      double level = config.background_level * gain;
      if (x * x + y * y < 1) {
        scene.object.at<unsigned char>(r, c) = 255;
        level *= config.contrast;
      } else if (x_shadow * x_shadow + y * y < 1) {
        level *= config.shadow;
      }
      levels.at<float>(r, c) = static_cast<float>(level);
    }
  }
  scene.image.intensity = speckled(levels, cv::Mat(size, CV_8U, cv::Scalar(config.looks)), rng.stream("speckle"));
  return scene;
}

}  // namespace ssjs
