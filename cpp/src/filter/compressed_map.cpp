#include "ssjs/filter/compressed_map.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace ssjs {
namespace {

constexpr Eigen::Index kVehicle = StateLayout::kVehicle;

Eigen::Index whole_tiles(Eigen::Index n) { return (n + 3) / 4 * 4; }  // of SymmetricDowndate

/// B with psi = B B' for a semidefinite psi; its rank decides the number of columns.
Eigen::MatrixXd square_root(const Eigen::MatrixXd& psi) {
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(psi);
  const Eigen::VectorXd D = ldlt.vectorD();
  const double rounding = static_cast<double>(psi.rows()) * Eigen::NumTraits<double>::epsilon() * D.cwiseAbs().maxCoeff();
  Eigen::MatrixXd root = ldlt.matrixL();
  Eigen::Index rank = 0;
  for (Eigen::Index j = 0; j < D.size(); ++j) {  // landmarks that were not seen have no part in psi: pivots of zero, give or take rounding
    if (D(j) > rounding) root.col(rank++) = std::sqrt(D(j)) * root.col(j);
  }
  return ldlt.transpositionsP().transpose() * root.leftCols(rank);
}

}  // namespace

CompressedMap::CompressedMap()
    : mean_(Eigen::VectorXd::Zero(whole_tiles(kVehicle))), P_(Eigen::MatrixXd::Zero(mean_.size(), mean_.size())) {}

std::vector<Eigen::Index> CompressedMap::rows_of(const std::vector<Eigen::Index>& slots) {
  std::vector<Eigen::Index> rows{0, 1, 2};
  for (const Eigen::Index slot : slots) {
    rows.push_back(StateLayout().offset(slot));
    rows.push_back(StateLayout().offset(slot) + 1);
  }
  return rows;
}

Eigen::Index CompressedMap::take_slot() {
  const auto unused = std::find(free_.begin(), free_.end(), true);
  if (unused != free_.end()) {
    *unused = false;
    return unused - free_.begin();
  }
  free_.push_back(false);
  const Eigen::Index n = StateLayout().size(++slots_);
  if (n > mean_.size()) {
    const Eigen::Index old = mean_.size();
    const Eigen::Index size = whole_tiles(std::max(n, 2 * old));
    mean_.conservativeResize(size);
    P_.conservativeResize(size, size);
    P_.rightCols(size - old).setZero();
    P_.bottomRows(size - old).setZero();
  }
  return slots_ - 1;
}

void CompressedMap::enter(const std::vector<Eigen::Index>& slots, Ekf& filter, Compression& compression) {
  entered_ = slots;
  const MapState active = state(slots);
  filter.restore(active);
  compression.start(active.mean.size());
}

MapState CompressedMap::state(const std::vector<Eigen::Index>& slots) const {
  const std::vector<Eigen::Index> rows = rows_of(slots);
  const auto n = static_cast<Eigen::Index>(rows.size());
  MapState state{mean_(rows), Eigen::MatrixXd(n, n)};
  for (Eigen::Index c = 0; c < n; ++c) {
    for (Eigen::Index r = c; r < n; ++r) {
      const auto [low, high] = std::minmax(rows[static_cast<std::size_t>(r)], rows[static_cast<std::size_t>(c)]);
      state.covariance(r, c) = state.covariance(c, r) = P_(high, low);
    }
  }
  return state;
}

Eigen::Matrix2d CompressedMap::landmark_covariance(Eigen::Index slot) const {
  const Eigen::Index at = StateLayout().offset(slot);
  return P_.block<2, 2>(at, at).selfadjointView<Eigen::Lower>();
}

void CompressedMap::update_from(const MapState& active, const Compression& compression, std::vector<Eigen::Index>& slots) {
  const std::vector<Eigen::Index> rows0 = rows_of(entered_);
  const Eigen::Index n0 = StateLayout().size(slots_);
  const auto a0 = static_cast<Eigen::Index>(rows0.size());
  Eigen::MatrixXd P_0(n0, a0);  // P_BA0; the rows of the active part have no meaning here
  for (Eigen::Index c = 0; c < a0; ++c) {
    const Eigen::Index at = rows0[static_cast<std::size_t>(c)];
    P_0.col(c).head(at) = P_.row(at).head(at);
    P_0.col(c).tail(n0 - at) = P_.col(at).segment(at, n0 - at);
  }
  for (const Eigen::Index row : rows0) P_0.row(row).setZero();
  const Eigen::MatrixXd phi = compression.phi();
  if (compression.has_updates()) {  // (G-10)
    mean_.head(n0).noalias() += P_0 * compression.theta();
    const Eigen::MatrixXd Y = P_0 * square_root(compression.psi());
    downdate_.reserve(n0, Y.cols());
    downdate_(Y, P_);
  }
  const Eigen::MatrixXd P_BA = P_0 * phi.transpose();

  for (const Eigen::Index slot : entered_) {
    if (std::find(slots.begin(), slots.end(), slot) == slots.end()) free_[static_cast<std::size_t>(slot)] = true;
  }
  for (Eigen::Index& slot : slots) {
    if (slot < 0) slot = take_slot();
  }
  const std::vector<Eigen::Index> rows = rows_of(slots);
  for (Eigen::Index c = 0; c < static_cast<Eigen::Index>(rows.size()); ++c) {  // P_BA first, then P_AA over what stood there before
    const Eigen::Index at = rows[static_cast<std::size_t>(c)];
    mean_(at) = active.mean(c);
    for (Eigen::Index r = 0; r < n0; ++r) P_(std::max(r, at), std::min(r, at)) = P_BA(r, c);
  }
  for (Eigen::Index c = 0; c < static_cast<Eigen::Index>(rows.size()); ++c) {
    for (Eigen::Index r = c; r < static_cast<Eigen::Index>(rows.size()); ++r) {
      const auto [low, high] = std::minmax(rows[static_cast<std::size_t>(r)], rows[static_cast<std::size_t>(c)]);
      P_(high, low) = active.covariance(r, c);
    }
  }
}

}  // namespace ssjs
