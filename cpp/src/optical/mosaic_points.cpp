#include "ssjs/optical/mosaic_points.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "ssjs/base/error.hpp"
#include "ssjs/base/random.hpp"
#include "ssjs/optical/matching.hpp"

namespace ssjs {
namespace {

constexpr int kDrawsPerPoint = 1000;  // the frames may show little of the rectangle around them
constexpr double kMarginPx = 2.0;     // pixels nearer to the border may have been taken from outside

bool shows(cv::Size frame, cv::Point2d p) {
  return p.x >= kMarginPx && p.y >= kMarginPx && p.x <= frame.width - 1 - kMarginPx && p.y <= frame.height - 1 - kMarginPx;
}

struct Extent {
  cv::Point2d low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()}, high = -low;
  void hold(cv::Point2d p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
};

}  // namespace

std::vector<MosaicPointSighting> mosaic_points(const std::vector<cv::Matx33d>& map_H_frame, cv::Size frame,
                                               const std::vector<FrameHomography>& links, int count, std::uint64_t seed) {
  const int frames = static_cast<int>(map_H_frame.size());
  if (frames == 0) throw InvalidArgument("map_H_frame", 0, "is empty");
  Extent extent;
  std::vector<cv::Point2d> middles;
  std::vector<cv::Matx33d> frame_H_map;
  const cv::Point2d middle(0.5 * (frame.width - 1), 0.5 * (frame.height - 1));
  for (const cv::Matx33d& H : map_H_frame) {
    for (const cv::Point2d corner : {cv::Point2d(0, 0), cv::Point2d(frame.width - 1, 0), cv::Point2d(0, frame.height - 1), 2.0 * middle}) {
      extent.hold(transformed(H, corner));
    }
    middles.push_back(transformed(H, middle));
    frame_H_map.push_back(H.inv());
  }
  std::vector<std::vector<std::pair<int, cv::Matx33d>>> registered(map_H_frame.size());  // by frame: others, and how to get there
  for (const FrameHomography& link : links) {
    if (std::min(link.first, link.second) < 0 || std::max(link.first, link.second) >= frames) {
      throw InvalidArgument("links", link.second, "must be of frames that there are");
    }
    registered[static_cast<std::size_t>(link.first)].emplace_back(link.second, link.second_H_first);
    registered[static_cast<std::size_t>(link.second)].emplace_back(link.first, link.second_H_first.inv());
  }
  Rng rng = Rng(seed).stream("mosaic_points");
  std::vector<MosaicPointSighting> sightings;
  for (int point = 0; point < count; ++point) {
    for (int draw = 0; draw < kDrawsPerPoint; ++draw) {  // (V-25)
      const double x = rng.uniform(extent.low.x, extent.high.x), y = rng.uniform(extent.low.y, extent.high.y);
      const auto distance = [&](cv::Point2d m) { return std::hypot(m.x - x, m.y - y); };
      const auto nearest =
          std::min_element(middles.begin(), middles.end(), [&](cv::Point2d a, cv::Point2d b) { return distance(a) < distance(b); });
      const auto home = static_cast<std::size_t>(nearest - middles.begin());
      const cv::Point2d at = transformed(frame_H_map[home], {x, y});
      if (!shows(frame, at)) continue;
      sightings.push_back({static_cast<int>(home), point, at});
      for (const auto& [other, other_H_home] : registered[home]) {
        const cv::Point2d there = transformed(other_H_home, at);
        if (shows(frame, there)) sightings.push_back({other, point, there});
      }
      break;
    }
  }
  std::sort(sightings.begin(), sightings.end(),
            [](const auto& a, const auto& b) { return std::tie(a.frame, a.point) < std::tie(b.frame, b.point); });
  return sightings;
}

}  // namespace ssjs
