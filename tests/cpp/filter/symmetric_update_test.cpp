#include "ssjs/filter/symmetric_update.hpp"

#include <gtest/gtest.h>

#include "filter/dense_filter.hpp"

namespace ssjs {
namespace {

using testing::random_covariance;
using testing::random_matrix;

TEST(SymmetricDowndate, F7_EqualsTheDenseProductForEverySize) {
  Rng rng(321);
  SymmetricDowndate downdate;
  for (Eigen::Index n = 1; n <= 40; ++n) {
    for (Eigen::Index k = 1; k <= 9; ++k) {
      const Eigen::Index rows = (n + 3) / 4 * 4;
      const Eigen::MatrixXd Y = random_matrix(rng, n, k);
      const Eigen::MatrixXd before = random_covariance(rng, rows, 2.0);
      Eigen::MatrixXd P = before;
      downdate(Y, P);
      for (Eigen::Index c = 0; c < n; ++c) {
        for (Eigen::Index r = c; r < n; ++r) {
          const double expected = before(r, c) - Y.row(r).dot(Y.row(c));
          ASSERT_NEAR(P(r, c), expected, 1e-13 * static_cast<double>(1 + k)) << "n " << n << ", k " << k << " at " << r << ", " << c;
        }
      }
      // outside the leading n x n block nothing below the diagonal has moved
      for (Eigen::Index c = 0; c < rows; ++c) {
        for (Eigen::Index r = std::max(n, c); r < rows; ++r) ASSERT_EQ(P(r, c), before(r, c));
      }
    }
  }
}

TEST(SymmetricDowndate, F7_TakesABlockOfALargerMatrix) {
  Rng rng(322);
  const Eigen::MatrixXd workspace = random_matrix(rng, 30, 20);
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(24, 24);
  SymmetricDowndate downdate;
  downdate.reserve(24, 20);
  downdate(workspace.topLeftCorner(21, 5), P);
  const Eigen::MatrixXd expected = -workspace.topLeftCorner(21, 5) * workspace.topLeftCorner(21, 5).transpose();
  for (Eigen::Index c = 0; c < 21; ++c) {
    for (Eigen::Index r = c; r < 21; ++r) EXPECT_NEAR(P(r, c), expected(r, c), 1e-13);
  }
}

}  // namespace
}  // namespace ssjs
