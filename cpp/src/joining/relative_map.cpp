#include "ssjs/joining/relative_map.hpp"

#include <algorithm>
#include <string>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

constexpr double kSettled = 1e-9;  // m and rad: a smaller change of the links ends the iteration

/// The chains tau_kj = t_k (+) tau_{k+1,j}, k = first..j, that end at one base. Their Jacobians over the links first..j-1 are never
/// formed: a product with all of them costs one walk along the links, whatever the number of chains (H-1).
class ChainsTo {
 public:
  ChainsTo(const std::vector<Se2>& links, int first, int j) : first_(first), tau_(static_cast<std::size_t>(j - first) + 1) {
    steps_.resize(tau_.size() - 1);
    for (std::size_t k = steps_.size(); k-- > 0;) {
      const Se2& link = links[static_cast<std::size_t>(first) + k];
      tau_[k] = link * tau_[k + 1];
      steps_[k] = {compose_jacobian_left(link, tau_[k + 1]), compose_jacobian_right(link)};
    }
  }
  [[nodiscard]] const Se2& from(int k) const { return tau_[static_cast<std::size_t>(k - first_)]; }

  /// H X, 3 rows a chain. X: 3 rows for each of the links first..j-1.
  [[nodiscard]] Eigen::MatrixXd times(const std::vector<int>& starts, const Eigen::Ref<const Eigen::MatrixXd>& X) const {
    Eigen::MatrixXd HX(static_cast<Eigen::Index>(3 * starts.size()), X.cols());
    Eigen::Matrix<double, 3, Eigen::Dynamic> of_chain = Eigen::MatrixXd::Zero(3, X.cols());
    for (std::size_t k = steps_.size(); k-- > 0;) {
      of_chain = (steps_[k].J_rest.lazyProduct(of_chain)).eval();
      of_chain += steps_[k].J_link.lazyProduct(X.middleRows<3>(static_cast<Eigen::Index>(3 * k)));
      for_each_start(starts, k, [&](Eigen::Index at) { HX.middleRows<3>(at) = of_chain; });
    }
    return HX;
  }
  /// X H', 3 columns a chain. X: 3 columns for each of the links first..j-1.
  [[nodiscard]] Eigen::MatrixXd times_transposed(const Eigen::Ref<const Eigen::MatrixXd>& X, const std::vector<int>& starts) const {
    Eigen::MatrixXd XHt(X.rows(), static_cast<Eigen::Index>(3 * starts.size()));
    Eigen::Matrix<double, Eigen::Dynamic, 3> of_chain = Eigen::MatrixXd::Zero(X.rows(), 3);
    for (std::size_t k = steps_.size(); k-- > 0;) {
      of_chain = (of_chain.lazyProduct(steps_[k].J_rest.transpose())).eval();
      of_chain += X.middleCols<3>(static_cast<Eigen::Index>(3 * k)).lazyProduct(steps_[k].J_link.transpose());
      for_each_start(starts, k, [&](Eigen::Index at) { XHt.middleCols<3>(at) = of_chain; });
    }
    return XHt;
  }

 private:
  /// tau_kj's derivatives by t_k and by tau_{k+1,j}.
  struct Step {
    Eigen::Matrix3d J_link, J_rest;
  };
  template <class Use>
  void for_each_start(const std::vector<int>& starts, std::size_t k, Use use) const {
    for (std::size_t l = 0; l < starts.size(); ++l) {
      if (starts[l] - first_ == static_cast<int>(k)) use(static_cast<Eigen::Index>(3 * l));
    }
  }

  int first_;
  std::vector<Se2> tau_;
  std::vector<Step> steps_;
};

}  // namespace

void RelativeMap::append(const GaussianSe2& link) {
  const Eigen::Index n = size();
  if (P_.rows() < n + 3) P_.conservativeResize(n + n / 4 + 3, n + n / 4 + 3);
  P_.block(n, 0, 3, n).setZero();
  P_.block(0, n, n, 3).setZero();
  P_.block<3, 3>(n, n) = link.covariance;
  links_.push_back(link.mean);
  global_T_base_.push_back(global_T_base_.back() * link.mean);
}

