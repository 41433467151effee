#include "ssjs/filter/symmetric_update.hpp"

namespace ssjs {
namespace {

constexpr Eigen::Index kTile = 4;

Eigen::Index tiles_of(Eigen::Index n) { return (n + kTile - 1) / kTile; }

}  // namespace

void SymmetricDowndate::reserve(Eigen::Index n, Eigen::Index k) {
  const auto needed = static_cast<std::size_t>(tiles_of(n) * kTile * k);
  if (packed_.size() < needed) packed_.resize(needed);
}

void SymmetricDowndate::operator()(const Eigen::Ref<const Eigen::MatrixXd>& Y, Eigen::MatrixXd& P) {
  const Eigen::Index n = Y.rows();
  const Eigen::Index k = Y.cols();
  const Eigen::Index tiles = tiles_of(n);
  reserve(n, k);
  // Tile t holds rows 4t..4t+3 of Y, column after column: both operands of the inner product then stream through the cache.
  using Tile = Eigen::Matrix<double, kTile, 1>;
  for (Eigen::Index t = 0; t < tiles; ++t) {
    const Eigen::Index rows = std::min(kTile, n - t * kTile);
    double* out = packed_.data() + t * kTile * k;
    for (Eigen::Index c = 0; c < k; ++c, out += kTile) {
      Eigen::Map<Tile> tile(out);
      if (rows == kTile) {
        tile = Y.col(c).segment<kTile>(t * kTile);
      } else {
        tile.setZero();
        tile.head(rows) = Y.col(c).segment(t * kTile, rows);
      }
    }
  }
  for (Eigen::Index j = 0; j < tiles; ++j) {
    const double* const right = packed_.data() + j * kTile * k;
    for (Eigen::Index i = j; i < tiles; ++i) {
      const double* left = packed_.data() + i * kTile * k;
      const double* other = right;
      Eigen::Matrix<double, kTile, kTile> product = Eigen::Matrix<double, kTile, kTile>::Zero();
      for (Eigen::Index c = 0; c < k; ++c, left += kTile, other += kTile) {
        const Eigen::Map<const Tile> a(left);
        product.col(0) += a * other[0];
        product.col(1) += a * other[1];
        product.col(2) += a * other[2];
        product.col(3) += a * other[3];
      }
      P.block<kTile, kTile>(i * kTile, j * kTile) -= product;  // (F-7)
    }
  }
}

}  // namespace ssjs
