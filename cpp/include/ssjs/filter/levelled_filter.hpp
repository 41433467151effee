/// Extended Kalman filter over [underwater vehicle | landmarks of three coordinates] in a levelled map. docs/math/auv.md, ekf.md
/// (F-3..F-7).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "ssjs/base/archive.hpp"
#include "ssjs/filter/ekf.hpp"
#include "ssjs/filter/symmetric_update.hpp"
#include "ssjs/sensors/constant_velocity.hpp"
#include "ssjs/sensors/side_scan.hpp"

namespace ssjs {

/// The rows of one sensor, or of one sighting of one landmark.
struct StateRows {
  static constexpr Eigen::Index kNoLandmark = -1;

  VehicleRows vehicle;
  Eigen::Index landmark = kNoLandmark;
  Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 3, 3> H_landmark{};  ///< as many rows as `vehicle`; unused without a landmark

  [[nodiscard]] Eigen::Index rows() const { return vehicle.residual.size(); }

  void archive(Archive& a) {
    a("vehicle", vehicle);
    a("landmark", landmark);
    a("H_landmark", H_landmark);
    a.require(vehicle.H.rows() == rows() && vehicle.R.rows() == rows() && vehicle.R.cols() == rows() &&
                  (landmark == kNoLandmark || H_landmark.rows() == rows()),
              "has rows that do not fit each other");
  }
};

/// Sees the linear operations on the error e = truth - estimate of a LevelledFilter, as they happen.
class LevelledFilterWatcher {
 public:
  LevelledFilterWatcher() = default;
  LevelledFilterWatcher(const LevelledFilterWatcher&) = delete;
  LevelledFilterWatcher& operator=(const LevelledFilterWatcher&) = delete;
  virtual ~LevelledFilterWatcher() = default;

  virtual void on_predict(const VehicleMatrix& F) = 0;
  /// K = Y L^-1, as in FilterWatcher.
  virtual void on_update(const std::vector<StateRows>& rows, const Eigen::Ref<const Eigen::MatrixXd>& Y,
                         const Eigen::Ref<const Eigen::MatrixXd>& L) = 0;
  virtual void on_add(const Eigen::Matrix<double, 3, VehicleLayout::kSize>& J_vehicle) = 0;
};

/// Additive errors, angles of the vehicle wrapped. Once the capacity is reached nothing of the size of the map allocates.
class LevelledFilter {
 public:
  static constexpr Eigen::Index kVehicle = VehicleLayout::kSize;

  explicit LevelledFilter(Eigen::Index landmark_capacity);

  /// Told of every later operation; not owned, must outlive its use here.
  void watch(LevelledFilterWatcher* watcher) { watcher_ = watcher; }

  /// Forgets every landmark.
  void reset(const VehicleVector& vehicle, const VehicleMatrix& covariance);

  /// e <- F e + noise of covariance Q on the vehicle; also how a quantity of the vehicle becomes a function of others.
  void predict(const VehiclePrediction& motion);

  /// The new landmark's index is landmarks() - 1 afterwards.
  void add_landmark(const SideScanLandmark& landmark);

  /// One stacked update. Throws NotPositiveDefinite when the innovation covariance is not, InvalidArgument for a residual that is not
  /// finite; the estimate is unchanged then.
  UpdateResult update(const std::vector<StateRows>& rows);

  /// Normalised innovation squared of these rows alone, rows() degrees of freedom.
  [[nodiscard]] double squared_distance(const StateRows& rows) const;
  /// H P H' of two blocks of rows.
  [[nodiscard]] Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3> predicted_covariance(const StateRows& a,
                                                                                                    const StateRows& b) const;

  [[nodiscard]] Eigen::Index landmarks() const { return landmarks_; }
  [[nodiscard]] Eigen::Index size() const { return offset(landmarks_); }
  [[nodiscard]] static Eigen::Index offset(Eigen::Index landmark) { return kVehicle + 3 * landmark; }
  [[nodiscard]] VehicleVector vehicle() const { return mean_.head<kVehicle>(); }
  [[nodiscard]] VehicleMatrix vehicle_covariance() const;
  [[nodiscard]] Eigen::Vector3d landmark_position(Eigen::Index landmark) const { return mean_.segment<3>(offset(landmark)); }
  [[nodiscard]] Eigen::VectorXd mean() const { return mean_.head(size()); }
  [[nodiscard]] Eigen::MatrixXd covariance() const;  ///< a copy, both triangles
  /// P(pose, all), 6 x size(): pose = position and attitude.
  [[nodiscard]] Eigen::Matrix<double, 6, Eigen::Dynamic> pose_rows() const;
  void read_pose_rows(Eigen::Ref<Eigen::Matrix<double, 6, Eigen::Dynamic>> rows) const;  ///< the same, into what is there

 private:
  void reserve(Eigen::Index landmarks);
  /// P H' of one block of rows, into columns [at, at + rows).
  void fill_columns(const StateRows& rows, Eigen::Ref<Eigen::MatrixXd> PHt) const;

  Eigen::Index landmarks_ = 0;
  Eigen::Index capacity_ = 0;  ///< landmarks
  Eigen::VectorXd mean_;
  Eigen::MatrixXd P_;  ///< lower triangle
  Eigen::MatrixXd PHt_, S_;
  Eigen::VectorXd innovation_;
  SymmetricDowndate downdate_;
  LevelledFilterWatcher* watcher_ = nullptr;

 public:
  /// The estimate; the workspace is what the size of the map asks for.
  void archive(Archive& a);
};

}  // namespace ssjs
