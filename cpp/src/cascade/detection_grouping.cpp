#include "ssjs/cascade/detection_grouping.hpp"

#include <algorithm>
#include <cstdlib>
#include <numeric>
#include <tuple>
#include <utility>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

bool alike(const cv::Rect& a, const cv::Rect& b, double similarity) {
  const double most = similarity * (std::min(a.width, b.width) + std::min(a.height, b.height)) * 0.5;
  return std::abs(a.x - b.x) <= most && std::abs(a.y - b.y) <= most && std::abs(a.x + a.width - b.x - b.width) <= most &&
         std::abs(a.y + a.height - b.y - b.height) <= most;
}

/// For each hit the least index among those that it hangs together with.
std::vector<std::size_t> groups_of(const std::vector<WindowHit>& hits, double similarity) {
  std::vector<std::size_t> parent(hits.size());
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto root = [&](std::size_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  std::vector<std::size_t> by_left(parent);
  std::stable_sort(by_left.begin(), by_left.end(), [&](std::size_t a, std::size_t b) { return hits[a].box.x < hits[b].box.x; });
  for (std::size_t i = 0; i < by_left.size(); ++i) {
    const cv::Rect& box = hits[by_left[i]].box;
    const double reach = similarity * (box.width + box.height) * 0.5;  // no box farther to the right is like this one
    for (std::size_t k = i + 1; k < by_left.size() && hits[by_left[k]].box.x - box.x <= reach; ++k) {
      if (!alike(box, hits[by_left[k]].box, similarity)) continue;
      const std::size_t a = root(by_left[i]);
      const std::size_t b = root(by_left[k]);
      parent[std::max(a, b)] = std::min(a, b);
    }
  }
  for (std::size_t i = 0; i < parent.size(); ++i) parent[i] = root(i);
  return parent;
}

struct Group {
  double x = 0, y = 0, width = 0, height = 0;
  double score = 0;
  int count = 0;

  [[nodiscard]] Detection mean() const {
    const float share = 1.F / static_cast<float>(count);
    const auto rounded = [&](double sum) { return cv::saturate_cast<int>(static_cast<float>(sum) * share); };
    return {{rounded(x), rounded(y), rounded(width), rounded(height)}, score, count};
  }
};

bool lies_in(const Detection& inner, const Detection& outer, double similarity) {
  const int dx = cv::saturate_cast<int>(outer.box.width * similarity);
  const int dy = cv::saturate_cast<int>(outer.box.height * similarity);
  return inner.box.x >= outer.box.x - dx && inner.box.y >= outer.box.y - dy &&
         inner.box.x + inner.box.width <= outer.box.x + outer.box.width + dx &&
         inner.box.y + inner.box.height <= outer.box.y + outer.box.height + dy &&
         (outer.neighbours > std::max(3, inner.neighbours) || inner.neighbours < 3);
}

void best_first(std::vector<Detection>& detections) {
  std::sort(detections.begin(), detections.end(), [](const Detection& a, const Detection& b) {
    return std::tuple(-a.score, a.box.y, a.box.x, a.box.width, a.box.height) <
           std::tuple(-b.score, b.box.y, b.box.x, b.box.width, b.box.height);
  });
}

/// Sums for the weighted mean of boxes.
struct WeightedBox {
  double x = 0, y = 0, width = 0, height = 0, weight = 0;

  void add(const cv::Rect& box, double by) {
    x += by * box.x;
    y += by * box.y;
    width += by * box.width;
    height += by * box.height;
    weight += by;
  }
  [[nodiscard]] cv::Rect mean() const {
    return {cvRound(x / weight), cvRound(y / weight), cvRound(width / weight), cvRound(height / weight)};
  }
};

}  // namespace

std::vector<Detection> best_hits(const std::vector<WindowHit>& hits, int min_neighbours, double max_overlap) {
  if (min_neighbours < 0) throw InvalidArgument("min_neighbours", min_neighbours, "must not be negative");
  if (!(max_overlap >= 0 && max_overlap <= 1)) throw InvalidArgument("max_overlap", max_overlap, "must lie in [0, 1]");
  constexpr double kOfTheMean = 0.5;     // intersection over union
  constexpr double kLeastWeight = 1e-6;  // a hit of score 0 has a box, too
  std::vector<Detection> left;
  for (const WindowHit& hit : hits) left.push_back({hit.box, hit.score, 1});
  best_first(left);
  std::vector<Detection> kept;
  while (!left.empty()) {
    const Detection best = left.front();
    WeightedBox mean;
    int neighbours = 0;
    std::vector<Detection> others;
    for (const Detection& hit : left) {
      const double common = (hit.box & best.box).area();
      const double area = hit.box.area();
      const double best_area = best.box.area();
      if (common / (area + best_area - common) >= kOfTheMean) mean.add(hit.box, std::max(hit.score, kLeastWeight));
      if (hit.box == best.box || common > max_overlap * std::min(area, best_area))
        ++neighbours;
      else
        others.push_back(hit);
    }
    if (neighbours > min_neighbours) kept.push_back({mean.mean(), best.score, neighbours});
    left = std::move(others);
  }
  return kept;
}

std::vector<Detection> group_hits(const std::vector<WindowHit>& hits, int min_neighbours, double similarity) {
  if (min_neighbours < 0) throw InvalidArgument("min_neighbours", min_neighbours, "must not be negative");
  if (!(similarity >= 0)) throw InvalidArgument("similarity", similarity, "must not be negative");
  std::vector<Detection> kept;
  if (min_neighbours == 0) {
    for (const WindowHit& hit : hits) kept.push_back({hit.box, hit.score, 1});
    best_first(kept);
    return kept;
  }
  const std::vector<std::size_t> group_of = groups_of(hits, similarity);
  std::vector<Group> groups(hits.size());
  for (std::size_t i = 0; i < hits.size(); ++i) {
    Group& group = groups[group_of[i]];
    const WindowHit& hit = hits[i];
    group.x += hit.box.x;
    group.y += hit.box.y;
    group.width += hit.box.width;
    group.height += hit.box.height;
    group.score = group.count == 0 ? hit.score : std::max(group.score, hit.score);
    ++group.count;
  }
  std::vector<Detection> means;
  for (const Group& group : groups)
    if (group.count > min_neighbours) means.push_back(group.mean());
  for (std::size_t i = 0; i < means.size(); ++i) {
    bool inside = false;
    for (std::size_t k = 0; k < means.size() && !inside; ++k) inside = k != i && lies_in(means[i], means[k], similarity);
    if (!inside) kept.push_back(means[i]);
  }
  best_first(kept);
  return kept;
}

}  // namespace ssjs
