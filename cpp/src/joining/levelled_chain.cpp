#include "ssjs/joining/levelled_chain.hpp"

#include <string>

#include "ssjs/base/angle.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

constexpr Eigen::Index kHeading = 2;
constexpr Eigen::Index kStart = 3;  // c_s
constexpr Eigen::Index kEnd = 4;    // c_e

/// Exit, c_s, c_e and further rows of one map. One offset for the whole map is both of them, c_s further away by what it may have drifted.
Stretch one_map(const LevelledSubmap& submap, const std::vector<Eigen::Index>& rows, double drift_variance) {
  std::vector<Eigen::Index> entries{0, 1, 2};
  const Eigen::Index compass = submap.compass_rows();
  if (compass > 0) {
    entries.push_back(LevelledSubmap::compass_offset());
    entries.push_back(LevelledSubmap::compass_offset() + compass - 1);
  }
  entries.insert(entries.end(), rows.begin(), rows.end());
  Stretch stretch{submap.mean(entries), submap.covariance(entries, entries), compass > 0 ? 2 : 0};
  if (compass > 0) stretch.covariance(kStart, kStart) += drift_variance;
  return stretch;
}

}  // namespace

Stretch followed_by(const Stretch& a, const Stretch& b, bool compass_goes_on) {
  const Eigen::Index n_a = a.mean.size();
  const Eigen::Index n_b = b.mean.size();
  Eigen::VectorXd z(n_a + n_b);
  z << a.mean, b.mean;
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(n_a + n_b, n_a + n_b);
  P.topLeftCorner(n_a, n_a) = a.covariance;
  P.bottomRightCorner(n_b, n_b) = b.covariance;
  if (a.compass_rows == 2 && compass_goes_on) {  // (C-2)
    const Eigen::VectorXd PG = P.col(n_a + kStart) - P.col(kHeading) - P.col(kEnd);
    const double S = PG(n_a + kStart) - PG(kHeading) - PG(kEnd);
    const double gap = wrap_angle(z(n_a + kStart) - z(kHeading) - z(kEnd));
    z -= PG * (gap / S);
    P -= PG * PG.transpose() / S;
  }
  const Se2 a_T_middle = Se2::from_vector(z.head<3>());
  const Se2 middle_T_b = Se2::from_vector(z.segment<3>(n_a));
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(n_a, n_a + n_b);
  J.topLeftCorner(n_a, n_a).setIdentity();
  J.topLeftCorner<3, 3>() = compose_jacobian_left(a_T_middle, middle_T_b);
  J.block<3, 3>(0, n_a) = compose_jacobian_right(a_T_middle);
  Stretch whole{z.head(n_a), {}, a.compass_rows};
  whole.mean.head<3>() = (a_T_middle * middle_T_b).vector();  // (C-1)
  if (a.compass_rows == 2) {
    whole.mean(kStart) = wrap_angle(whole.mean(kStart));
    whole.mean(kEnd) = wrap_angle(z(n_a + kEnd) - z(kHeading));
    J(kEnd, kEnd) = 0.0;
    J(kEnd, kHeading) = -1.0;
    J(kEnd, n_a + kEnd) = 1.0;
  }
  whole.covariance = J * P * J.transpose();
  return whole;
}

void LevelledChain::append(const LevelledSubmap& submap, bool compass_goes_on, double drift_variance) {
  goes_on_.push_back(compass_goes_on);
  drift_.push_back(drift_variance);
  Stretch stretch = one_map(submap, {}, drift_variance);
  for (std::size_t level = 0;; ++level) {  // a block that is the second of its kind makes one of the next level with the first
    if (blocks_.size() == level) blocks_.emplace_back();
    std::vector<Stretch>& blocks = blocks_[level];
    blocks.push_back(std::move(stretch));
    if (blocks.size() % 2 == 1) return;
    const std::size_t middle = (blocks.size() - 1) << level;
    stretch = followed_by(blocks[blocks.size() - 2], blocks.back(), goes_on_[middle]);
  }
}

Stretch LevelledChain::between(int from, int to, const LevelledSubmap& first, const std::vector<Eigen::Index>& rows) const {
  if (from < 0 || to < from || to > maps()) {
    throw InvalidArgument("from, to", std::to_string(from) + ", " + std::to_string(to),
                          "bases in this order, at most " + std::to_string(maps()));
  }
  const auto begin = static_cast<std::size_t>(from);
  const auto end = static_cast<std::size_t>(to);
  Stretch way = one_map(first, rows, drift_[begin]);
  if (begin == end) {
    const Eigen::Index head = way.extra();
    way.mean.head(head).setZero();
    way.covariance.topRows(head).setZero();
    way.covariance.leftCols(head).setZero();
    return way;
  }
  for (std::size_t at = begin + 1; at < end;) {
    std::size_t level = 0;
    while (level + 1 < blocks_.size() && at % (std::size_t{2} << level) == 0 && at + (std::size_t{2} << level) <= end) ++level;
    way = followed_by(way, blocks_[level][at >> level], goes_on_[at]);
    at += std::size_t{1} << level;
  }
  return way;
}

}  // namespace ssjs
