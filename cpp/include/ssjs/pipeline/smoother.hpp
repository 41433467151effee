/// Full nonlinear least squares over every pose and every landmark of a mission. docs/math/smoothing.md (B-1..B-10).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/geometry/gaussian.hpp"
#include "ssjs/joining/sparse_cholesky.hpp"

namespace ssjs {

enum class RobustKernel { kNone, kHuber, kCauchy };

struct SmoothingConfig {
  bool enabled = false;
  RobustKernel kernel = RobustKernel::kNone;
  double kernel_width = 2.5;
  int max_iterations = 100;
  bool covariance = true;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("enabled", enabled, "after the mission, least squares over every pose and every landmark, started from the joined map");
    v.choice("kernel", kernel,
             Choices<RobustKernel>{{"none", RobustKernel::kNone}, {"huber", RobustKernel::kHuber}, {"cauchy", RobustKernel::kCauchy}},
             "how much an observation far from where it should be still counts");
    v.field("kernel_width", kernel_width, Rule::positive(), "sigmas of an observation beyond which the robust kernel lets go");
    v.field("max_iterations", max_iterations, Rule::at_least(1), "steps tried at most");
    v.field("covariance", covariance, "false: trajectory and landmarks keep the covariance they had before smoothing");
  }
};

/// Pose `to` in the frame of pose `from`, measured; the covariance must be positive definite.
struct MotionFactor {
  int from = 0;
  int to = 0;
  GaussianSe2 from_T_to;
};

/// Landmark seen from a pose.
struct SightingFactor {
  int pose = 0;
  int landmark = 0;
  Eigen::Vector2d range_bearing = Eigen::Vector2d::Zero();  ///< m, rad
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();
};

/// Poses and landmarks in the global frame, where they are believed to be, and everything measured. Pose 0 is known exactly.
struct SmoothingProblem {
  std::vector<Se2> poses;
  std::vector<Eigen::Vector2d> landmarks;
  std::vector<MotionFactor> motions;
  std::vector<SightingFactor> sightings;
};

struct MotionResidual {
  Eigen::Vector3d residual;  ///< expected - measured, heading wrapped
  Eigen::Matrix3d J_from, J_to;
};
[[nodiscard]] MotionResidual motion_residual(const MotionFactor& factor, const Se2& global_T_from, const Se2& global_T_to);  // (B-2)

struct SightingResidual {
  Eigen::Vector2d residual;  ///< expected - measured, bearing wrapped
  Eigen::Matrix<double, 2, 3> J_pose;
  Eigen::Matrix2d J_landmark;
};
[[nodiscard]] SightingResidual sighting_residual(const SightingFactor& factor, const Se2& global_T_pose,
                                                 const Eigen::Vector2d& global_p_landmark);  // (B-3)

/// Cost of a whitened residual of that squared length, and its derivative by half that squared length: the weight of the factor (B-5).
struct RobustLoss {
  double cost;
  double weight;
};
[[nodiscard]] RobustLoss robust_loss(RobustKernel kernel, double width, double squared_distance);

struct SmoothingReport {
  double half_chi_squared_initial = 0.0;  ///< the cost (B-4), the robust kernel applied to sightings
  double half_chi_squared_final = 0.0;
  int iterations = 0;  ///< steps tried
  bool converged = false;
  int poses = 0, landmarks = 0, sightings = 0;
  int doubted = 0;  ///< sightings beyond the width of the robust kernel at the end; 0 without one
  double factor_entries = 0.0;
};

class Smoother {
 public:
  /// Throws InvalidArgument on factors that name what is not there, NotPositiveDefinite on a covariance that is none.
  Smoother(SmoothingProblem problem, const SmoothingConfig& config);

  /// Levenberg-Marquardt (B-6..B-8) from where the poses and landmarks are. Throws NotPositiveDefinite naming the pose or landmark that no
  /// factor holds.
  SmoothingReport optimize();

  [[nodiscard]] const std::vector<Se2>& poses() const { return problem_.poses; }
  [[nodiscard]] const std::vector<Eigen::Vector2d>& landmarks() const { return problem_.landmarks; }

  /// Once after optimize(), before the covariances are asked for (B-9, B-10).
  void find_covariances();
  /// Additive coordinates.
  [[nodiscard]] Matrix6d joint_covariance(int from, int to) const;  ///< of two poses that a motion ties
  [[nodiscard]] Eigen::Matrix3d pose_covariance(int pose) const;
  [[nodiscard]] Eigen::Matrix2d landmark_covariance(int landmark) const;

 private:
  [[nodiscard]] int block_of_pose(int pose) const { return pose - 1; }  ///< -1: pose 0, which is held
  [[nodiscard]] int block_of_landmark(int landmark) const { return static_cast<int>(problem_.poses.size()) - 1 + landmark; }
  [[nodiscard]] Eigen::MatrixXd covariance_block(int a, int b) const;
  void check() const;
  void set_pattern();
  [[nodiscard]] double cost(const std::vector<Se2>& poses, const std::vector<Eigen::Vector2d>& landmarks) const;
  void linearize();  ///< fills the information matrix and the gradient at the present estimate
  void factorize();
  [[nodiscard]] int doubted() const;

  SmoothingProblem problem_;
  SmoothingConfig config_;
  std::vector<Eigen::Matrix3d> motion_information_;
  std::vector<Eigen::Matrix2d> sighting_information_;
  SparseCholesky information_;
  Eigen::VectorXd gradient_;
};

}  // namespace ssjs
