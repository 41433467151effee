#include "ssjs/joining/relative_map.hpp"

#include <algorithm>
#include <string>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

constexpr double kSettled = 1e-9;  // m and rad: a smaller change of the links ends the iteration

/// P J' for a J of three rows: column after column of P, so that the large factor is read once and nothing is packed.
Eigen::Matrix<double, Eigen::Dynamic, 3> times_transposed(const Eigen::Ref<const Eigen::MatrixXd>& P,
                                                          const Eigen::Matrix<double, 3, Eigen::Dynamic>& J) {
  Eigen::Matrix<double, Eigen::Dynamic, 3> W = Eigen::MatrixXd::Zero(P.rows(), 3);
  for (Eigen::Index c = 0; c < P.cols(); ++c) {
    for (Eigen::Index row = 0; row < 3; ++row) W.col(row) += J(row, c) * P.col(c);
  }
  return W;
}

}  // namespace

void RelativeMap::append(const GaussianSe2& link) {
  const Eigen::Index n = size();
  if (P_.rows() < n + 3) P_.conservativeResize(2 * (n + 3), 2 * (n + 3));
  P_.block(n, 0, 3, n).setZero();
  P_.block(0, n, n, 3).setZero();
  P_.block<3, 3>(n, n) = link.covariance;
  links_.push_back(link.mean);
  global_T_base_.push_back(global_T_base_.back() * link.mean);
}

RelativeMap::Chain RelativeMap::chain(const std::vector<Se2>& links, int i, int j) {
  const auto from = links.begin() + i;
  const auto n = static_cast<std::size_t>(j - i);
  std::vector<Se2> rest(n + 1);  // tau_kj
  for (std::size_t k = n; k-- > 0;) rest[k] = from[static_cast<std::ptrdiff_t>(k)] * rest[k + 1];
  Chain chain{rest.front(), Eigen::Matrix<double, 3, Eigen::Dynamic>(3, static_cast<Eigen::Index>(3 * n))};
  Se2 before;  // tau_ik
  for (std::size_t k = 0; k < n; ++k) {
    const Se2& link = from[static_cast<std::ptrdiff_t>(k)];
    chain.J.middleCols<3>(static_cast<Eigen::Index>(3 * k)) = compose_jacobian_right(before) * compose_jacobian_left(link, rest[k + 1]);
    before = before * link;
  }
  return chain;
}

GaussianSe2 RelativeMap::relative(int i, int j) const {
  const Chain tau = chain(links_, i, j);
  const Eigen::Index n = tau.J.cols();
  return {tau.i_T_j, tau.J * times_transposed(P_.block(3 * Eigen::Index{i}, 3 * Eigen::Index{i}, n, n), tau.J)};
}

std::vector<GaussianSe2> RelativeMap::all_relative_to(int j) const {
  // Backwards along the chain with W = Cov(links, tau_kj): one link more costs O(links), not O(links^2).
  std::vector<GaussianSe2> tau(static_cast<std::size_t>(j) + 1);
  const Eigen::Index n = 3 * Eigen::Index{j};
  Eigen::MatrixXd W = Eigen::MatrixXd::Zero(n, 3);
  for (int k = j - 1; k >= 0; --k) {
    const Eigen::Index at = 3 * Eigen::Index{k};
    const GaussianSe2& rest = tau[static_cast<std::size_t>(k) + 1];
    const Eigen::Matrix3d J_link = compose_jacobian_left(links_[static_cast<std::size_t>(k)], rest.mean);
    const Eigen::Matrix3d J_rest = compose_jacobian_right(links_[static_cast<std::size_t>(k)]);
    const Eigen::Matrix3d link_rest = W.middleRows<3>(at);
    const Eigen::Matrix3d cross = J_link * link_rest * J_rest.transpose();
    tau[static_cast<std::size_t>(k)] = {
        links_[static_cast<std::size_t>(k)] * rest.mean,
        J_link * P_.block<3, 3>(at, at) * J_link.transpose() + cross + cross.transpose() + J_rest * rest.covariance * J_rest.transpose()};
    W = (W * J_rest.transpose()).eval();
    W.noalias() += P_.block(0, at, n, 3) * J_link.transpose();
  }
  return tau;
}

