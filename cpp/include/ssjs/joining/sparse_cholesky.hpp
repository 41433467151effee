/// Cholesky factor of a sparse symmetric matrix made of small blocks, and parts of its inverse. CHOLMOD (simplicial, AMD) stays in the
/// source file. docs/math/smoothing.md (B-9, B-10, B-15).
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace ssjs {

/// (row, column) of a block, row >= column.
using BlockPosition = std::pair<int, int>;

/// The matrix is kept as the blocks of its lower triangle. Order of use: set_pattern, then as often as wanted set_zero, add, factorize.
class SparseCholesky {
 public:
  SparseCholesky();
  ~SparseCholesky();
  SparseCholesky(SparseCholesky&&) noexcept;
  SparseCholesky& operator=(SparseCholesky&&) noexcept;

  /// Rows of every diagonal block, and the blocks that may be filled (repetitions are welcome; diagonal blocks are there by themselves).
  /// Finds the elimination order and the pattern of the factor.
  void set_pattern(const std::vector<int>& block_sizes, const std::vector<BlockPosition>& blocks);

  void set_zero();
  /// Adds to block (row, column); blocks of the upper triangle and blocks of a negative index (something held fixed) are passed over.
  template <int Rows, int Columns>
  void add(int row, int column, const Eigen::Matrix<double, Rows, Columns>& block) {
    if (row < column || column < 0) return;
    const Place place = find(row, column);
    Eigen::Map<Eigen::Matrix<double, Rows, Columns>, 0, Eigen::OuterStride<>>(place.first, block.rows(), block.cols(),
                                                                              Eigen::OuterStride<>(place.stride)) += block;
  }
  [[nodiscard]] Eigen::VectorXd diagonal() const;
  void set_diagonal(const Eigen::VectorXd& diagonal);
  [[nodiscard]] bool all_finite() const;

  /// Where the matrix is not positive definite: the block of the first pivot that is not positive. Nothing when it is.
  [[nodiscard]] std::optional<int> factorize();

  /// Columns of A^-1 right, by the last factor.
  [[nodiscard]] Eigen::MatrixXd solve(const Eigen::MatrixXd& right) const;

  /// The rows and columns of A^-1 that belong to these blocks, in this order, by the last factor. With C the rows on the ways from theirs
  /// to the root of the elimination tree, A^-1 over C is (L_CC L_CC')^-1 whatever lies outside (B-15): the price is that of the ways, not
  /// of the whole factor.
  [[nodiscard]] Eigen::MatrixXd joint_inverse(const std::vector<int>& blocks) const;

  /// The inverse at every position of the factor's pattern (B-10), by the last factor; about the price of the factor itself.
  void invert_pattern();
  /// A block of the inverse: within the pattern of the matrix, after invert_pattern(). Otherwise InvalidArgument.
  [[nodiscard]] Eigen::MatrixXd inverse_block(int row, int column) const;

  [[nodiscard]] Eigen::Index rows() const { return starts_.empty() ? 0 : static_cast<Eigen::Index>(starts_.back()); }
  [[nodiscard]] Eigen::Index row_of(int block) const { return static_cast<Eigen::Index>(starts_[static_cast<std::size_t>(block)]); }
  /// Of the last factorisation: multiply-adds it took, and entries of the factor.
  [[nodiscard]] double factor_flops() const;
  [[nodiscard]] double factor_entries() const;

 private:
  struct Place {
    double* first;
    std::ptrdiff_t stride;
  };
  [[nodiscard]] Place find(int row, int column);

  struct Factor;                                ///< CHOLMOD's
  std::vector<int> starts_;                     ///< first row of every block, then the number of rows
  std::vector<std::vector<int>> row_blocks_;    ///< of every column of blocks, ascending
  std::vector<std::vector<int>> row_offsets_;   ///< of each of them inside the column
  std::vector<int> heights_;                    ///< of every column of blocks
  std::vector<int> column_starts_, row_index_;  ///< compressed columns; the upper part of a diagonal block is stored and ignored
  std::vector<double> values_;
  std::unique_ptr<Factor> factor_;
};

}  // namespace ssjs
