#include "ssjs/joining/fusion_constraints.hpp"

namespace ssjs {

std::vector<SharedBase> shared_bases(const LiveMap& a, const LiveMap& b) {
  std::vector<SharedBase> shared;
  if (const auto in_b = b.pose_of(a.base)) shared.push_back({std::nullopt, in_b});
  if (const auto in_a = a.pose_of(b.base)) shared.push_back({in_a, std::nullopt});
  for (Eigen::Index i = 0; i < a.pose_count(); ++i) {
    if (const auto in_b = b.pose_of(a.poses[static_cast<std::size_t>(i)])) shared.push_back({i, in_b});
  }
  return shared;
}

void turn_columns(Eigen::MatrixXd& M, const std::vector<Eigen::Index>& points, const Eigen::Matrix2d& R) {
  for (const Eigen::Index at : points) {
    double* const x = M.col(at).data();
    double* const y = M.col(at + 1).data();
    for (Eigen::Index i = 0; i < M.rows(); ++i) {
      const double old_x = x[i];
      x[i] = R(0, 0) * old_x + R(0, 1) * y[i];
      y[i] = R(1, 0) * old_x + R(1, 1) * y[i];
    }
  }
}

void turn(Eigen::MatrixXd& P, const std::vector<Eigen::Index>& points, const Eigen::Matrix2d& R) {
  turn_columns(P, points, R);
  P.transposeInPlace();
  turn_columns(P, points, R);
}

void ConstrainedSide::set(Eigen::Index row, Eigen::Index component, Eigen::Index size) {
  for (Eigen::Index i = 0; i < size; ++i) component_[static_cast<std::size_t>(row + i)] = component + i;
}

void ConstrainedSide::gather() {
  const auto rows = static_cast<Eigen::Index>(component_.size());
  prior.setZero(rows);
  P.setZero(rows, rows);
  for (Eigen::Index c = 0; c < rows; ++c) {
    const Eigen::Index column = component_[static_cast<std::size_t>(c)];
    if (column < 0) continue;
    prior(c) = map_.mean(column);
    const double* const from = map_.covariance.col(column).data();
    for (Eigen::Index r = 0; r < rows; ++r) {
      const Eigen::Index row = component_[static_cast<std::size_t>(r)];
      if (row >= 0) P(r, c) = from[row];
    }
  }
  x = prior;
}

Eigen::MatrixXd ConstrainedSide::columns() const {
  Eigen::MatrixXd all(map_.mean.size(), static_cast<Eigen::Index>(component_.size()));
  for (Eigen::Index c = 0; c < all.cols(); ++c) {
    const Eigen::Index column = component_[static_cast<std::size_t>(c)];
    if (column < 0) {
      all.col(c).setZero();
    } else {
      all.col(c) = map_.covariance.col(column);
    }
  }
  return all;
}

FusionConstraints::FusionConstraints(const LiveMap& a, const LiveMap& b, const std::vector<Pair>& pairs,
                                     const std::vector<SharedBase>& shared)
    : c(static_cast<Eigen::Index>(2 * pairs.size() + 3 * shared.size())), J(c.size(), 3), of_a(a, c.size()), of_b(b, c.size()) {
  Eigen::Index row = 0;
  for (const Pair& pair : pairs) {
    of_a.set(row, a.landmark_offset(pair.prediction), 2);
    of_b.set(row, b.landmark_offset(pair.observation), 2);
    points.push_back(row);
    row += 2;
  }
  for (const SharedBase& base : shared) {
    if (base.in_a) of_a.set(row, 3 * *base.in_a, 3);
    if (base.in_b) of_b.set(row, 3 * *base.in_b, 3);
    points.push_back(row);
    headings.push_back(row + 2);
    row += 3;
  }
  of_a.gather();
  of_b.gather();
}

void FusionConstraints::linearize(const Se2& a_T_b, const Eigen::Matrix2d& R) {
  for (const Eigen::Index at : points) {
    const Eigen::Vector2d moved = R * of_b.x.segment<2>(at);
    c.segment<2>(at) = of_a.x.segment<2>(at) - a_T_b.translation() - moved;
    J.middleRows<2>(at) << -1.0, 0.0, moved.y(), 0.0, -1.0, -moved.x();
  }
  for (const Eigen::Index at : headings) {
    c(at) = wrap_angle(of_a.x(at) - a_T_b.heading - of_b.x(at));
    J.row(at) << 0.0, 0.0, -1.0;
  }
}

Eigen::VectorXd FusionConstraints::at_prior(const Eigen::Matrix2d& R) const {
  const Eigen::VectorXd shift_a = of_a.prior - of_a.x;
  const Eigen::VectorXd shift_b = of_b.prior - of_b.x;
  Eigen::VectorXd c0 = c + shift_a;
  for (const Eigen::Index at : points) c0.segment<2>(at) -= R * shift_b.segment<2>(at);
  for (const Eigen::Index at : headings) c0(at) = c(at) + wrap_angle(shift_a(at)) - wrap_angle(shift_b(at));
  return c0;
}

Eigen::MatrixXd FusionConstraints::covariance(const Eigen::Matrix2d& R) const {
  Eigen::MatrixXd S = of_b.P;
  turn(S, points, R);
  S += of_a.P;
  return S;
}

void FusionConstraints::move(const Eigen::VectorXd& gain, const Eigen::Matrix2d& R) {
  Eigen::VectorXd Rt_gain = gain;
  for (const Eigen::Index at : points) Rt_gain.segment<2>(at) = R.transpose() * gain.segment<2>(at);
  of_a.x = of_a.prior - of_a.P * gain;
  of_b.x = of_b.prior + of_b.P * Rt_gain;
}

}  // namespace ssjs
