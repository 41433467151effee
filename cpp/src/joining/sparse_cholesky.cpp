#include "ssjs/joining/sparse_cholesky.hpp"

#include <cholmod.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace

struct SparseCholesky::Factor {
  cholmod_common common{};
  cholmod_factor* L = nullptr;
  std::vector<int> place_of_row;  // in the elimination order
  std::vector<double> inverse;    // in the order of L's entries
  std::vector<int> block_of_row;

  Factor() {
    cholmod_start(&common);
    common.supernodal = CHOLMOD_SIMPLICIAL;  // the LGPL part, and deterministic
    common.final_ll = 1;
    common.nmethods = 1;
    common.method[0].ordering = CHOLMOD_AMD;
    common.postorder = 1;
    common.print = 0;
  }
  Factor(const Factor&) = delete;
  Factor& operator=(const Factor&) = delete;
  ~Factor() {
    cholmod_free_factor(&L, &common);
    cholmod_finish(&common);
  }

  [[nodiscard]] const int* column_starts() const { return static_cast<const int*>(L->p); }
  [[nodiscard]] const int* column_lengths() const { return static_cast<const int*>(L->nz); }
  [[nodiscard]] const int* rows() const { return static_cast<const int*>(L->i); }
  [[nodiscard]] const double* values() const { return static_cast<const double*>(L->x); }
};

SparseCholesky::SparseCholesky() : factor_(std::make_unique<Factor>()) {}
SparseCholesky::~SparseCholesky() = default;
SparseCholesky::SparseCholesky(SparseCholesky&&) noexcept = default;
SparseCholesky& SparseCholesky::operator=(SparseCholesky&&) noexcept = default;

namespace {

/// CHOLMOD's view of the compressed columns.
cholmod_sparse view_of(std::vector<int>& column_starts, std::vector<int>& row_index, std::vector<double>& values) {
  cholmod_sparse view{};
  view.nrow = view.ncol = column_starts.size() - 1;
  view.nzmax = values.size();
  view.p = column_starts.data();
  view.i = row_index.data();
  view.x = values.data();
  view.stype = -1;  // lower triangle
  view.itype = CHOLMOD_INT;
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  view.sorted = 1;
  view.packed = 1;
  return view;
}

}  // namespace

void SparseCholesky::set_pattern(const std::vector<int>& block_sizes, const std::vector<BlockPosition>& blocks) {
  const std::size_t count = block_sizes.size();
  starts_.assign(1, 0);
  factor_->block_of_row.clear();
  for (std::size_t block = 0; block < count; ++block) {
    starts_.push_back(starts_.back() + block_sizes[block]);
    factor_->block_of_row.insert(factor_->block_of_row.end(), at(block_sizes[block]), static_cast<int>(block));
  }
  row_blocks_.assign(count, {});
  for (std::size_t block = 0; block < count; ++block) row_blocks_[block].push_back(static_cast<int>(block));
  for (const auto& [row, column] : blocks) row_blocks_[at(column)].push_back(row);

  row_offsets_.assign(count, {});
  heights_.assign(count, 0);
  column_starts_.clear();
  row_index_.clear();
  for (std::size_t column = 0; column < count; ++column) {
    std::vector<int>& rows = row_blocks_[column];
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    for (const int row : rows) {
      row_offsets_[column].push_back(heights_[column]);
      heights_[column] += block_sizes[at(row)];
    }
    for (int c = 0; c < block_sizes[column]; ++c) {
      column_starts_.push_back(static_cast<int>(row_index_.size()));
      for (const int row : rows) {
        for (int r = starts_[at(row)]; r < starts_[at(row) + 1]; ++r) row_index_.push_back(r);
      }
    }
  }
  column_starts_.push_back(static_cast<int>(row_index_.size()));
  values_.assign(row_index_.size(), 0.0);

  cholmod_free_factor(&factor_->L, &factor_->common);
  factor_->inverse.clear();
  cholmod_sparse matrix = view_of(column_starts_, row_index_, values_);
  factor_->L = cholmod_analyze(&matrix, &factor_->common);
  const auto* const order = static_cast<const int*>(factor_->L->Perm);
  factor_->place_of_row.resize(at(starts_.back()));
  for (int place = 0; place < starts_.back(); ++place) factor_->place_of_row[at(order[place])] = place;
}

void SparseCholesky::set_zero() { std::fill(values_.begin(), values_.end(), 0.0); }

