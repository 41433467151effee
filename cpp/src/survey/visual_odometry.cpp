#include "ssjs/survey/visual_odometry.hpp"

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

#include "ssjs/base/error.hpp"
#include "ssjs/geometry/point_alignment.hpp"

namespace ssjs {
namespace {

/// ln of how much longer a pixel of the second frame is, by the spreads of the same points about their middles.
double log_length_ratio(const MatchedFrames& pair) {
  const auto spread = [](const Eigen::Matrix2Xd& points) { return (points.colwise() - points.rowwise().mean()).squaredNorm(); };
  return 0.5 * std::log(spread(pair.first_px) / spread(pair.second_px));
}

/// Velocity of a motion over dt, additive coordinates in the frame of its start.
Eigen::Vector3d velocity(const GaussianSe2& motion, double dt_s) { return motion.mean.vector() / dt_s; }

}  // namespace

Eigen::VectorXd pixel_lengths(int frames, const std::vector<MatchedFrames>& pairs, int width_px, const VisualOdometryConfig& config) {
  const double usual = config.metres_per_px.value_or(1.0 / width_px);
  // (V-17): ln of the lengths, by weighted least squares
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd b = Eigen::VectorXd::Zero(frames);
  for (int i = 0; i < frames; ++i) entries.emplace_back(i, i, 1.0 / std::pow(config.altitude_sigma, 2));
  const double weight = 1.0 / std::pow(config.scale_sigma, 2);
  for (const MatchedFrames& pair : pairs) {
    if (pair.first_px.cols() < 2) continue;
    const double ratio = log_length_ratio(pair);
    if (!std::isfinite(ratio)) continue;
    entries.emplace_back(pair.first, pair.first, weight);
    entries.emplace_back(pair.second, pair.second, weight);
    entries.emplace_back(std::max(pair.first, pair.second), std::min(pair.first, pair.second), -weight);
    b(pair.second) += weight * ratio;
    b(pair.first) -= weight * ratio;
  }
  Eigen::SparseMatrix<double> N(frames, frames);
  N.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> factor(N);
  const Eigen::VectorXd ln_length = factor.solve(b);
  return usual * ln_length.array().exp();
}

Eigen::Matrix2Xd body_points(const Eigen::Ref<const Eigen::Matrix2Xd>& pixels, double pixel_length) {
  Eigen::Matrix2Xd body(2, pixels.cols());
  body.row(0) = -pixel_length * pixels.row(1);
  body.row(1) = -pixel_length * pixels.row(0);
  return body;
}

std::optional<GaussianSe2> frame_motion(const MatchedFrames& pair, const Eigen::VectorXd& pixel_length,
                                        const VisualOdometryConfig& config) {
  const Eigen::Matrix2Xd in_first = body_points(pair.first_px, pixel_length(pair.first));
  const Eigen::Matrix2Xd in_second = body_points(pair.second_px, pixel_length(pair.second));
  const std::optional<Se2> first_T_second = align_points(in_first, in_second, Eigen::VectorXd());
  if (!first_T_second) return std::nullopt;

  const Eigen::Matrix2Xd turned = first_T_second->rotation() * in_second;
  const Eigen::Vector2d middle = turned.rowwise().mean();
  const double count = static_cast<double>(pair.first_px.cols());
  const double misfit = (turned - in_first).colwise().operator+(first_T_second->translation()).squaredNorm() / (2.0 * count);
  const double floor = std::pow(pixel_length(pair.first), 2);  // a pixel: keypoints lie no better
  const double variance = std::max(misfit, floor) / std::min(count, static_cast<double>(config.independent_matches));
  const double heading_variance = variance * count / (turned.colwise() - middle).squaredNorm();
  // (V-18): the middle of the matches is known to sigma, what lies beside it turns with the heading
  const Eigen::Vector2d arm(middle.y(), -middle.x());  // d(translation)/d(heading) with the middle held
  GaussianSe2 motion{*first_T_second, Eigen::Matrix3d::Zero()};
  motion.covariance.topLeftCorner<2, 2>() = variance * Eigen::Matrix2d::Identity() + heading_variance * arm * arm.transpose();
  motion.covariance.topRightCorner<2, 1>() = heading_variance * arm;
  motion.covariance.bottomLeftCorner<1, 2>() = heading_variance * arm.transpose();
  motion.covariance(2, 2) = heading_variance;
  return motion;
}

std::vector<GaussianSe2> bridged(const std::vector<std::optional<GaussianSe2>>& motions, const Eigen::VectorXd& time_s,
                                 const VisualOdometryConfig& config) {
  const auto n = static_cast<Eigen::Index>(motions.size());
  if (time_s.size() != n + 1) throw InvalidArgument("time_s", static_cast<int>(time_s.size()), "must be one more than the motions");
  const auto dt_s = [&](Eigen::Index i) { return time_s(i + 1) - time_s(i); };
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!(dt_s(i) > 0.0)) throw InvalidArgument("time_s", time_s(i + 1), "must increase from frame to frame");
  }
  Eigen::Vector3d change = Eigen::Vector3d::Zero(), speed = change, before = change, kept = change;
  int changes = 0, known = 0;
  bool follows = false;  // `before` is of the frame before
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::optional<GaussianSe2>& motion = motions[static_cast<std::size_t>(i)];
    if (motion) {
      const Eigen::Vector3d now = velocity(*motion, dt_s(i));
      if (known++ == 0) kept = now;
      speed += now.cwiseAbs2();
      if (follows) {
        change += (now - before).cwiseAbs2();
        ++changes;
      }
      before = now;
    }
    follows = motion.has_value();
  }
  if (known == 0) throw InvalidArgument("motions", static_cast<int>(n), "no two frames that follow each other registered");
  const Eigen::Vector3d usual = changes > 0 ? Eigen::Vector3d(change / changes) : Eigen::Vector3d(speed / known);
  const double tiny = 1e-12;  // motions that are all alike still leave a gap unsure

  std::vector<GaussianSe2> increments;
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::optional<GaussianSe2>& motion = motions[static_cast<std::size_t>(i)];
    if (motion) {
      kept = velocity(*motion, dt_s(i));
      increments.push_back(*motion);
      continue;
    }
    const Eigen::Vector3d variance = usual * std::pow(config.unseen_factor * dt_s(i), 2);  // (V-19)
    increments.push_back({Se2::from_vector(kept * dt_s(i)), Eigen::Matrix3d(variance.cwiseMax(tiny).asDiagonal())});
  }
  return increments;
}

}  // namespace ssjs
