#include "ssjs/mapping/levelled_record.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <bitset>
#include <cmath>
#include <cstdint>

#include "ssjs/base/angle.hpp"

namespace ssjs {
namespace {

constexpr Eigen::Index kVehicle = VehicleLayout::kSize;
constexpr std::size_t kNumbersPerReel = std::size_t{1} << 15U;  // 256 KiB
constexpr std::size_t kRowsPerReel = 256;
constexpr std::size_t kInitialEntries = 4096;
constexpr std::size_t kLeastRowBytes = 64;  // of one StateRows in an archive

struct UpdateRows {
  const RecordedRows* first;
  std::size_t count;
  [[nodiscard]] const RecordedRows* begin() const { return first; }
  [[nodiscard]] const RecordedRows* end() const { return first + count; }
};

/// What a pose of the past has to do with all that came after it, going back from the exit of the map.
class Backwards {
 public:
  Backwards(Eigen::Index size, const std::vector<Eigen::Index>& exit)
      : n_(size),
        lambda_(Eigen::MatrixXd::Zero(size, static_cast<Eigen::Index>(exit.size()))),
        mu_(Eigen::VectorXd::Zero(size)),
        M_(Eigen::MatrixXd::Zero(size, size)) {
    for (std::size_t i = 0; i < exit.size(); ++i) lambda_(exit[i], static_cast<Eigen::Index>(i)) = 1.0;
  }

  [[nodiscard]] auto lambda() const { return lambda_.topRows(n_); }            ///< Cov(e_t, e_exit) = P_t Lambda
  [[nodiscard]] auto mu() const { return mu_.head(n_); }                       ///< smoothed = filtered + P_t mu
  [[nodiscard]] auto information() const { return M_.topLeftCorner(n_, n_); }  ///< P smoothed = P_t - P_t M P_t

  void motion(const VehicleMatrix& F) {
    lambda_.topRows<kVehicle>() = (F.transpose() * lambda_.topRows<kVehicle>()).eval();
    mu_.head<kVehicle>() = (F.transpose() * mu_.head<kVehicle>()).eval();
    M_.topLeftCorner(kVehicle, n_) = (F.transpose() * M_.topLeftCorner(kVehicle, n_)).eval();
    M_.topLeftCorner(n_, kVehicle) = (M_.topLeftCorner(n_, kVehicle) * F).eval();
  }

  void update(const UpdateRows& rows, const Eigen::Map<const Eigen::MatrixXd>& Y, const Eigen::Map<const Eigen::MatrixXd>& L) {
    const auto lower = L.triangularView<Eigen::Lower>();
    const auto transposed_K_times = [&](const auto& right) {  // K = Y L^-1
      Eigen::MatrixXd product = Y.transpose() * right;
      lower.transpose().solveInPlace(product);
      return product;
    };
    Eigen::VectorXd innovation(Y.cols());
    Eigen::Index row = 0;
    for (const RecordedRows& recorded : rows) {
      const StateRows& block = recorded.rows;
      innovation.segment(row, block.rows()) = block.vehicle.residual;
      row += block.rows();
    }
    lower.solveInPlace(innovation);
    lower.transpose().solveInPlace(innovation);  // S^-1 nu
    const Eigen::MatrixXd Kt_lambda = transposed_K_times(lambda());
    const Eigen::VectorXd Kt_mu = transposed_K_times(mu());
    const Eigen::MatrixXd Kt_M = transposed_K_times(information());
    Eigen::MatrixXd within = Eigen::MatrixXd::Identity(Y.cols(), Y.cols());  // S^-1 + K' M K
    lower.solveInPlace(within);
    lower.transpose().solveInPlace(within);
    within += transposed_K_times(Kt_M.transpose());
    subtract_Ht(rows, Kt_lambda, lambda_);
    subtract_Ht(rows, Kt_mu - innovation, mu_);
    // (I - KH)' M (I - KH) + H' S^-1 H = M - H' K'M - (H' K'M)' + H' (S^-1 + K' M K) H
    Eigen::MatrixXd left = Eigen::MatrixXd::Zero(n_, n_);
    subtract_Ht(rows, Kt_M, left);
    Eigen::MatrixXd HtW = Eigen::MatrixXd::Zero(n_, Y.cols());
    subtract_Ht(rows, -within, HtW);
    Eigen::MatrixXd both = Eigen::MatrixXd::Zero(n_, n_);
    subtract_Ht(rows, -HtW.transpose(), both);
    M_.topLeftCorner(n_, n_) += left + left.transpose() + both;
    // symmetric again: of an error that is not, this recursion makes (I - KH)' E (I + KH), which grows
    M_.topLeftCorner(n_, n_) = (0.5 * (information() + information().transpose())).eval();
  }

