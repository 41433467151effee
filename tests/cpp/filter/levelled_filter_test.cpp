#include "ssjs/filter/levelled_filter.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <limits>

#include "sensors/random_vehicle.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/base/random.hpp"

namespace ssjs {
namespace {

using testing::random_vehicle;

constexpr Eigen::Index kVehicle = VehicleLayout::kSize;

Eigen::MatrixXd random_matrix(Rng& rng, Eigen::Index rows, Eigen::Index columns) {
  Eigen::MatrixXd M(rows, columns);
  for (Eigen::Index c = 0; c < columns; ++c) {
    for (Eigen::Index r = 0; r < rows; ++r) M(r, c) = rng.normal();
  }
  return M;
}

Eigen::MatrixXd random_covariance(Rng& rng, Eigen::Index n) {
  const Eigen::MatrixXd A = random_matrix(rng, n, n);
  return A * A.transpose() / static_cast<double>(n) + 0.1 * Eigen::MatrixXd::Identity(n, n);
}

StateRows random_rows(Rng& rng, Eigen::Index rows, Eigen::Index landmark, bool is_ray = false) {
  StateRows block{VehicleRows(rows), landmark, random_matrix(rng, rows, 3)};
  if (is_ray) block.H_ray = random_matrix(rng, rows, 3);
  block.vehicle.residual = 0.05 * random_matrix(rng, rows, 1);
  block.vehicle.H = random_matrix(rng, rows, kVehicle);
  block.vehicle.R = random_covariance(rng, rows);
  return block;
}

/// The textbook with full matrices and Joseph's form.
struct DenseFilter {
  Eigen::VectorXd mean;
  Eigen::MatrixXd P;
  std::vector<Eigen::Index> offsets{};  ///< of the landmarks

