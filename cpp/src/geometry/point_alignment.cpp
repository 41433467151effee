#include "ssjs/geometry/point_alignment.hpp"

#include <cmath>
#include <limits>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

/// Spread below which points coincide: the rounding of a mean of coordinates this large.
double coincidence_m(const Eigen::Ref<const Eigen::Matrix2Xd>& points) {
  return 1e3 * std::numeric_limits<double>::epsilon() * points.cwiseAbs().maxCoeff();
}

}  // namespace

std::optional<Se2> align_points(const Eigen::Ref<const Eigen::Matrix2Xd>& a_points, const Eigen::Ref<const Eigen::Matrix2Xd>& b_points,
                                const Eigen::Ref<const Eigen::VectorXd>& weights) {
  const Eigen::Index n = a_points.cols();
  if (b_points.cols() != n) {
    throw InvalidArgument("align_points b_points", std::to_string(b_points.cols()) + " columns",
                          "must have as many as a_points (" + std::to_string(n) + ")");
  }
  if (weights.size() != 0 && weights.size() != n) {
    throw InvalidArgument("align_points weights", std::to_string(weights.size()) + " values", "must be empty or one per pair");
  }
  if (!a_points.allFinite() || !b_points.allFinite()) {
    throw InvalidArgument("align_points points", "NaN or infinity", "every coordinate must be finite");
  }
  if (weights.size() != 0 && !(weights.minCoeff() >= 0.0 && weights.allFinite())) {
    throw InvalidArgument("align_points weights", weights.minCoeff(), "must be zero or positive, and finite");
  }
  if (n < 2) return std::nullopt;

  const Eigen::VectorXd w = weights.size() != 0 ? Eigen::VectorXd(weights) : Eigen::VectorXd::Ones(n);
  if ((w.array() > 0.0).count() < 2) return std::nullopt;
  const double total = w.sum();
  const Eigen::Vector2d a_centre = a_points * w / total;
  const Eigen::Vector2d b_centre = b_points * w / total;
  const Eigen::Matrix2Xd a = a_points.colwise() - a_centre;
  const Eigen::Matrix2Xd b = b_points.colwise() - b_centre;

  const double a_spread = std::sqrt(a.colwise().squaredNorm().dot(w) / total);
  const double b_spread = std::sqrt(b.colwise().squaredNorm().dot(w) / total);
  if (!(a_spread > coincidence_m(a_points)) || !(b_spread > coincidence_m(b_points))) return std::nullopt;

  // (S-10) the sum is largest in the direction (cosine, sine) of the heading
  const double cosine = (a.cwiseProduct(b).colwise().sum() * w).value() / total;
  const double sine = ((b.row(0).cwiseProduct(a.row(1)) - b.row(1).cwiseProduct(a.row(0))) * w).value() / total;
  constexpr double kNoDirection = 1e-12;  // of the largest possible value: every heading fits equally well (a mirrored square)
  if (!(std::hypot(cosine, sine) > kNoDirection * a_spread * b_spread)) return std::nullopt;

  Se2 a_T_b{0.0, 0.0, wrap_angle(std::atan2(sine, cosine))};
  const Eigen::Vector2d a_p_b = a_centre - a_T_b.rotation() * b_centre;
  a_T_b.x = a_p_b.x();
  a_T_b.y = a_p_b.y();
  return a_T_b;
}

}  // namespace ssjs