SparseCholesky::Place SparseCholesky::find(int row, int column) {
  const std::vector<int>& rows = row_blocks_[at(column)];
  const auto place = static_cast<std::size_t>(std::lower_bound(rows.begin(), rows.end(), row) - rows.begin());
  return {values_.data() + column_starts_[at(starts_[at(column)])] + row_offsets_[at(column)][place], heights_[at(column)]};
}

Eigen::VectorXd SparseCholesky::diagonal() const {
  Eigen::VectorXd diagonal(rows());
  for (std::size_t block = 0; block < row_blocks_.size(); ++block) {  // a column of blocks begins with its diagonal block
    for (int r = starts_[block]; r < starts_[block + 1]; ++r) diagonal(r) = values_[at(column_starts_[at(r)] + r - starts_[block])];
  }
  return diagonal;
}

void SparseCholesky::set_diagonal(const Eigen::VectorXd& diagonal) {
  for (std::size_t block = 0; block < row_blocks_.size(); ++block) {
    for (int r = starts_[block]; r < starts_[block + 1]; ++r) values_[at(column_starts_[at(r)] + r - starts_[block])] = diagonal(r);
  }
}

bool SparseCholesky::all_finite() const {
  return std::all_of(values_.begin(), values_.end(), [](double value) { return std::isfinite(value); });
}

std::optional<int> SparseCholesky::factorize() {
  factor_->inverse.clear();
  cholmod_sparse matrix = view_of(column_starts_, row_index_, values_);
  cholmod_factorize(&matrix, factor_->L, &factor_->common);
  if (factor_->common.status == CHOLMOD_OK) return std::nullopt;
  const std::size_t column = factor_->L->minor < factor_->L->n ? factor_->L->minor : 0;
  return factor_->block_of_row[at(static_cast<const int*>(factor_->L->Perm)[column])];
}

Eigen::MatrixXd SparseCholesky::solve(const Eigen::MatrixXd& right) const {
  cholmod_dense view{};
  view.nrow = static_cast<std::size_t>(right.rows());
  view.ncol = static_cast<std::size_t>(right.cols());
  view.d = view.nrow;
  view.nzmax = view.nrow * view.ncol;
  view.x = const_cast<double*>(right.data());
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  cholmod_dense* answer = cholmod_solve(CHOLMOD_A, factor_->L, &view, &factor_->common);
  Eigen::MatrixXd result = Eigen::Map<const Eigen::MatrixXd>(static_cast<const double*>(answer->x), right.rows(), right.cols());
  cholmod_free_dense(&answer, &factor_->common);
  return result;
}

Eigen::MatrixXd SparseCholesky::joint_inverse(const std::vector<int>& blocks) const {
  const int* const starts = factor_->column_starts();
  const int* const lengths = factor_->column_lengths();
  const int* const rows = factor_->rows();
  const double* const L = factor_->values();
  std::vector<std::pair<int, int>> asked;  // place in the elimination order, row of the answer
  for (const int block : blocks) {
    for (int r = starts_[at(block)]; r < starts_[at(block) + 1]; ++r) {
      asked.emplace_back(factor_->place_of_row[at(r)], static_cast<int>(asked.size()));
    }
  }
  std::sort(asked.begin(), asked.end());
  std::vector<int> ways;  // C, ascending
  std::vector<int> nth(factor_->L->n, -1);
  for (const auto& [place, row] : asked) {
    for (int j = place; nth[at(j)] < 0;) {  // the parent of a column is its first row below the diagonal
      nth[at(j)] = 0;
      ways.push_back(j);
      if (lengths[j] == 1) break;
      j = rows[starts[j] + 1];
    }
  }
  std::sort(ways.begin(), ways.end());
  for (std::size_t i = 0; i < ways.size(); ++i) nth[at(ways[i])] = static_cast<int>(i);

  // (B-15): Y = L_CC^-1 E, some columns at a time and a row's entries side by side; A^-1 = Y' Y
  constexpr Eigen::Index kTogether = 32;
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const auto size = static_cast<Eigen::Index>(asked.size());
  Rows Y = Rows::Zero(static_cast<Eigen::Index>(ways.size()), size);
  Rows part;
  std::vector<char> reached(ways.size());
  for (Eigen::Index first = 0; first < size; first += kTogether) {
    const Eigen::Index count = std::min(kTogether, size - first);
    part.setZero(Y.rows(), count);
    std::fill(reached.begin(), reached.end(), 0);
    for (Eigen::Index c = 0; c < count; ++c) {
      const int row = nth[at(asked[static_cast<std::size_t>(first + c)].first)];
      part(row, c) = 1.0;
      reached[at(row)] = 1;
    }
    for (std::size_t i = static_cast<std::size_t>(nth[at(asked[static_cast<std::size_t>(first)].first)]); i < ways.size(); ++i) {
      if (reached[i] == 0) continue;
      const int j = ways[i];
      auto solved = part.row(static_cast<Eigen::Index>(i));
      solved *= 1.0 / L[starts[j]];
      for (int e = starts[j] + 1; e < starts[j] + lengths[j]; ++e) {
        const int below = nth[at(rows[e])];
        part.row(below) -= L[e] * solved;
        reached[at(below)] = 1;
      }
    }
    Y.middleCols(first, count) = part;
  }
  const Eigen::MatrixXd ordered = Y.transpose() * Y;
  Eigen::MatrixXd inverse(size, size);
  for (Eigen::Index j = 0; j < size; ++j) {
    for (Eigen::Index i = 0; i < size; ++i) {
      inverse(asked[static_cast<std::size_t>(i)].second, asked[static_cast<std::size_t>(j)].second) = ordered(i, j);
    }
  }
  return inverse;
}