Eigen::MatrixXd RelativeMap::base_covariance() const {
  const Eigen::Index n = size();
  const auto bases = static_cast<Eigen::Index>(global_T_base_.size());
  // X_{k+1} = X_k (+) t_k, applied to the rows and then to the columns.
  const auto accumulate = [&](const Eigen::MatrixXd& of_links) {
    Eigen::MatrixXd of_bases = Eigen::MatrixXd::Zero(3 * bases, of_links.cols());
    for (Eigen::Index k = 0; k + 1 < bases; ++k) {
      const Se2& global_T_base = global_T_base_[static_cast<std::size_t>(k)];
      of_bases.middleRows<3>(3 * k + 3).noalias() =
          compose_jacobian_left(global_T_base, links_[static_cast<std::size_t>(k)]) * of_bases.middleRows<3>(3 * k);
      of_bases.middleRows<3>(3 * k + 3).noalias() += compose_jacobian_right(global_T_base) * of_links.middleRows<3>(3 * k);
    }
    return of_bases;
  };
  const Eigen::MatrixXd rows = accumulate(P_.topLeftCorner(n, n));
  const Eigen::MatrixXd joint = accumulate(rows.transpose());
  return 0.5 * (joint + joint.transpose());
}

void RelativeMap::observe(int i, int j, const GaussianSe2& i_T_j, int max_iterations) {
  if (!(0 <= i && i < j && j <= newest_base())) throw InvalidArgument("i, j", static_cast<double>(j), "0 <= i < j <= newest base");
  const Eigen::Index n = size();
  const Eigen::Index from = 3 * Eigen::Index{i};
  const Eigen::Index inside = 3 * Eigen::Index{j - i};
  const std::vector<Se2> prior = links_;
  const std::string name = "loop between the bases " + std::to_string(i) + " and " + std::to_string(j);
  const auto move = [&](int first, int last, const Eigen::Ref<const Eigen::MatrixXd>& W, const Eigen::Vector3d& gain) {  // (H-2)
    double change = 0.0;
    for (int k = first; k < last; ++k) {
      const auto at = static_cast<std::size_t>(k);
      const Se2 updated = additive_step(prior[at], W.middleRows<3>(3 * Eigen::Index{k - first}) * gain);
      change = std::max(change, additive_difference(updated, links_[at]).lpNorm<Eigen::Infinity>());
      links_[at] = updated;
    }
    return change;
  };
  Chain tau;
  Eigen::MatrixXd L;
  Eigen::Vector3d gain;
  for (int iteration = 0; iteration < max_iterations; ++iteration) {  // only the links inside the loop are in the constraint
    tau = chain(links_, i, j);
    const Eigen::Matrix<double, Eigen::Dynamic, 3> W = times_transposed(P_.block(from, from, inside, inside), tau.J);
    L = cholesky_lower(tau.J * W + i_T_j.covariance, "innovation covariance of a loop", name.c_str());
    Eigen::Vector3d innovation = additive_difference(i_T_j.mean, tau.i_T_j);
    for (int k = i; k < j; ++k) {
      const auto at = static_cast<std::size_t>(k);
      innovation -= tau.J.middleCols<3>(3 * Eigen::Index{k - i}) * additive_difference(prior[at], links_[at]);
    }
    const Eigen::Vector3d half = L.triangularView<Eigen::Lower>().solve(innovation);
    gain = L.transpose().triangularView<Eigen::Upper>().solve(half);
    if (!(move(i, j, W, gain) > kSettled)) break;
  }
  const Eigen::Matrix<double, Eigen::Dynamic, 3> W = times_transposed(P_.block(0, from, n, inside), tau.J);
  move(0, newest_base(), W, gain);
  const Eigen::MatrixXd Y = L.triangularView<Eigen::Lower>().solve(W.transpose()).transpose();
  for (Eigen::Index c = 0; c < n; ++c) P_.col(c).head(n).noalias() -= Y * Y.row(c).transpose();  // (H-3)
  for (std::size_t k = 0; k < links_.size(); ++k) global_T_base_[k + 1] = global_T_base_[k] * links_[k];
}

}  // namespace ssjs