GaussianSe2 RelativeMap::relative(int i, int j) const {
  if (i == j) return {};
  const ChainsTo chains(links_, i, j);
  const Eigen::Index from = 3 * Eigen::Index{i};
  const Eigen::Index inside = 3 * Eigen::Index{j - i};
  return {chains.from(i), chains.times({i}, chains.times_transposed(P_.block(from, from, inside, inside), {i}))};
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

void RelativeMap::observe(int j, const std::vector<ObservedLink>& observed, int max_iterations) {
  if (observed.empty()) return;
  std::vector<int> starts;
  for (const ObservedLink& link : observed) {
    if (!(0 <= link.i && link.i < j && j <= newest_base())) {
      throw InvalidArgument("i, j", std::to_string(link.i) + ", " + std::to_string(j), "0 <= i < j <= newest base");
    }
    starts.push_back(link.i);
  }
  const int first = *std::min_element(starts.begin(), starts.end());
  const Eigen::Index n = size();
  const Eigen::Index from = 3 * Eigen::Index{first};
  const Eigen::Index inside = 3 * Eigen::Index{j - first};
  const auto rows = static_cast<Eigen::Index>(3 * observed.size());
  const std::string name = "loops between the base " + std::to_string(j) + " and " + std::to_string(observed.size()) + " others";
  const std::vector<Se2> prior = links_;
  const auto move = [&](int begin, const Eigen::Ref<const Eigen::VectorXd>& step) {  // (H-2): step counts from link `begin`
    double change = 0.0;
    for (Eigen::Index at = 0; at < step.size(); at += 3) {
      const auto k = static_cast<std::size_t>(begin + at / 3);
      const Se2 updated = additive_step(prior[k], step.segment<3>(at));
      change = std::max(change, additive_difference(updated, links_[k]).lpNorm<Eigen::Infinity>());
      links_[k] = updated;
    }
    return change;
  };
  Eigen::MatrixXd L;
  Eigen::VectorXd gain(rows);
  for (int iteration = 0; iteration < max_iterations; ++iteration) {  // only the links inside the loops are in the constraints
    const ChainsTo chains(links_, first, j);
    const Eigen::MatrixXd W = chains.times_transposed(P_.block(from, from, inside, inside), starts);
    Eigen::MatrixXd S = chains.times(starts, W);
    Eigen::VectorXd moved(inside);  // t^0 - t^m
    for (Eigen::Index at = 0; at < inside; at += 3) {
      const auto k = static_cast<std::size_t>(first + at / 3);
      moved.segment<3>(at) = additive_difference(prior[k], links_[k]);
    }
    gain = -chains.times(starts, moved);
    for (Eigen::Index at = 0; at < rows; at += 3) {
      const ObservedLink& link = observed[static_cast<std::size_t>(at / 3)];
      gain.segment<3>(at) += additive_difference(link.i_T_j.mean, chains.from(link.i));
      S.block<3, 3>(at, at) += link.i_T_j.covariance;
    }
    L = cholesky_lower(S, "innovation covariance of loops", name.c_str());
    L.triangularView<Eigen::Lower>().solveInPlace(gain);
    L.transpose().triangularView<Eigen::Upper>().solveInPlace(gain);
    const bool is_last = iteration + 1 == max_iterations;
    Eigen::VectorXd step(inside);
    step.noalias() = W * gain;
    const bool settled = !(move(first, step) > kSettled);
    if (!settled && !is_last) continue;
    Eigen::MatrixXd Y = chains.times_transposed(P_.block(0, from, n, inside), starts);  // linearised where the gain was
    move(0, Y * gain);
    L.transpose().triangularView<Eigen::Upper>().solveInPlace<Eigen::OnTheRight>(Y);
    auto P = P_.topLeftCorner(n, n);
    P.selfadjointView<Eigen::Lower>().rankUpdate(Y, -1.0);  // (H-3)
    mirror_lower(P);
    break;
  }
  for (std::size_t k = 0; k < links_.size(); ++k) global_T_base_[k + 1] = global_T_base_[k] * links_[k];
}

}  // namespace ssjs
