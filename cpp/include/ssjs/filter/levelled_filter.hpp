/// Extended Kalman filter over [underwater vehicle | landmarks] in a levelled map; a landmark is a point of three coordinates, or a ray of
/// six until its distance is known. docs/math/auv.md, ekf.md (F-3..F-7), camera.md (I-8..I-10).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "ssjs/base/archive.hpp"
#include "ssjs/filter/ekf.hpp"
#include "ssjs/filter/symmetric_update.hpp"
#include "ssjs/sensors/constant_velocity.hpp"
#include "ssjs/sensors/pinhole.hpp"
#include "ssjs/sensors/side_scan.hpp"

namespace ssjs {

/// The rows of one sensor, or of one sighting of one landmark.
struct StateRows {
  static constexpr Eigen::Index kNoLandmark = -1;

  VehicleRows vehicle;
  Eigen::Index landmark = kNoLandmark;
  Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 3, 3> H_landmark{};  ///< as many rows as `vehicle`; unused without a landmark
  Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 3, 3> H_ray{};       ///< of the last three of a ray's six; no rows: a point

  [[nodiscard]] Eigen::Index rows() const { return vehicle.residual.size(); }
  [[nodiscard]] bool is_of_ray() const { return H_ray.rows() > 0; }

  void archive(Archive& a) {
    a("vehicle", vehicle);
    a("landmark", landmark);
    a("H_landmark", H_landmark);
    a("H_ray", H_ray);
    a.require(vehicle.H.rows() == rows() && vehicle.R.rows() == rows() && vehicle.R.cols() == rows() &&
                  (landmark == kNoLandmark || H_landmark.rows() == rows()) && (!is_of_ray() || H_ray.rows() == rows()),
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
  /// K = Y L^-1, as in FilterWatcher. `offsets`: where the landmark of each block begins in the state; 0 without one.
  virtual void on_update(const std::vector<StateRows>& rows, const std::vector<Eigen::Index>& offsets,
                         const Eigen::Ref<const Eigen::MatrixXd>& Y, const Eigen::Ref<const Eigen::MatrixXd>& L) = 0;
  /// A point of 3 rows or a ray of 6, at the end of the state.
  virtual void on_add(const Eigen::Ref<const Eigen::MatrixXd>& J_vehicle) = 0;
  /// The six rows from `offset` on became the three of a point. (I-8)
  virtual void on_convert(Eigen::Index offset, const Eigen::Matrix<double, 3, 6>& J) = 0;
  /// So many rows from `offset` on are gone. (I-9)
  virtual void on_drop(Eigen::Index offset, Eigen::Index rows) = 0;
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
  void add_landmark(const NewRay& ray);

  /// The ray becomes a point where it is; it keeps its index. Throws InvalidArgument for one that is at infinity. (I-8)
  void convert_to_point(Eigen::Index landmark);
  /// Marginalises a landmark: those after it move up by one. (I-9)
  void drop_landmark(Eigen::Index landmark);

  /// One stacked update. Throws NotPositiveDefinite when the innovation covariance is not, InvalidArgument for a residual that is not
  /// finite; the estimate is unchanged then.
  UpdateResult update(const std::vector<StateRows>& rows);

  /// Normalised innovation squared of these rows alone, rows() degrees of freedom.
  [[nodiscard]] double squared_distance(const StateRows& rows) const;
  /// H P H' of two blocks of rows.
  [[nodiscard]] Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3> predicted_covariance(const StateRows& a,
                                                                                                    const StateRows& b) const;

  /// H P H' of all these rows together, lower triangle and upper. (I-11)
  [[nodiscard]] Eigen::MatrixXd joint_covariance(const std::vector<StateRows>& rows) const;

  [[nodiscard]] Eigen::Index landmarks() const { return static_cast<Eigen::Index>(offsets_.size()) - 1; }
  [[nodiscard]] Eigen::Index size() const { return offsets_.back(); }
  /// First row of a landmark; of landmarks(): size().
  [[nodiscard]] Eigen::Index offset(Eigen::Index landmark) const { return offsets_[static_cast<std::size_t>(landmark)]; }
  [[nodiscard]] Eigen::Index rows_of(Eigen::Index landmark) const { return offset(landmark + 1) - offset(landmark); }  ///< 3 or 6
  [[nodiscard]] bool is_ray(Eigen::Index landmark) const { return rows_of(landmark) == 6; }
  [[nodiscard]] VehicleVector vehicle() const { return mean_.head<kVehicle>(); }
  [[nodiscard]] VehicleMatrix vehicle_covariance() const;
  /// Of a point.
  [[nodiscard]] Eigen::Vector3d landmark_position(Eigen::Index landmark) const { return mean_.segment<3>(offset(landmark)); }
  [[nodiscard]] InverseDepth ray(Eigen::Index landmark) const { return mean_.segment<6>(offset(landmark)); }
  [[nodiscard]] double inverse_depth_sigma(Eigen::Index landmark) const;
  [[nodiscard]] Eigen::VectorXd mean() const { return mean_.head(size()); }
  [[nodiscard]] Eigen::MatrixXd covariance() const;  ///< a copy, both triangles
  /// P(pose, all), 6 x size(): pose = position and attitude.
  [[nodiscard]] Eigen::Matrix<double, 6, Eigen::Dynamic> pose_rows() const;
  void read_pose_rows(Eigen::Ref<Eigen::Matrix<double, 6, Eigen::Dynamic>> rows) const;  ///< the same, into what is there

 private:
  void reserve(Eigen::Index rows);  ///< of landmarks
  template <Eigen::Index Rows>
  void add(const Eigen::Matrix<double, Rows, 1>& mean, const Eigen::Matrix<double, Rows, kVehicle>& J,
           const Eigen::Matrix<double, Rows, Rows>& noise);
  /// So many rows from `first` on leave the state.
  void cut(Eigen::Index first, Eigen::Index rows);
  /// P H' of one block of rows, into columns [at, at + rows).
  void fill_columns(const StateRows& rows, Eigen::Ref<Eigen::MatrixXd> PHt) const;
  [[nodiscard]] Eigen::Matrix3d covariance_block(Eigen::Index a, Eigen::Index b) const;
  /// P H' of three rows of the state from `at` on that a block sees besides the vehicle.
  void add_columns(Eigen::Index at, const Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3>& Ht, Eigen::Ref<Eigen::MatrixXd> PHt) const;
  /// H P H' of these blocks from their columns P H', without the noise.
  void fill_innovation(const std::vector<StateRows>& rows, const Eigen::Ref<const Eigen::MatrixXd>& PHt,
                       Eigen::Ref<Eigen::MatrixXd> S) const;

  std::vector<Eigen::Index> offsets_{kVehicle};  ///< of each landmark, and behind the last
  Eigen::Index capacity_ = 0;                    ///< rows of landmarks
  Eigen::VectorXd mean_;
  Eigen::MatrixXd P_;  ///< lower triangle
  Eigen::MatrixXd PHt_, S_;
  Eigen::VectorXd innovation_;
  std::vector<Eigen::Index> seen_;  ///< for the watcher: offset of the landmark of each block
  SymmetricDowndate downdate_;
  LevelledFilterWatcher* watcher_ = nullptr;

 public:
  /// The estimate; the workspace is what the size of the map asks for.
  void archive(Archive& a);
};

}  // namespace ssjs
