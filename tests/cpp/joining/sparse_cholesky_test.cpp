#include "ssjs/joining/sparse_cholesky.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "joining/gaussian_world.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using testing::normal_vector;

constexpr double kTolerance = 1e-10;

/// J'J of factors between random blocks of 3 and 2 rows, sparse and dense.
struct RandomMatrix {
  std::vector<int> sizes;
  std::vector<BlockPosition> blocks;
  Eigen::MatrixXd dense;
  SparseCholesky sparse;

  explicit RandomMatrix(Rng& rng, int count = 30) {
    std::vector<Eigen::Index> starts;
    Eigen::Index rows = 0;
    for (int i = 0; i < count; ++i) {
      starts.push_back(rows);
      sizes.push_back(i < 2 * count / 3 ? 3 : 2);
      rows += sizes.back();
    }
    dense = Eigen::MatrixXd::Zero(rows, rows);
    for (int i = 1; i < count; ++i) blocks.emplace_back(i, i - 1);
    for (int i = 0; i < count; ++i) {
      const int a = static_cast<int>(rng.uniform(0.0, count));
      const int b = static_cast<int>(rng.uniform(0.0, count));
      blocks.emplace_back(std::max(a, b), std::min(a, b));
    }
    sparse.set_pattern(sizes, blocks);
    sparse.set_zero();
    for (const auto& [a, b] : blocks) {
      const Eigen::Index n_a = sizes[static_cast<std::size_t>(a)];
      const Eigen::Index n_b = sizes[static_cast<std::size_t>(b)];
      Eigen::MatrixXd J_a(4, n_a);
      Eigen::MatrixXd J_b(4, n_b);
      for (Eigen::Index c = 0; c < n_a; ++c) J_a.col(c) = normal_vector(rng, 4);
      for (Eigen::Index c = 0; c < n_b; ++c) J_b.col(c) = normal_vector(rng, 4);
      add(a, a, J_a.transpose() * J_a, starts);
      if (a == b) continue;
      add(b, b, J_b.transpose() * J_b, starts);
      add(a, b, J_a.transpose() * J_b, starts);
      add(b, a, J_b.transpose() * J_a, starts);  // the upper triangle: passed over by the sparse one
    }
  }
  void add(int a, int b, const Eigen::MatrixXd& block, const std::vector<Eigen::Index>& starts) {
    dense.block(starts[static_cast<std::size_t>(a)], starts[static_cast<std::size_t>(b)], block.rows(), block.cols()) += block;
    if (block.rows() == 3 && block.cols() == 3) sparse.add<3, 3>(a, b, block);
    if (block.rows() == 3 && block.cols() == 2) sparse.add<3, 2>(a, b, block);
    if (block.rows() == 2 && block.cols() == 3) sparse.add<2, 3>(a, b, block);
    if (block.rows() == 2 && block.cols() == 2) sparse.add<2, 2>(a, b, block);
  }
};

TEST(SparseCholesky, SolvesLikeTheDenseMatrix) {
  Rng rng(901);
  for (int round = 0; round < 10; ++round) {
    RandomMatrix matrix(rng);
    ASSERT_FALSE(matrix.sparse.factorize().has_value());
    EXPECT_TRUE(matrix.sparse.diagonal().isApprox(matrix.dense.diagonal(), kTolerance));
    const Eigen::MatrixXd right = normal_vector(rng, matrix.dense.rows());
    EXPECT_LE((matrix.dense * matrix.sparse.solve(right) - right).norm(), 1e-8 * right.norm());
  }
}