void SparseCholesky::invert_pattern() {
  const int* const starts = factor_->column_starts();
  const int* const lengths = factor_->column_lengths();
  const int* const rows = factor_->rows();
  const double* const L = factor_->values();
  const auto n = static_cast<int>(factor_->L->n);
  std::vector<double>& Z = factor_->inverse;
  Z.assign(factor_->L->nzmax, 0.0);
  std::vector<double> sum(at(n), 0.0);
  std::vector<int> column_that_marked(at(n), -1);
  for (int j = n - 1; j >= 0; --j) {
    const int first = starts[j];  // the diagonal; below it the pattern of column j, all pairs of which are in the pattern of L
    const int end = first + lengths[j];
    for (int e = first + 1; e < end; ++e) {
      column_that_marked[at(rows[e])] = j;
      sum[at(rows[e])] = 0.0;
    }
    for (int e = first + 1; e < end; ++e) {  // (B-10) sum_k L_kj Z_ik: column k of Z holds the pairs (i, k) with i >= k
      const int k = rows[e];
      sum[at(k)] += L[e] * Z[at(starts[k])];
      double above = 0.0;
      int of_j = e + 1;
      for (int z = starts[k] + 1; z < starts[k] + lengths[k] && of_j < end; ++z) {
        const int i = rows[z];
        if (column_that_marked[at(i)] != j) continue;
        while (rows[of_j] != i) ++of_j;
        sum[at(i)] += L[e] * Z[at(z)];
        above += L[of_j] * Z[at(z)];
      }
      sum[at(k)] += above;
    }
    const double pivot = 1.0 / L[first];
    double diagonal = pivot;
    for (int e = first + 1; e < end; ++e) {
      Z[at(e)] = -pivot * sum[at(rows[e])];
      diagonal -= L[e] * Z[at(e)];
    }
    Z[at(first)] = pivot * diagonal;
  }
}

Eigen::MatrixXd SparseCholesky::inverse_block(int row, int column) const {
  if (factor_->inverse.empty()) throw InvalidArgument("inverse_block", row, "invert_pattern() must come first");
  Eigen::MatrixXd block(starts_[at(row) + 1] - starts_[at(row)], starts_[at(column) + 1] - starts_[at(column)]);
  const int* const rows = factor_->rows();
  for (Eigen::Index c = 0; c < block.cols(); ++c) {
    for (Eigen::Index r = 0; r < block.rows(); ++r) {
      const int i = factor_->place_of_row[at(starts_[at(row)] + static_cast<int>(r))];
      const int j = factor_->place_of_row[at(starts_[at(column)] + static_cast<int>(c))];
      const int* const begin = rows + factor_->column_starts()[std::min(i, j)];
      const int* const end = begin + factor_->column_lengths()[std::min(i, j)];
      const int* const found = std::lower_bound(begin, end, std::max(i, j));
      if (found == end || *found != std::max(i, j)) {
        throw InvalidArgument("inverse_block", std::to_string(row) + ", " + std::to_string(column),
                              "must lie in the pattern of the matrix");
      }
      block(r, c) = factor_->inverse[static_cast<std::size_t>(found - rows)];
    }
  }
  return block;
}

double SparseCholesky::factor_flops() const { return factor_->common.fl; }
double SparseCholesky::factor_entries() const { return factor_->common.lnz; }

}  // namespace ssjs
