#include "ssjs/cascade/window_sums.hpp"

#include <algorithm>
#include <array>
#include <type_traits>

namespace ssjs {
namespace {

using Corners = std::array<const std::uint32_t*, 4>;

float weighted(const Corners& c, std::size_t i, float weight) {
  return weight * static_cast<float>(static_cast<std::int32_t>(c[0][i] - c[1][i] - c[2][i] + c[3][i]));
}

}  // namespace

WindowSums::WindowSums(const WindowSet& windows, Diagonal diagonal) : stride_(windows.window().width + 1), norms_(windows.size()) {
  const std::size_t corner_count = static_cast<std::size_t>(stride_) * static_cast<std::size_t>(windows.window().height + 1);
  const bool with_diagonal = diagonal == Diagonal::kWith;
  sums_.resize(corner_count * size());
  if (with_diagonal) diagonals_.resize(corner_count * size());
  IntegralImage integral;
  for (std::size_t i = 0; i < size(); ++i) {
    integral.assign(windows[i], with_diagonal ? IntegralImage::Diagonal::kWith : IntegralImage::Diagonal::kWithout, 1);
    norms_[i] = normalisation(integral, {0, 0}, windows.window()).value_or(0.0F);
    for (std::size_t corner = 0; corner < corner_count; ++corner) {
      sums_[corner * size() + i] = integral.sum()[corner];
      if (with_diagonal) diagonals_[corner * size() + i] = integral.diagonal()[corner];
    }
  }
}

WindowSums WindowSums::select(const std::vector<std::uint32_t>& windows) const {
  const auto chosen = [&](const auto& rows) {
    std::decay_t<decltype(rows)> made;
    made.reserve(rows.size() / std::max<std::size_t>(1, size()) * windows.size());
    for (std::size_t row = 0; row < rows.size(); row += size())
      for (const std::uint32_t window : windows) made.push_back(rows[row + window]);
    return made;
  };
  WindowSums some;
  some.stride_ = stride_;
  some.norms_ = chosen(norms_);
  some.sums_ = chosen(sums_);
  some.diagonals_ = chosen(diagonals_);
  return some;
}

void WindowSums::values(const HaarFeature& feature, float* values) const {
  const std::vector<std::uint32_t>& sums = feature.tilted ? diagonals_ : sums_;
  const auto corner_rows = [&](const WeightedRect& part) {
    Corners rows{};
    const auto points = corners(part.rect, feature.tilted);
    for (std::size_t k = 0; k < rows.size(); ++k)
      rows[k] = sums.data() + static_cast<std::size_t>(points[k].y * stride_ + points[k].x) * size();
    return rows;
  };
  const std::size_t count = size();
  const float* norms = norms_.data();
  const Corners first = corner_rows(feature.rects[0]);
  const Corners second = corner_rows(feature.rects[1]);
  const float w0 = feature.rects[0].weight;
  const float w1 = feature.rects[1].weight;
  const float w2 = feature.rects[2].weight;
  if (w2 == 0) {
    for (std::size_t i = 0; i < count; ++i) values[i] = (weighted(first, i, w0) + weighted(second, i, w1)) * norms[i];
  } else {
    const Corners third = corner_rows(feature.rects[2]);
    for (std::size_t i = 0; i < count; ++i)
      values[i] = ((weighted(first, i, w0) + weighted(second, i, w1)) + weighted(third, i, w2)) * norms[i];
  }
}

}  // namespace ssjs
