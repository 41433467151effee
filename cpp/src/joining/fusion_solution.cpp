#include "ssjs/joining/fusion_solution.hpp"

#include <Eigen/Cholesky>

#include "ssjs/base/error.hpp"
#include "ssjs/geometry/point_alignment.hpp"

namespace ssjs {
namespace {

constexpr int kIterations = 3;
constexpr double kConstraintVariance = 1e-12;  // exact constraints, kept invertible

}  // namespace

Se2 initial_relative_pose(const LiveMap& a, const LiveMap& b, const std::vector<Pair>& pairs, const std::vector<SharedBase>& shared) {
  if (!shared.empty()) {
    const Se2 in_a = shared.front().in_a ? a.base_T_pose(*shared.front().in_a) : Se2{};
    const Se2 in_b = shared.front().in_b ? b.base_T_pose(*shared.front().in_b) : Se2{};
    return in_a * in_b.inverse();
  }
  const auto n = static_cast<Eigen::Index>(pairs.size());
  Eigen::Matrix2Xd a_points(2, n);
  Eigen::Matrix2Xd b_points(2, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    a_points.col(i) = a.mean(a.landmark(pairs[static_cast<std::size_t>(i)].prediction));
    b_points.col(i) = b.mean(b.landmark(pairs[static_cast<std::size_t>(i)].observation));
  }
  const auto a_T_b = align_points(a_points, b_points, Eigen::VectorXd());
  if (!a_T_b) {
    throw NotPositiveDefinite("relative pose", "maps at bases " + std::to_string(a.base) + " and " + std::to_string(b.base) +
                                                   " share fewer than two distinct landmarks and no base frame");
  }
  return *a_T_b;
}

FusionSolution solve_fusion(FusionConstraints& constraints, const Se2& start, const std::string& name) {
  FusionSolution solution;
  solution.a_T_b = start;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const Eigen::Matrix2d R = solution.R = solution.a_T_b.rotation();
    constraints.linearize(solution.a_T_b, R);
    Eigen::MatrixXd S = constraints.covariance(R);
    S.diagonal().array() += kConstraintVariance;
    const Eigen::MatrixXd& L = solution.L = cholesky_lower(S, "constraint covariance", name.c_str());
    solution.LiJ = L.triangularView<Eigen::Lower>().solve(constraints.J);
    const Eigen::VectorXd Lic = L.triangularView<Eigen::Lower>().solve(constraints.at_prior(R));
    const Eigen::LLT<Eigen::Matrix3d> information(solution.LiJ.transpose() * solution.LiJ);
    if (information.info() != Eigen::Success) throw NotPositiveDefinite("relative pose", name);
    solution.C = information.solve(Eigen::Matrix3d::Identity());
    const Eigen::Vector3d step = -solution.C * (solution.LiJ.transpose() * Lic);  // (J-9)
    const Eigen::VectorXd whitened = Lic + solution.LiJ * step;
    solution.gain = L.transpose().triangularView<Eigen::Upper>().solve(whitened);
    constraints.move(solution.gain, R);  // (J-10)
    solution.a_T_b = additive_step(solution.a_T_b, step);
    solution.chi_squared = whitened.squaredNorm();
  }
  return solution;
}

}  // namespace ssjs