  /// Before this landmark of Rows rows was added.
  template <Eigen::Index Rows>
  void addition(const Eigen::Matrix<double, Rows, kVehicle>& J) {
    n_ -= Rows;
    lambda_.topRows<kVehicle>().noalias() += J.transpose() * lambda_.template middleRows<Rows>(n_);
    mu_.head<kVehicle>().noalias() += J.transpose() * mu_.template segment<Rows>(n_);
    M_.topLeftCorner(kVehicle, n_ + Rows).noalias() += J.transpose() * M_.block(n_, 0, Rows, n_ + Rows);
    M_.topLeftCorner(n_, kVehicle).noalias() += M_.block(0, n_, n_, Rows) * J;
  }

  /// Before the six rows from `offset` on became three. (I-10)
  void conversion(Eigen::Index offset, const Eigen::Matrix<double, 3, 6>& J) {
    const Eigen::MatrixXd of_point = lambda_.middleRows<3>(offset);
    const Eigen::Vector3d mu_point = mu_.segment<3>(offset);
    const Eigen::MatrixXd M_point = M_.block(offset, 0, 3, n_);
    const Eigen::Matrix3d M_own = M_.block<3, 3>(offset, offset);
    open(offset + 3, 3);
    lambda_.middleRows<6>(offset) = J.transpose() * of_point;
    mu_.segment<6>(offset) = J.transpose() * mu_point;
    const Eigen::Index after = n_ - offset - 6;
    M_.block(offset, 0, 6, offset) = J.transpose() * M_point.leftCols(offset);
    M_.block(offset, offset + 6, 6, after) = J.transpose() * M_point.rightCols(after);
    M_.block(0, offset, offset, 6) = M_.block(offset, 0, 6, offset).transpose();
    M_.block(offset + 6, offset, after, 6) = M_.block(offset, offset + 6, 6, after).transpose();
    M_.block<6, 6>(offset, offset) = J.transpose() * M_own * J;
  }

  /// Before these rows were dropped: what came after them knew nothing of them. (I-10)
  void dropping(Eigen::Index offset, Eigen::Index rows) { open(offset, rows); }

 private:
  /// target -= H' right.
  static void subtract_Ht(const UpdateRows& rows, const Eigen::MatrixXd& right, Eigen::Ref<Eigen::MatrixXd> target) {
    Eigen::Index row = 0;
    for (const RecordedRows& recorded : rows) {
      const StateRows& block = recorded.rows;
      target.topRows<kVehicle>().noalias() -= block.vehicle.H.transpose() * right.middleRows(row, block.rows());
      if (block.landmark != StateRows::kNoLandmark) {
        target.middleRows<3>(recorded.offset).noalias() -= block.H_landmark.transpose() * right.middleRows(row, block.rows());
        if (block.is_of_ray()) {
          target.middleRows<3>(recorded.offset + 3).noalias() -= block.H_ray.transpose() * right.middleRows(row, block.rows());
        }
      }
      row += block.rows();
    }
  }

  /// So many rows of zeros from `at` on.
  void open(Eigen::Index at, Eigen::Index rows) {
    const Eigen::Index after = n_ - at;
    n_ += rows;
    if (n_ > mu_.size()) {
      lambda_.conservativeResize(n_, Eigen::NoChange);
      mu_.conservativeResize(n_);
      M_.conservativeResize(n_, n_);
    }
    lambda_.middleRows(at + rows, after) = lambda_.middleRows(at, after).eval();
    lambda_.middleRows(at, rows).setZero();
    mu_.segment(at + rows, after) = mu_.segment(at, after).eval();
    mu_.segment(at, rows).setZero();
    M_.block(0, at + rows, n_ - rows, after) = M_.block(0, at, n_ - rows, after).eval();
    M_.block(at + rows, 0, after, n_) = M_.block(at, 0, after, n_).eval();
    M_.block(0, at, n_, rows).setZero();
    M_.block(at, 0, rows, n_).setZero();
  }

