#include "ssjs/pipeline/smoother.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "ssjs/base/error.hpp"
#include "ssjs/sensors/range_bearing.hpp"

namespace ssjs {
namespace {

constexpr double kFirstDamping = 1e-6;  // relative to the diagonal of the information matrix
constexpr double kLeastDamping = 1e-12;
constexpr double kMostDamping = 1e6;  // a step so short that does not help never will
constexpr double kDampingFactor = 10.0;
constexpr double kPromisedDecrease = 1e-7;           // half chi-squared
constexpr double kRelativePromisedDecrease = 1e-10;  // of the cost

std::size_t at(int i) { return static_cast<std::size_t>(i); }

template <int N>
Eigen::Matrix<double, N, N> inverse_of(const Eigen::Matrix<double, N, N>& covariance, const char* matrix, std::size_t factor) {
  const Eigen::LLT<Eigen::Matrix<double, N, N>> llt(covariance);
  if (!covariance.allFinite() || llt.info() != Eigen::Success) throw NotPositiveDefinite(matrix, "factor " + std::to_string(factor));
  const Eigen::Matrix<double, N, N> inverse = llt.solve(Eigen::Matrix<double, N, N>::Identity());
  return 0.5 * (inverse + inverse.transpose());
}

}  // namespace

MotionResidual motion_residual(const MotionFactor& factor, const Se2& global_T_from, const Se2& global_T_to) {
  const RelativePose expected = relative_pose(global_T_from, global_T_to);
  return {additive_difference(expected.i_T_j, factor.from_T_to.mean), expected.J_i, expected.J_j};  // (B-2)
}

SightingResidual sighting_residual(const SightingFactor& factor, const Se2& global_T_pose, const Eigen::Vector2d& global_p_landmark) {
  const RangeBearingPrediction expected = predict_range_bearing(global_T_pose, global_p_landmark);
  const Eigen::Vector2d residual(expected.range_bearing.x() - factor.range_bearing.x(),
                                 angle_difference(expected.range_bearing.y(), factor.range_bearing.y()));  // (B-3)
  return {residual, expected.H_vehicle, expected.H_landmark};
}

RobustLoss robust_loss(RobustKernel kernel, double width, double squared_distance) {
  if (kernel == RobustKernel::kHuber && squared_distance > width * width) {
    const double distance = std::sqrt(squared_distance);
    return {width * (distance - 0.5 * width), width / distance};
  }
  if (kernel == RobustKernel::kCauchy) {
    const double relative = squared_distance / (width * width);
    return {0.5 * width * width * std::log1p(relative), 1.0 / (1.0 + relative)};
  }
  return {0.5 * squared_distance, 1.0};
}

Smoother::Smoother(SmoothingProblem problem, const SmoothingConfig& config) : problem_(std::move(problem)), config_(config) {
  check();
  for (std::size_t i = 0; i < problem_.motions.size(); ++i) {
    motion_information_.push_back(inverse_of<3>(problem_.motions[i].from_T_to.covariance, "covariance of a motion", i));
  }
  for (std::size_t i = 0; i < problem_.sightings.size(); ++i) {
    sighting_information_.push_back(inverse_of<2>(problem_.sightings[i].covariance, "covariance of a sighting", i));
  }
  set_pattern();
}

void Smoother::check() const {
  const auto poses = static_cast<int>(problem_.poses.size());
  const auto landmarks = static_cast<int>(problem_.landmarks.size());
  if (poses == 0) throw InvalidArgument("poses", "none", "a smoothing problem has at least the pose that is held");
  for (const MotionFactor& motion : problem_.motions) {
    if (motion.from < 0 || motion.to < 0 || motion.from >= poses || motion.to >= poses || motion.from == motion.to) {
      throw InvalidArgument("motion factor", std::to_string(motion.from) + " to " + std::to_string(motion.to), "must tie two poses");
    }
  }
  for (const SightingFactor& sighting : problem_.sightings) {
    if (sighting.pose < 0 || sighting.landmark < 0 || sighting.pose >= poses || sighting.landmark >= landmarks) {
      throw InvalidArgument("sighting factor", std::to_string(sighting.pose) + " to " + std::to_string(sighting.landmark),
                            "must tie a pose and a landmark");
    }
  }
}

void Smoother::set_pattern() {
  std::vector<int> sizes(problem_.poses.size() - 1, 3);
  sizes.insert(sizes.end(), problem_.landmarks.size(), 2);
  if (sizes.empty()) return;  // the held pose alone
  std::vector<BlockPosition> blocks;
  blocks.reserve(problem_.motions.size() + problem_.sightings.size());
  const auto tie = [&blocks](int a, int b) {
    if (a >= 0 && b >= 0) blocks.emplace_back(std::max(a, b), std::min(a, b));
  };
  for (const MotionFactor& motion : problem_.motions) tie(block_of_pose(motion.from), block_of_pose(motion.to));
  for (const SightingFactor& sighting : problem_.sightings) tie(block_of_pose(sighting.pose), block_of_landmark(sighting.landmark));
  information_.set_pattern(sizes, blocks);
}

double Smoother::cost(const std::vector<Se2>& poses, const std::vector<Eigen::Vector2d>& landmarks) const {
  double sum = 0.0;  // (B-4)
  for (std::size_t i = 0; i < problem_.motions.size(); ++i) {
    const MotionFactor& factor = problem_.motions[i];
    const Eigen::Vector3d r = motion_residual(factor, poses[at(factor.from)], poses[at(factor.to)]).residual;
    sum += 0.5 * r.dot(motion_information_[i] * r);
  }
  for (std::size_t i = 0; i < problem_.sightings.size(); ++i) {
    const SightingFactor& factor = problem_.sightings[i];
    const Eigen::Vector2d r = sighting_residual(factor, poses[at(factor.pose)], landmarks[at(factor.landmark)]).residual;
    sum += robust_loss(config_.kernel, config_.kernel_width, r.dot(sighting_information_[i] * r)).cost;
  }
  return sum;
}

void Smoother::linearize() {
  information_.set_zero();
  gradient_.setZero(information_.rows());
  const auto add_gradient = [this](int block, const auto& part) {
    if (block >= 0) gradient_.segment<std::decay_t<decltype(part)>::RowsAtCompileTime>(information_.row_of(block)) += part;
  };
  for (std::size_t i = 0; i < problem_.motions.size(); ++i) {
    const MotionFactor& factor = problem_.motions[i];
    const MotionResidual at_estimate = motion_residual(factor, problem_.poses[at(factor.from)], problem_.poses[at(factor.to)]);
    const int from = block_of_pose(factor.from);
    const int to = block_of_pose(factor.to);
    const Eigen::Matrix3d from_W = at_estimate.J_from.transpose() * motion_information_[i];
    const Eigen::Matrix3d to_W = at_estimate.J_to.transpose() * motion_information_[i];
    information_.add<3, 3>(from, from, from_W * at_estimate.J_from);
    information_.add<3, 3>(to, to, to_W * at_estimate.J_to);
    information_.add<3, 3>(to, from, to_W * at_estimate.J_from);
    information_.add<3, 3>(from, to, from_W * at_estimate.J_to);
    add_gradient(from, Eigen::Vector3d(from_W * at_estimate.residual));
    add_gradient(to, Eigen::Vector3d(to_W * at_estimate.residual));
  }
  for (std::size_t i = 0; i < problem_.sightings.size(); ++i) {
    const SightingFactor& factor = problem_.sightings[i];
    const SightingResidual at_estimate =
        sighting_residual(factor, problem_.poses[at(factor.pose)], problem_.landmarks[at(factor.landmark)]);
    const Eigen::Vector2d& r = at_estimate.residual;
    const double weight = robust_loss(config_.kernel, config_.kernel_width, r.dot(sighting_information_[i] * r)).weight;
    const Eigen::Matrix2d W = weight * sighting_information_[i];  // (B-6)
    const int pose = block_of_pose(factor.pose);
    const int landmark = block_of_landmark(factor.landmark);
    const Eigen::Matrix<double, 3, 2> pose_W = at_estimate.J_pose.transpose() * W;
    const Eigen::Matrix2d landmark_W = at_estimate.J_landmark.transpose() * W;
    information_.add<3, 3>(pose, pose, pose_W * at_estimate.J_pose);
    information_.add<2, 2>(landmark, landmark, landmark_W * at_estimate.J_landmark);
    information_.add<2, 3>(landmark, pose, landmark_W * at_estimate.J_pose);
    add_gradient(pose, Eigen::Vector3d(pose_W * r));
    add_gradient(landmark, Eigen::Vector2d(landmark_W * r));
  }
}

void Smoother::factorize() {
  if (!information_.all_finite()) throw NotPositiveDefinite("information matrix of the mission", "a factor or an estimate is not finite");
  if (const std::optional<int> loose = information_.factorize()) {
    const auto poses = static_cast<int>(problem_.poses.size()) - 1;
    throw NotPositiveDefinite("information matrix of the mission",
                              (*loose < poses ? "pose " + std::to_string(*loose + 1) : "landmark " + std::to_string(*loose - poses)) +
                                  " is not held by any factor");
  }
}

SmoothingReport Smoother::optimize() {
  SmoothingReport report;
  report.poses = static_cast<int>(problem_.poses.size());
  report.landmarks = static_cast<int>(problem_.landmarks.size());
  report.sightings = static_cast<int>(problem_.sightings.size());
  double now = report.half_chi_squared_initial = cost(problem_.poses, problem_.landmarks);
  report.converged = information_.rows() == 0;
  double damping = kFirstDamping;
  linearize();
  Eigen::VectorXd diagonal = information_.diagonal();
  while (!report.converged && report.iterations < config_.max_iterations && damping <= kMostDamping) {
    ++report.iterations;
    information_.set_diagonal((1.0 + damping) * diagonal);  // (B-7)
    factorize();
    const Eigen::VectorXd step = information_.solve(-gradient_);
    const double promised = 0.5 * step.dot(damping * diagonal.cwiseProduct(step) - gradient_);  // (B-8)
    if (promised <= kPromisedDecrease + kRelativePromisedDecrease * now) {
      report.converged = true;
      break;
    }
    std::vector<Se2> poses = problem_.poses;
    std::vector<Eigen::Vector2d> landmarks = problem_.landmarks;
    for (int k = 1; k < report.poses; ++k)
      poses[at(k)] = additive_step(poses[at(k)], step.segment<3>(information_.row_of(block_of_pose(k))));
    for (int l = 0; l < report.landmarks; ++l) landmarks[at(l)] += step.segment<2>(information_.row_of(block_of_landmark(l)));
    const double then = cost(poses, landmarks);
    if (!(then < now)) {
      damping *= kDampingFactor;
      continue;
    }
    problem_.poses = std::move(poses);
    problem_.landmarks = std::move(landmarks);
    now = then;
    damping = std::max(kLeastDamping, damping / kDampingFactor);
    linearize();
    diagonal = information_.diagonal();
  }
  report.half_chi_squared_final = now;
  report.doubted = doubted();
  if (information_.rows() > 0) {
    information_.set_diagonal(diagonal);
    factorize();
    report.factor_entries = information_.factor_entries();
  }
  return report;
}

int Smoother::doubted() const {
  if (config_.kernel == RobustKernel::kNone) return 0;
  int count = 0;
  for (std::size_t i = 0; i < problem_.sightings.size(); ++i) {
    const SightingFactor& factor = problem_.sightings[i];
    const Eigen::Vector2d r = sighting_residual(factor, problem_.poses[at(factor.pose)], problem_.landmarks[at(factor.landmark)]).residual;
    count += r.dot(sighting_information_[i] * r) > config_.kernel_width * config_.kernel_width ? 1 : 0;
  }
  return count;
}

void Smoother::find_covariances() {
  if (information_.rows() > 0) information_.invert_pattern();
}

Eigen::MatrixXd Smoother::covariance_block(int a, int b) const {
  if (a < 0 || b < 0) return Eigen::Matrix3d::Zero();  // the pose that is held
  return information_.inverse_block(a, b);
}

Matrix6d Smoother::joint_covariance(int from, int to) const {
  const int a = block_of_pose(from);
  const int b = block_of_pose(to);
  Matrix6d P;
  P.topLeftCorner<3, 3>() = covariance_block(a, a);
  P.bottomRightCorner<3, 3>() = covariance_block(b, b);
  P.topRightCorner<3, 3>() = covariance_block(a, b);
  P.bottomLeftCorner<3, 3>() = P.topRightCorner<3, 3>().transpose();
  return P;
}

Eigen::Matrix3d Smoother::pose_covariance(int pose) const { return covariance_block(block_of_pose(pose), block_of_pose(pose)); }

Eigen::Matrix2d Smoother::landmark_covariance(int landmark) const {
  return information_.inverse_block(block_of_landmark(landmark), block_of_landmark(landmark));
}

}  // namespace ssjs