  void predict(const VehiclePrediction& motion) {
    Eigen::MatrixXd F = Eigen::MatrixXd::Identity(mean.size(), mean.size());
    F.topLeftCorner<kVehicle, kVehicle>() = motion.F;
    P = (F * P * F.transpose()).eval();
    P.topLeftCorner<kVehicle, kVehicle>() += motion.Q;
    mean.head<kVehicle>() = motion.state;
  }
  void add(const Eigen::VectorXd& landmark, const Eigen::MatrixXd& J_vehicle, const Eigen::MatrixXd& noise) {
    const Eigen::Index n = mean.size();
    const Eigen::Index rows = landmark.size();
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(n + rows, n);
    J.topRows(n).setIdentity();
    J.block(n, 0, rows, kVehicle) = J_vehicle;
    P = (J * P * J.transpose()).eval();
    P.bottomRightCorner(rows, rows) += noise;
    mean.conservativeResize(n + rows);
    mean.tail(rows) = landmark;
    offsets.push_back(n);
  }
  /// (I-8), (I-9): rows from `at` on become J times themselves; without J they go.
  void replace(std::size_t landmark, Eigen::Index rows, const Eigen::MatrixXd& J, const Eigen::VectorXd& value) {
    const Eigen::Index at = offsets[landmark];
    const Eigen::Index n = mean.size();
    Eigen::MatrixXd T = Eigen::MatrixXd::Zero(n - rows + J.rows(), n);
    T.topLeftCorner(at, at).setIdentity();
    T.block(at, at, J.rows(), rows) = J;
    T.bottomRightCorner(n - at - rows, n - at - rows).setIdentity();
    P = (T * P * T.transpose()).eval();
    mean = (T * mean).eval();
    mean.segment(at, J.rows()) = value;
    for (std::size_t i = landmark + 1; i < offsets.size(); ++i) offsets[i] -= rows - J.rows();
    if (J.rows() == 0) offsets.erase(offsets.begin() + static_cast<std::ptrdiff_t>(landmark));
  }
  double update(const std::vector<StateRows>& blocks) {
    Eigen::Index k = 0;
    for (const StateRows& block : blocks) k += block.rows();
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(k, mean.size());
    Eigen::MatrixXd R = Eigen::MatrixXd::Zero(k, k);
    Eigen::VectorXd nu(k);
    Eigen::Index i = 0;
    for (const StateRows& block : blocks) {
      H.block(i, 0, block.rows(), kVehicle) = block.vehicle.H;
      if (block.landmark >= 0) {
        const Eigen::Index at = offsets[static_cast<std::size_t>(block.landmark)];
        H.block(i, at, block.rows(), 3) = block.H_landmark;
        if (block.is_of_ray()) H.block(i, at + 3, block.rows(), 3) = block.H_ray;
      }
      R.block(i, i, block.rows(), block.rows()) = block.vehicle.R;
      nu.segment(i, block.rows()) = block.vehicle.residual;
      i += block.rows();
    }
    const Eigen::MatrixXd S_inverse = (H * P * H.transpose() + R).inverse();
    const Eigen::MatrixXd K = P * H.transpose() * S_inverse;
    const Eigen::MatrixXd I_KH = Eigen::MatrixXd::Identity(mean.size(), mean.size()) - K * H;
    mean += K * nu;
    VehicleVector vehicle = mean.head<kVehicle>();
    wrap_vehicle(vehicle);
    mean.head<kVehicle>() = vehicle;
    P = (I_KH * P * I_KH.transpose() + K * R * K.transpose()).eval();
    return nu.dot(S_inverse * nu);
  }
};

TEST(LevelledFilter, A15_EqualsTheDenseFilterOverRandomOperations) {
  Rng rng(71);
  LevelledFilter filter(1);  // grows on the way
  DenseFilter dense;
  dense.mean = random_vehicle(rng, 0);
  dense.P = random_covariance(rng, kVehicle);
  filter.reset(dense.mean, dense.P);
  for (int operation = 0; operation < 120; ++operation) {
    if (operation % 5 == 0) {
      SideScanLandmark landmark;
      landmark.map_p_landmark = random_matrix(rng, 3, 1);
      landmark.J_vehicle = random_matrix(rng, 3, kVehicle);
      landmark.noise = random_covariance(rng, 3);
      filter.add_landmark(landmark);
      dense.add(landmark.map_p_landmark, landmark.J_vehicle, landmark.noise);
    } else if (operation % 2 == 0) {
      VehiclePrediction motion;
      motion.state = random_vehicle(rng, operation);
      motion.F = VehicleMatrix::Identity() + 0.05 * random_matrix(rng, kVehicle, kVehicle);
      motion.Q = 0.01 * random_covariance(rng, kVehicle);
      filter.predict(motion);
      dense.predict(motion);
    } else {
      std::vector<StateRows> rows{random_rows(rng, 2, StateRows::kNoLandmark), random_rows(rng, 1, StateRows::kNoLandmark)};
      for (Eigen::Index i = 0; i < filter.landmarks(); i += 3) rows.push_back(random_rows(rng, i % 2 == 0 ? 3 : 2, i));
      const Eigen::MatrixXd P = dense.P;
      const double one = filter.squared_distance(rows.back());
      DenseFilter alone = dense;
      EXPECT_NEAR(one, alone.update({rows.back()}), 1e-9 * (1.0 + one));
      const UpdateResult result = filter.update(rows);
      EXPECT_NEAR(result.nis, dense.update(rows), 1e-8 * (1.0 + result.nis));
    }
    ASSERT_EQ(filter.size(), dense.mean.size());
    EXPECT_LT((filter.mean() - dense.mean).cwiseAbs().maxCoeff(), 1e-8);
    EXPECT_LT((filter.covariance() - dense.P).cwiseAbs().maxCoeff(), 1e-8);
    EXPECT_LT((filter.pose_rows() - dense.P.topRows<6>()).cwiseAbs().maxCoeff(), 1e-8);
  }
}

NewRay random_ray(Rng& rng) {
  NewRay ray;
  ray.ray = 0.3 * random_matrix(rng, 6, 1);
  ray.ray(5) = 1.5;
  ray.J_vehicle = 0.1 * random_matrix(rng, 6, kVehicle);
  ray.noise = 0.05 * random_covariance(rng, 6);
  return ray;
}

TEST(LevelledFilter, I8_I9_RaysThatComeChangeAndGoEqualTheDenseFilter) {
  Rng rng(75);
  LevelledFilter filter(1);
  DenseFilter dense;
  dense.mean = random_vehicle(rng, 0);
  dense.P = 0.1 * random_covariance(rng, kVehicle);
  filter.reset(dense.mean, dense.P);
  int converted = 0, dropped = 0;
  for (int operation = 0; operation < 200; ++operation) {
    const Eigen::Index n = filter.landmarks();
    const Eigen::Index some = n == 0 ? 0 : operation % n;
    if (operation % 4 == 0) {
      const NewRay ray = random_ray(rng);
      filter.add_landmark(ray);
      dense.add(ray.ray, ray.J_vehicle, ray.noise);
    } else if (operation % 4 == 1) {
      std::vector<StateRows> rows{random_rows(rng, 3, StateRows::kNoLandmark)};
      for (Eigen::Index i = 0; i < n; i += 2) rows.push_back(random_rows(rng, 2, i, filter.is_ray(i)));
      std::vector<StateRows> two{rows.back(), rows.front()};
      const Eigen::MatrixXd joint = filter.joint_covariance(two);
      EXPECT_LT((filter.predicted_covariance(two[0], two[1]) - joint.topRightCorner(two[0].rows(), two[1].rows())).norm(), 1e-9);
      EXPECT_LT((filter.predicted_covariance(two[0], two[0]) - joint.topLeftCorner(two[0].rows(), two[0].rows())).norm(), 1e-9);
      DenseFilter alone = dense;
      const double one = filter.squared_distance(rows.back());
      EXPECT_NEAR(one, alone.update({rows.back()}), 1e-9 * (1.0 + one));
      const UpdateResult result = filter.update(rows);
      EXPECT_NEAR(result.nis, dense.update(rows), 1e-8 * (1.0 + result.nis));
    } else if (operation % 4 == 2 && n > 0 && filter.is_ray(some) && filter.ray(some)(5) > 0.5) {
      const ConvertedPoint point = to_point(filter.ray(some));
      filter.convert_to_point(some);
      dense.replace(static_cast<std::size_t>(some), 6, point.J, point.map_p_point);
      EXPECT_FALSE(filter.is_ray(some));
      EXPECT_EQ(filter.landmark_position(some), point.map_p_point);
      ++converted;
    } else if (operation % 12 == 3 && n > 0) {
      const Eigen::Index rows = filter.rows_of(some);
      filter.drop_landmark(some);
      dense.replace(static_cast<std::size_t>(some), rows, Eigen::MatrixXd(0, rows), Eigen::VectorXd(0));
      EXPECT_EQ(filter.landmarks(), n - 1);
      ++dropped;
    }
    ASSERT_EQ(filter.size(), dense.mean.size());
    ASSERT_LT((filter.mean() - dense.mean).cwiseAbs().maxCoeff(), 1e-8) << operation;
    ASSERT_LT((filter.covariance() - dense.P).cwiseAbs().maxCoeff(), 1e-8) << operation;
  }
  EXPECT_GT(converted, 10);
  EXPECT_GT(dropped, 10);
}

TEST(LevelledFilter, NamesWhatIsWrongWithAnUpdateAndStaysAsItWas) {
  LevelledFilter filter(2);
  Rng rng(72);
  filter.reset(random_vehicle(rng, 0), VehicleMatrix::Identity());
  const Eigen::VectorXd mean = filter.mean();
  StateRows rows = random_rows(rng, 2, StateRows::kNoLandmark);
  rows.vehicle.residual(1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(filter.update({rows}), InvalidArgument);
  rows = random_rows(rng, 1, StateRows::kNoLandmark);
  rows.vehicle.R(0, 0) = -1e6;
  EXPECT_THROW(filter.update({rows}), NotPositiveDefinite);
  EXPECT_EQ(filter.mean(), mean);
  EXPECT_EQ(filter.vehicle_covariance(), VehicleMatrix(VehicleMatrix::Identity()));
}

}  // namespace
}  // namespace ssjs
