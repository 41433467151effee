#include "ssjs/cascade/row_scan.hpp"

#include <algorithm>
#include <cmath>

namespace ssjs {
namespace {

constexpr std::size_t kSideBySideFrom = 5;  // while at least one window in so many still stands, the row is summed as a whole
constexpr std::size_t kLookAhead = 8;       // trees after which a window that cannot reach the mark any more is given up
constexpr double kAheadSlack = 1e-6;        // far above what summation rounds

using Corners = std::array<std::int32_t, 4>;

Corners offsets(const IntegralImage& geometry, const cv::Rect& rect, bool tilted) {
  Corners found{};
  const auto points = corners(rect, tilted);
  for (std::size_t k = 0; k < found.size(); ++k) found[k] = static_cast<std::int32_t>(geometry.offset(points[k].x, points[k].y));
  return found;
}

float weighted(const std::uint32_t* at, const Corners& c, float weight) {
  return weight * static_cast<float>(static_cast<std::int32_t>(at[c[0]] - at[c[1]] - at[c[2]] + at[c[3]]));
}

}  // namespace

RowScan::RowScan(const HaarCascade& cascade, const IntegralImage& geometry) : window_(cascade.window) {
  nodes_.reserve(cascade.features.size());
  for (const CascadeStage& stage : cascade.stages) {
    Stage laid{trees_.size(), stage.weak.size(), true, static_cast<double>(pass_mark(stage))};
    for (const WeakClassifier& weak : stage.weak) {
      laid.stumps = laid.stumps && weak.nodes.size() == 1;
      trees_.push_back({nodes_.size(), leaves_.size()});
      leaves_.insert(leaves_.end(), weak.leaves.begin(), weak.leaves.end());
      most_to_come_.push_back(static_cast<double>(*std::max_element(weak.leaves.begin(), weak.leaves.end())));
      for (const TreeNode& node : weak.nodes) {
        const HaarFeature& feature = cascade.features[static_cast<std::size_t>(node.feature)];
        Node& added = nodes_.emplace_back();
        for (std::size_t r = 0; r < feature.rects.size(); ++r) {
          const WeightedRect& part = feature.rects[r];
          if (part.weight != 0) added.rectangles[r] = {offsets(geometry, part.rect, feature.tilted), part.weight};
        }
        added.threshold = node.threshold;
        added.left = node.left;
        added.right = node.right;
        added.tilted = feature.tilted;
        if (weak.nodes.size() == 1) {
          added.left_leaf = weak.leaves[static_cast<std::size_t>(-node.left)];
          added.right_leaf = weak.leaves[static_cast<std::size_t>(-node.right)];
        }
      }
    }
    for (std::size_t t = trees_.size(); t-- > laid.first_tree + 1;) most_to_come_[t - 1] += most_to_come_[t];
    stages_.push_back(laid);
  }
  inner_ = offsets(geometry, {1, 1, window_.width - 2, window_.height - 2}, false);
}

/// (C-4) for the whole row, in steps that the compiler can run side by side.
void RowScan::normalise(const IntegralImage& image, std::ptrdiff_t base, const std::vector<unsigned char>& usable, Scratch& scratch) const {
  const std::size_t count = usable.size();
  scratch.norms.resize(count);
  scratch.variances.resize(count);
  const double area = static_cast<double>(window_.width - 2) * (window_.height - 2);
  const auto corner = [&](const std::uint32_t* sums, std::size_t k) { return sums + base + inner_[k]; };
  const std::array<const std::uint32_t*, 4> sum = {corner(image.sum(), 0), corner(image.sum(), 1), corner(image.sum(), 2),
                                                   corner(image.sum(), 3)};
  const std::array<const std::uint32_t*, 4> squares = {corner(image.squares(), 0), corner(image.squares(), 1), corner(image.squares(), 2),
                                                       corner(image.squares(), 3)};
  double* variances = scratch.variances.data();
  for (std::size_t i = 0; i < count; ++i) {
    const auto total = static_cast<double>(static_cast<std::int32_t>(sum[0][i] - sum[1][i] - sum[2][i] + sum[3][i]));
    const std::uint32_t square_total = squares[0][i] - squares[1][i] - squares[2][i] + squares[3][i];
    // unsigned to double by way of signed, for which there is an instruction
    const double unsigned_total = static_cast<double>(static_cast<std::int32_t>(square_total - 0x80000000U)) + 2147483648.0;
    variances[i] = area * unsigned_total - total * total;
  }
  const double flattest = 0.999 * 100 * area * area;  // below this, the exact test need not be asked
  for (std::size_t i = 0; i < count; ++i)
    scratch.norms[i] = usable[i] == 0 || variances[i] < flattest ? 0.0F : reciprocal_deviation(variances[i], area).value_or(0.0F);
}

void RowScan::sum_stage_side_by_side(const Stage& stage, const IntegralImage& image, std::ptrdiff_t base, Scratch& scratch) const {
  const std::size_t count = scratch.norms.size();
  scratch.sums.assign(count, 0.0);
  const float* norms = scratch.norms.data();
  double* sums = scratch.sums.data();
  for (std::size_t t = stage.first_tree; t < stage.first_tree + stage.trees; ++t) {
    const Node& node = nodes_[trees_[t].first_node];
    const std::uint32_t* row = (node.tilted ? image.diagonal() : image.sum()) + base;
    const auto& [first, second, third] = node.rectangles;
    const auto add = [&](auto value_at) {
      for (std::size_t i = 0; i < count; ++i)
        sums[i] += static_cast<double>(value_at(i) * norms[i] < node.threshold ? node.left_leaf : node.right_leaf);
    };
    const std::array<const std::uint32_t*, 12> at = {row + first.corners[0],  row + first.corners[1],  row + first.corners[2],
                                                     row + first.corners[3],  row + second.corners[0], row + second.corners[1],
                                                     row + second.corners[2], row + second.corners[3], row + third.corners[0],
                                                     row + third.corners[1],  row + third.corners[2],  row + third.corners[3]};
    const auto term = [&](std::size_t k, std::size_t i, float weight) {
      return weight * static_cast<float>(static_cast<std::int32_t>(at[k][i] - at[k + 1][i] - at[k + 2][i] + at[k + 3][i]));
    };
    const float w0 = first.weight;
    const float w1 = second.weight;
    const float w2 = third.weight;
    if (w2 == 0)
      add([&](std::size_t i) { return term(0, i, w0) + term(4, i, w1); });
    else
      add([&](std::size_t i) { return (term(0, i, w0) + term(4, i, w1)) + term(8, i, w2); });
  }
}

/// The stage's sum, or something below its mark as soon as that is certain.
double RowScan::sum_stage(const Stage& stage, const IntegralImage& image, std::ptrdiff_t base, float norm) const {
  const std::uint32_t* upright = image.sum() + base;
  const std::uint32_t* diagonal = image.has_diagonal() ? image.diagonal() + base : nullptr;
  const auto goes_left = [&](const Node& node) {
    const std::uint32_t* at = node.tilted ? diagonal : upright;
    const auto& [first, second, third] = node.rectangles;
    float value = weighted(at, first.corners, first.weight) + weighted(at, second.corners, second.weight);
    if (third.weight != 0) value += weighted(at, third.corners, third.weight);
    return value * norm < node.threshold;
  };
  double sum = 0;
  for (std::size_t k = 0; k < stage.trees; ++k) {
    const std::size_t t = stage.first_tree + k;
    if (k % kLookAhead == kLookAhead - 1 && sum + most_to_come_[t] < stage.pass_mark - kAheadSlack) return sum + most_to_come_[t];
    if (stage.stumps) {
      const Node& node = nodes_[trees_[t].first_node];
      sum += static_cast<double>(goes_left(node) ? node.left_leaf : node.right_leaf);
      continue;
    }
    int next = 0;
    do {
      const Node& node = nodes_[trees_[t].first_node + static_cast<std::size_t>(next)];
      next = goes_left(node) ? node.left : node.right;
    } while (next > 0);
    sum += static_cast<double>(leaves_[trees_[t].first_leaf + static_cast<std::size_t>(-next)]);
  }
  return sum;
}

void RowScan::scan(const IntegralImage& image, int y, const std::vector<unsigned char>& usable, bool skip_after_first_stage,
                   Scratch& scratch, std::vector<Hit>& hits) const {
  const std::ptrdiff_t base = image.offset(0, y);
  normalise(image, base, usable, scratch);
  if (std::all_of(scratch.norms.begin(), scratch.norms.end(), [](float norm) { return norm == 0; })) return;
  std::vector<Hit>& standing = scratch.standing;
  const auto margin = [&](const Stage& stage, bool side_by_side, std::size_t i) {
    return (side_by_side ? scratch.sums[i] : sum_stage(stage, image, base + static_cast<std::ptrdiff_t>(i), scratch.norms[i])) -
           stage.pass_mark;
  };
  standing.clear();
  const Stage& first = stages_.front();
  if (first.stumps) sum_stage_side_by_side(first, image, base, scratch);
  for (std::size_t i = 0; i < usable.size(); ++i) {
    if (scratch.norms[i] == 0) continue;
    const double above = margin(first, first.stumps, i);
    if (above >= 0)
      standing.push_back({static_cast<int>(i), above});
    else if (skip_after_first_stage)
      ++i;
  }
  for (std::size_t s = 1; s < stages_.size() && !standing.empty(); ++s) {
    const Stage& stage = stages_[s];
    const bool side_by_side = stage.stumps && standing.size() * kSideBySideFrom >= usable.size();
    if (side_by_side) sum_stage_side_by_side(stage, image, base, scratch);
    std::size_t left = 0;
    for (const Hit& hit : standing) {
      const double above = margin(stage, side_by_side, static_cast<std::size_t>(hit.index));
      if (above >= 0) standing[left++] = {hit.index, hit.score + above};
    }
    standing.resize(left);
  }
  hits.insert(hits.end(), standing.begin(), standing.end());
}

}  // namespace ssjs
