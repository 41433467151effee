#include "ssjs/filter/whitening.hpp"

#include <cmath>

namespace ssjs {

std::optional<Eigen::Index> whiten(Eigen::Ref<Eigen::MatrixXd> S, Eigen::Ref<Eigen::MatrixXd> PHt, Eigen::Ref<Eigen::VectorXd> innovation) {
  const Eigen::Index k = S.cols();
  for (Eigen::Index j = 0; j < k; ++j) {
    for (Eigen::Index i = 0; i < j; ++i) {
      const double L_ji = S(j, i);
      S.col(j).tail(k - j) -= L_ji * S.col(i).tail(k - j);
      PHt.col(j) -= L_ji * PHt.col(i);
      innovation(j) -= L_ji * innovation(i);
    }
    if (!(S(j, j) > 0.0)) return j;
    const double scale = 1.0 / std::sqrt(S(j, j));
    S.col(j).tail(k - j) *= scale;
    PHt.col(j) *= scale;
    innovation(j) *= scale;
  }
  return std::nullopt;
}

}  // namespace ssjs
