#include "ssjs/association/joint_factor.hpp"

#include <cmath>
#include <string>

#include "ssjs/association/compatibility.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

std::string name(const Pair& pair) {
  return "observation " + std::to_string(pair.observation) + " with prediction " + std::to_string(pair.prediction);
}

/// residual' S^-1 residual. Throws where the symmetric S is not positive definite (NaN included).
double squared_distance_of(const ConditionedPair& candidate) {
  const Eigen::Matrix2d& S = candidate.covariance;
  const Eigen::Vector2d& r = candidate.residual;
  const double determinant = S(0, 0) * S(1, 1) - S(1, 0) * S(1, 0);
  if (!(S(0, 0) > 0.0) || !(determinant > 0.0)) throw NotPositiveDefinite("joint covariance of the residuals", name(candidate.pair));
  return (S(1, 1) * r.x() * r.x() - 2.0 * S(1, 0) * r.x() * r.y() + S(0, 0) * r.y() * r.y()) / determinant;
}

}  // namespace

JointFactor::JointFactor(const PairingProblem& problem, Eigen::Index capacity)
    : problem_(problem), accepted_(static_cast<std::size_t>(capacity)), rows_(2, capacity * (capacity - 1)) {}

double JointFactor::squared_distance() const { return size_ == 0 ? 0.0 : accepted_[static_cast<std::size_t>(size_ - 1)].squared_distance; }

ConditionedPair JointFactor::start(const Pair& pair) const {
  ConditionedPair candidate{pair, pair_residual(problem_, pair.observation, pair.prediction), pair_covariance(problem_, pair, pair), 0.0};
  candidate.squared_distance = squared_distance_of(candidate);
  return candidate;
}

void JointFactor::condition(ConditionedPair& candidate, BlockRow row, Eigen::Index level) const {
  const Accepted& accepted = accepted_[static_cast<std::size_t>(level)];
  Eigen::Matrix2d left = pair_covariance(problem_, candidate.pair, accepted.pair);
  const double* L_accepted = rows_.data() + 2 * row_start(level);  // 2x2 column-major blocks, one after the other
  const double* L_candidate = row.data();
  for (Eigen::Index q = 0; q < level; ++q, L_accepted += 4, L_candidate += 4) {
    left.noalias() -= Eigen::Map<const Eigen::Matrix2d>(L_candidate).lazyProduct(Eigen::Map<const Eigen::Matrix2d>(L_accepted).transpose());
  }
  const Eigen::Matrix2d block = left.lazyProduct(accepted.inverse_diagonal.transpose());  // L_cq
  row.middleCols<2>(2 * level) = block;
  candidate.residual.noalias() -= block.lazyProduct(accepted.y);
  candidate.covariance.noalias() -= block.lazyProduct(block.transpose());
  candidate.squared_distance = squared_distance_of(candidate);
}

void JointFactor::push(const ConditionedPair& candidate, const ConstBlockRow& row) {
  Accepted& accepted = accepted_[static_cast<std::size_t>(size_)];
  rows_.middleCols(row_start(size_), 2 * size_) = row.leftCols(2 * size_);
  const Eigen::Matrix2d& S = candidate.covariance;
  const double l00 = std::sqrt(S(0, 0));
  const double l10 = S(1, 0) / l00;
  const double l11 = std::sqrt(S(1, 1) - l10 * l10);
  if (!(l00 > 0.0) || !(l11 > 0.0)) throw NotPositiveDefinite("joint covariance of the residuals", name(candidate.pair));
  accepted.inverse_diagonal << 1.0 / l00, 0.0, -l10 / (l00 * l11), 1.0 / l11;
  accepted.y = accepted.inverse_diagonal * candidate.residual;  // forward substitution
  accepted.pair = candidate.pair;
  accepted.squared_distance = squared_distance() + accepted.y.squaredNorm();
  ++size_;
}

double joint_squared_distance(const PairingProblem& problem, const std::vector<Pair>& pairs) {
  JointFactor factor(problem, static_cast<Eigen::Index>(pairs.size()));
  Eigen::Matrix2Xd row(2, 2 * factor.capacity());
  for (const Pair& pair : pairs) {
    ConditionedPair candidate = factor.start(pair);
    for (Eigen::Index level = 0; level < factor.size(); ++level) factor.condition(candidate, row, level);
    factor.push(candidate, row);
  }
  return factor.squared_distance();
}

std::vector<double> joint_gates(double probability, Eigen::Index pairs) {
  if (!(probability > 0.0 && probability < 1.0)) throw InvalidArgument("probability", probability, "must lie in (0, 1)");
  std::vector<double> gates(static_cast<std::size_t>(pairs));
  const double log_tail = std::log1p(-probability);
  double half = -log_tail;  // two degrees of freedom: the tail is exp(-x / 2)
  double log_factorial = 0.0;
  for (Eigen::Index k = 1; k <= pairs; ++k) {
    if (k > 1) {
      // the tail beyond x is T(h) = exp(-h) (1 + h + .. + h^(k-1)/(k-1)!), h = x/2. log T is concave and decreasing:
      // after its first step Newton stays right of the root and converges monotonically.
      const double top = static_cast<double>(k - 1);
      log_factorial += std::log(top);
      half += 1.0;
      for (int iteration = 0; iteration < 100; ++iteration) {
        double sum = 1.0;  // the bracket over its last term
        double term = 1.0;
        for (double j = top; j > 0.0 && term > 1e-17 * sum; j -= 1.0) sum += (term *= j / half);
        const double step = (top * std::log(half) - half - log_factorial + std::log(sum) - log_tail) * sum;
        half += step;
        if (std::abs(step) <= 1e-14 * half) break;
      }
    }
    gates[static_cast<std::size_t>(k - 1)] = 2.0 * half;
  }
  return gates;
}

}  // namespace ssjs