TEST(SparseCholesky, B15_JointInverseOfBlocksAnywhere) {
  Rng rng(903);
  for (int round = 0; round < 10; ++round) {
    RandomMatrix matrix(rng);
    ASSERT_FALSE(matrix.sparse.factorize().has_value());
    const Eigen::MatrixXd inverse = matrix.dense.inverse();
    const std::vector<int> all_of_it = [] {
      std::vector<int> blocks;
      for (int i = 29; i >= 0; --i) blocks.push_back(i);
      return blocks;
    }();
    for (const std::vector<int>& blocks : {std::vector<int>{17}, std::vector<int>{25, 3, 11}, all_of_it}) {
      const Eigen::MatrixXd joint = matrix.sparse.joint_inverse(blocks);
      Eigen::Index i = 0;
      for (const int a : blocks) {
        Eigen::Index j = 0;
        for (const int b : blocks) {
          const Eigen::Index n_a = matrix.sizes[static_cast<std::size_t>(a)], n_b = matrix.sizes[static_cast<std::size_t>(b)];
          const Eigen::MatrixXd expected = inverse.block(matrix.sparse.row_of(a), matrix.sparse.row_of(b), n_a, n_b);
          EXPECT_LE((joint.block(i, j, n_a, n_b) - expected).cwiseAbs().maxCoeff(), 1e-8 * inverse.cwiseAbs().maxCoeff());
          j += n_b;
        }
        i += matrix.sizes[static_cast<std::size_t>(a)];
      }
      EXPECT_EQ(joint.rows(), i);
    }
  }
}

TEST(SparseCholesky, B10_InverseWithinThePattern) {
  Rng rng(902);
  for (int round = 0; round < 10; ++round) {
    RandomMatrix matrix(rng);
    ASSERT_FALSE(matrix.sparse.factorize().has_value());
    EXPECT_THROW((void)matrix.sparse.inverse_block(0, 0), InvalidArgument);
    matrix.sparse.invert_pattern();
    const Eigen::MatrixXd inverse = matrix.dense.inverse();
    const double scale = inverse.cwiseAbs().maxCoeff();
    for (int i = 0; i < 30; ++i) matrix.blocks.emplace_back(i, i);
    for (const auto& [a, b] : matrix.blocks) {
      const Eigen::MatrixXd block = matrix.sparse.inverse_block(a, b);
      const Eigen::MatrixXd expected = inverse.block(matrix.sparse.row_of(a), matrix.sparse.row_of(b), block.rows(), block.cols());
      EXPECT_LE((block - expected).cwiseAbs().maxCoeff(), 1e-8 * scale);
      EXPECT_LE((matrix.sparse.inverse_block(b, a) - expected.transpose()).cwiseAbs().maxCoeff(), 1e-8 * scale);
    }
  }
}

TEST(SparseCholesky, RefusesABlockOfTheInverseOutsideThePattern) {
  SparseCholesky chain;  // three scalars in a chain: whichever goes first, the ends are not tied to each other
  chain.set_pattern({1, 1, 1}, {{1, 0}, {2, 1}});
  chain.set_diagonal(Eigen::Vector3d(2.0, 2.0, 2.0));
  ASSERT_FALSE(chain.factorize().has_value());
  chain.invert_pattern();
  EXPECT_NEAR(chain.inverse_block(1, 1)(0, 0), 0.5, kTolerance);
  EXPECT_THROW((void)chain.inverse_block(2, 0), InvalidArgument);
}

TEST(SparseCholesky, NamesTheBlockThatIsLoose) {
  SparseCholesky matrix;
  matrix.set_pattern({3, 2, 3}, {});
  Eigen::VectorXd diagonal = Eigen::VectorXd::Ones(8);
  diagonal(4) = 0.0;  // second row of block 1
  matrix.set_diagonal(diagonal);
  EXPECT_EQ(matrix.factorize(), std::optional<int>(1));
  diagonal(4) = 3.0;
  matrix.set_diagonal(diagonal);
  EXPECT_EQ(matrix.factorize(), std::nullopt);
  diagonal(0) = std::nan("");
  matrix.set_diagonal(diagonal);
  EXPECT_FALSE(matrix.all_finite());
}

}  // namespace
}  // namespace ssjs