  Eigen::Index n_;
  Eigen::MatrixXd lambda_;
  Eigen::VectorXd mu_;
  Eigen::MatrixXd M_;
};

}  // namespace

LevelledRecord::LevelledRecord(std::size_t most_bytes) : most_bytes_(most_bytes), numbers_(kNumbersPerReel), rows_(kRowsPerReel) {
  entries_.reserve(kInitialEntries);
  steps_.reserve(kInitialEntries);
}

void LevelledRecord::clear() {
  entries_.clear();
  steps_.clear();
  numbers_.clear();
  rows_.clear();
  bytes_ = oldest_ = 0;
  F_.setIdentity();
}

void LevelledRecord::match(const LevelledRecord& other) {
  entries_.reserve(other.entries_.capacity());
  steps_.reserve(other.steps_.capacity());
  numbers_.match(other.numbers_);
  rows_.match(other.rows_);
}

Tape<double>::Piece LevelledRecord::copy(const Eigen::Ref<const Eigen::MatrixXd>& matrix) {
  const Tape<double>::Piece piece = numbers_.append(static_cast<std::size_t>(matrix.size()));
  Eigen::Map<Eigen::MatrixXd>(piece.items, matrix.rows(), matrix.cols()) = matrix;
  entries_.back().bytes += sizeof(double) * static_cast<std::size_t>(matrix.size());
  return piece;
}

LevelledRecord::Entry& LevelledRecord::push(Kind kind) {
  Entry& entry = entries_.emplace_back();
  entry.kind = kind;
  entry.bytes = sizeof(Entry);
  entry.F = copy(F_);
  F_.setIdentity();
  return entry;
}

/// After the newest entry was filled in.
void LevelledRecord::limit() {
  bytes_ += entries_.back().bytes;
  while (bytes_ > most_bytes_ && oldest_ + 1 < entries_.size()) bytes_ -= entries_[oldest_++].bytes;
  if (2 * oldest_ < entries_.size() || oldest_ == 0) return;
  entries_.erase(entries_.begin(), entries_.begin() + static_cast<std::ptrdiff_t>(oldest_));
  oldest_ = 0;
  numbers_.release_before(entries_.front().F.reel);
  const auto rows = std::find_if(entries_.begin(), entries_.end(), [](const Entry& entry) { return entry.row_blocks > 0; });
  if (rows != entries_.end()) rows_.release_before(rows->rows.reel);
}

void LevelledRecord::predict(const VehicleMatrix& F) { F_ = (F * F_).eval(); }

void LevelledRecord::update(const std::vector<StateRows>& rows, const std::vector<Eigen::Index>& offsets,
                            const Eigen::Ref<const Eigen::MatrixXd>& Y, const Eigen::Ref<const Eigen::MatrixXd>& L) {
  Entry& entry = push(Kind::kUpdate);
  entry.Y_rows = Y.rows();
  entry.Y_columns = Y.cols();
  entry.Y = copy(Y);
  entry.L = copy(L);
  entry.row_blocks = rows.size();
  entry.rows = rows_.append(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) entry.rows.items[i] = {rows[i], offsets[i]};
  entry.bytes += sizeof(RecordedRows) * rows.size();
  limit();
}

void LevelledRecord::add(const Eigen::Ref<const Eigen::MatrixXd>& J_vehicle) {
  Entry& entry = push(Kind::kAdd);
  entry.Y_rows = J_vehicle.rows();
  entry.Y_columns = J_vehicle.cols();
  entry.Y = copy(J_vehicle);
  limit();
}

void LevelledRecord::convert(Eigen::Index offset, const Eigen::Matrix<double, 3, 6>& J) {
  Entry& entry = push(Kind::kConvert);
  entry.offset = offset;
  entry.Y_rows = J.rows();
  entry.Y_columns = J.cols();
  entry.Y = copy(J);
  limit();
}

void LevelledRecord::drop(Eigen::Index offset, Eigen::Index rows) {
  Entry& entry = push(Kind::kDrop);
  entry.offset = offset;
  entry.dropped = rows;
  limit();
}

void LevelledRecord::step(double time_s, const LevelledFilter& filter, bool conditioned) {
  steps_.push_back({time_s, filter.vehicle().head<6>(), filter.vehicle_covariance().topLeftCorner<6, 6>()});
  if (!conditioned) return;
  Entry& entry = push(Kind::kStep);
  entry.Y_rows = 6;
  entry.Y_columns = filter.size();
  entry.Y = numbers_.append(static_cast<std::size_t>(6 * filter.size()));
  entry.bytes += sizeof(double) * static_cast<std::size_t>(6 * filter.size());
  filter.read_pose_rows(Eigen::Map<Eigen::Matrix<double, 6, Eigen::Dynamic>>(entry.Y.items, 6, filter.size()));
  limit();
}

std::vector<LevelledStep> LevelledRecord::smoothed(Eigen::Index size, const std::vector<Eigen::Index>& exit,
                                                   const Eigen::MatrixXd& P_exit) const {
  const auto p = static_cast<Eigen::Index>(exit.size());
  std::vector<LevelledStep> steps;
  steps.reserve(steps_.size());
  for (const FilteredStep& filtered : steps_) {
    LevelledStep& step = steps.emplace_back();
    step.time_s = filtered.time_s;
    step.base_T_vehicle = filtered.pose;
    step.covariance = filtered.covariance;
    step.gain.setZero(6, p);
    step.conditional_covariance = step.covariance;
  }
  if (entries_.empty()) return steps;
  const Eigen::LLT<Eigen::MatrixXd> factor(P_exit);
  Backwards back(size, exit);
  back.motion(F_);
  std::size_t step = steps.size();
  for (std::size_t i = entries_.size(); i-- > oldest_;) {
    const Entry& entry = entries_[i];
    const Matrix Y(entry.Y.items, entry.Y_rows, entry.Y_columns);
    switch (entry.kind) {
      case Kind::kStep: {
        LevelledStep& at = steps[--step];
        const Eigen::MatrixXd with_exit = Y * back.lambda();
        at.gain = factor.solve(with_exit.transpose()).transpose();  // (C-4)
        at.base_T_vehicle += Y * back.mu();
        for (Eigen::Index angle = 3; angle < 6; ++angle) at.base_T_vehicle(angle) = wrap_angle(at.base_T_vehicle(angle));
        at.covariance -= Y * back.information() * Y.transpose();
        at.covariance = (0.5 * (at.covariance + at.covariance.transpose())).eval();
        at.conditional_covariance = at.covariance - at.gain * with_exit.transpose();
        at.conditional_covariance = (0.5 * (at.conditional_covariance + at.conditional_covariance.transpose())).eval();
        break;
      }
      case Kind::kUpdate:
        back.update({entry.rows.items, entry.row_blocks}, Y, Matrix(entry.L.items, entry.Y_columns, entry.Y_columns));
        break;
      case Kind::kAdd:
        if (entry.Y_rows == 6) {
          back.addition<6>(Eigen::Map<const Eigen::Matrix<double, 6, kVehicle>>(entry.Y.items));
        } else {
          back.addition<3>(Eigen::Map<const Eigen::Matrix<double, 3, kVehicle>>(entry.Y.items));
        }
        break;
      case Kind::kConvert:
        back.conversion(entry.offset, Eigen::Map<const Eigen::Matrix<double, 3, 6>>(entry.Y.items));
        break;
      case Kind::kDrop:
        back.dropping(entry.offset, entry.dropped);
        break;
    }
    back.motion(VehicleMatrix(Eigen::Map<const VehicleMatrix>(entry.F.items)));
  }
  return steps;
}

void LevelledRecord::archive(Archive& a) {
  auto count = static_cast<std::int64_t>(entries_.size() - oldest_);
  a("steps", steps_);
  a("F", F_);
  a("entries", count);
  for (std::int64_t i = 0; i < count; ++i) {
    archive_entry(a, a.reading() ? entries_.emplace_back() : entries_[oldest_ + static_cast<std::size_t>(i)]);
    if (a.reading()) bytes_ += entries_.back().bytes;
  }
}

void LevelledRecord::archive_entry(Archive& a, Entry& entry) {
  constexpr Eigen::Index kMost = Eigen::Index{1} << 30U;
  a.choice("kind", entry.kind, Kind::kDrop);
  a("bytes", entry.bytes);
  archive_motion(a, entry.F);
  if (entry.kind == Kind::kConvert || entry.kind == Kind::kDrop) {
    a("offset", entry.offset);
    a("dropped", entry.dropped);
  }
  if (entry.kind == Kind::kDrop) return;
  a("Y_rows", entry.Y_rows);
  a("Y_columns", entry.Y_columns);
  a.require(entry.Y_rows >= 0 && entry.Y_rows < kMost && entry.Y_columns >= 0 && entry.Y_columns < kMost,
            "has a matrix of the wrong shape");
  archive_numbers(a, "Y", entry.Y, entry.Y_rows, entry.Y_columns);
  if (entry.kind != Kind::kUpdate) return;
  archive_numbers(a, "L", entry.L, entry.Y_columns, entry.Y_columns);
  a("row_blocks", entry.row_blocks);
  if (a.reading()) {
    a.require(entry.row_blocks <= a.left() / kLeastRowBytes, "has more rows than the bytes that are left");
    entry.rows = rows_.append(entry.row_blocks);
  }
  for (std::size_t i = 0; i < entry.row_blocks; ++i) a("rows", entry.rows.items[i]);
}

/// A motion leaves most of the state as it is: what is not as in the identity, each with its place.
void LevelledRecord::archive_motion(Archive& a, Tape<double>::Piece& piece) {
  static const VehicleMatrix none = VehicleMatrix::Identity();
  const auto is_none = [&](std::size_t i) { return piece.items[i] == none.data()[i] && !std::signbit(piece.items[i]); };
  std::array<std::uint32_t, (kVehicle * kVehicle + 31) / 32> moved{};  // a bit a coefficient
  std::array<double, kVehicle * kVehicle> values{};
  std::size_t count = 0;
  if (a.reading()) {
    piece = numbers_.append(static_cast<std::size_t>(none.size()));
    std::copy_n(none.data(), none.size(), piece.items);
  } else {
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (is_none(i)) continue;
      moved[i / 32] |= std::uint32_t{1} << (i % 32);
      values[count++] = piece.items[i];
    }
  }
  a("moved", moved);
  if (a.reading()) {
    for (const std::uint32_t word : moved) count += std::bitset<32>(word).count();
    a.require(count <= values.size(), "moves more than there is");
  }
  a.numbers("F", values.data(), count);
  if (!a.reading()) return;
  std::size_t next = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (((moved[i / 32] >> (i % 32)) & 1U) != 0) piece.items[i] = values[next++];
  }
}

