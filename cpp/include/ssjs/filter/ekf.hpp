/// Extended Kalman filter over [vehicle | landmarks]: the one place that changes a local covariance.
/// Thesis 3.2.7, 3.3.1 corrected; docs/math/ekf.md (F-1..F-10).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "ssjs/association/hypothesis.hpp"
#include "ssjs/features/feature.hpp"
#include "ssjs/filter/filter_watcher.hpp"
#include "ssjs/filter/map_state.hpp"
#include "ssjs/filter/symmetric_update.hpp"
#include "ssjs/sensors/motion.hpp"

namespace ssjs {

/// One linearised two-component observation of one landmark: residual = z - h, Jacobians at the current estimate.
struct LinearObservation {
  Eigen::Index landmark;
  Eigen::Vector2d residual;
  Eigen::Matrix<double, 2, 3> H_vehicle;
  Eigen::Matrix2d H_landmark;
  Eigen::Matrix2d R;
};

struct UpdateResult {
  double nis = 0.0;  ///< normalised innovation squared of the stacked update
  int dof = 0;
};

/// Which error a correction is linear in. kAdditive is the textbook EKF-SLAM; kInvariant measures it in right-invariant coordinates,
/// in which the linearisation does not depend on the estimate, so that the filter never gains heading out of nothing (F-8).
enum class ErrorForm { kAdditive, kInvariant };

/// Prediction costs O(1) a step: the vehicle-landmark covariance takes the accumulated transition only when it is read.
/// An update of k components costs O(n^2 k) on the lower triangle. Nothing allocates once the capacity is reached; a state
/// that outgrows its capacity doubles it.
class Ekf {
 public:
  /// A frozen pose stands in the additive form only: InvalidArgument otherwise.
  explicit Ekf(Eigen::Index landmark_capacity, ErrorForm error_form = ErrorForm::kAdditive, StateLayout layout = {});

  /// Told of every later operation; not owned, must outlive its use here. nullptr stops it.
  void watch(FilterWatcher* watcher) { watcher_ = watcher; }

  /// Forgets every landmark. A frozen pose is the vehicle's from now on. (F-9)
  void reset(const GaussianSe2& submap_T_vehicle);
  /// Goes on from another state of the same layout: the first state.landmarks() landmarks are its. Not told to a watcher.
  void restore(const MapState& state);

  void predict(const MotionPrediction& motion);  ///< (F-1); motion linearised at vehicle_pose()

  /// (F-5). The new landmark's index is landmarks() - 1 afterwards.
  void add_landmark(const Feature& feature);
  void add_landmark(const Eigen::Vector2d& submap_p_landmark, const Eigen::Matrix<double, 2, 3>& J_vehicle, const Eigen::Matrix2d& noise);
  /// A landmark whose error is J_state e + noise, J_state over the whole state (F-10). Not while a watcher is there: InvalidArgument.
  void add_dependent_landmark(const Eigen::Vector2d& submap_p_landmark,
                              const Eigen::Ref<const Eigen::Matrix<double, 2, Eigen::Dynamic>>& J_state, const Eigen::Matrix2d& noise);

  /// Marginalises a landmark out; the last landmark takes its index.
  void remove_landmark(Eigen::Index landmark);

  /// Predicted range and bearing of `landmarks` with H P H' in `problem.predicted*`; resizes within capacity only. (F-2)
  void predict_observations(const std::vector<Eigen::Index>& landmarks, PairingProblem& problem);

  /// One stacked update (F-3, F-4) with the pairs of `hypothesis`, where prediction j stands for landmarks[j].
  /// Throws NotPositiveDefinite naming the first landmark when the innovation covariance is not.
  UpdateResult update(const Features& features, const std::vector<Pair>& pairs, const std::vector<Eigen::Index>& landmarks);
  UpdateResult update(const std::vector<LinearObservation>& observations);

  [[nodiscard]] Eigen::Index landmarks() const { return landmarks_; }
  [[nodiscard]] const Se2& vehicle_pose() const { return vehicle_; }
  [[nodiscard]] Eigen::Matrix3d vehicle_covariance() const;
  [[nodiscard]] Se2 frozen_pose() const { return Se2::from_vector(mean_(StateLayout::frozen_pose())); }
  [[nodiscard]] GaussianSe2 frozen_T_vehicle();  ///< the vehicle seen from the frozen pose
  [[nodiscard]] Eigen::Vector2d landmark_position(Eigen::Index landmark) const { return mean_(layout_.landmark(landmark)); }
  [[nodiscard]] Eigen::Matrix2d landmark_covariance(Eigen::Index landmark) const;
  /// P(landmarks, vehicle), 2n x 3.
  [[nodiscard]] Eigen::Ref<const Eigen::MatrixXd> landmark_vehicle_covariance();
  [[nodiscard]] MapState state();  ///< a copy, both triangles

 private:
  void reserve(Eigen::Index landmarks);
  void move_additively(const Eigen::Ref<const Eigen::VectorXd>& step);
  void move_invariantly(const Eigen::Ref<const Eigen::VectorXd>& step);
  void settle();  ///< applies the pending transition to the vehicle-landmark covariance
  /// P(:, landmark) as n x 2, read from the lower triangle.
  void read_landmark_columns(Eigen::Index landmark, Eigen::Index n, Eigen::Ref<Eigen::MatrixXd> columns) const;

  ErrorForm error_form_;
  StateLayout layout_;
  Eigen::Index landmarks_ = 0;
  Eigen::Index capacity_ = 0;  ///< landmarks
  Se2 vehicle_;
  Eigen::VectorXd mean_;  ///< all but the vehicle block, which is kept in vehicle_
  Eigen::MatrixXd P_;     ///< lower triangle
  Eigen::Matrix3d transition_ = Eigen::Matrix3d::Identity();
  bool transition_pending_ = false;

  // Workspace, sized with the capacity.
  Eigen::MatrixXd PHt_;
  Eigen::MatrixXd S_;
  Eigen::VectorXd innovation_;
  Eigen::MatrixXd landmark_columns_;
  Eigen::VectorXd step_;
  Eigen::VectorXd transport_;  ///< (F-8): how far every coordinate follows a turn of the heading
  Eigen::VectorXd heading_column_;
  std::vector<LinearObservation> observations_;
  SymmetricDowndate downdate_;
  FilterWatcher* watcher_ = nullptr;
};

}  // namespace ssjs