void LevelledRecord::archive_numbers(Archive& a, std::string_view name, Tape<double>::Piece& piece, Eigen::Index rows,
                                     Eigen::Index columns) {
  const auto count = static_cast<std::size_t>(rows * columns);
  if (a.reading()) {
    a.require(count <= a.left() / sizeof(double), "is larger than the bytes that are left");
    piece = numbers_.append(count);
  }
  a.numbers(name, piece.items, count);
}

bool LevelledRecord::fits(Eigen::Index size) const {
  std::size_t steps = steps_.size();
  for (std::size_t i = entries_.size(); i-- > oldest_;) {
    const Entry& entry = entries_[i];
    switch (entry.kind) {
      case Kind::kAdd:
        if ((entry.Y_rows != 3 && entry.Y_rows != 6) || entry.Y_columns != kVehicle) return false;
        size -= entry.Y_rows;
        break;
      case Kind::kConvert:
        if (entry.Y_rows != 3 || entry.Y_columns != 6 || entry.offset < kVehicle || entry.offset > size - 3) return false;
        size += 3;
        break;
      case Kind::kDrop:
        if ((entry.dropped != 3 && entry.dropped != 6) || entry.offset < kVehicle || entry.offset > size) return false;
        size += entry.dropped;
        break;
      case Kind::kStep:
        if (entry.Y_rows != 6 || entry.Y_columns != size || steps-- == 0) return false;
        break;
      case Kind::kUpdate:
        if (!update_fits(entry, size)) return false;
        break;
    }
    if (size < kVehicle) return false;
  }
  return true;
}

bool LevelledRecord::update_fits(const Entry& entry, Eigen::Index size) {
  Eigen::Index rows = 0;
  for (std::size_t block = 0; block < entry.row_blocks; ++block) {
    const RecordedRows& recorded = entry.rows.items[block];
    const StateRows& its = recorded.rows;
    rows += its.rows();
    if (its.landmark == StateRows::kNoLandmark) continue;
    if (recorded.offset < kVehicle || recorded.offset > size - (its.is_of_ray() ? 6 : 3)) return false;
  }
  return entry.Y_rows == size && entry.Y_columns == rows;
}

}  // namespace ssjs
