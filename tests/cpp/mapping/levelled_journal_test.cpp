#include "ssjs/mapping/levelled_journal.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "mapping/survey_run.hpp"

namespace ssjs {
namespace {

using namespace ssjs::testing;  // NOLINT(google-build-using-namespace)

constexpr Eigen::Index kVehicle = VehicleLayout::kSize;

/// Carries Cov(e_step, e_now) forwards, the other way round than the journal.
class ForwardCovariance final : public LevelledFilterWatcher {
 public:
  void begin(const LevelledFilter& filter) {
    cross_ = filter.pose_rows();
    pose_ = filter.vehicle().head<6>();
    covariance_ = cross_.leftCols<6>();
  }
  [[nodiscard]] const Eigen::MatrixXd& cross() const { return cross_; }
  /// Of the pose of then, by all that was measured since.
  [[nodiscard]] const Vector6d& pose() const { return pose_; }
  [[nodiscard]] const Matrix6d& covariance() const { return covariance_; }

  void on_predict(const VehicleMatrix& F) override {
    if (cross_.size() > 0) cross_.leftCols<kVehicle>() = (cross_.leftCols<kVehicle>() * F.transpose()).eval();
  }
  void on_update(const std::vector<StateRows>& rows, const std::vector<Eigen::Index>& offsets, const Eigen::Ref<const Eigen::MatrixXd>& Y,
                 const Eigen::Ref<const Eigen::MatrixXd>& L) override {
    if (cross_.size() == 0) return;
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(Y.cols(), Y.rows());
    Eigen::Index i = 0;
    for (std::size_t b = 0; b < rows.size(); ++b) {
      const StateRows& block = rows[b];
      H.block(i, 0, block.rows(), kVehicle) = block.vehicle.H;
      if (block.landmark >= 0) H.block(i, offsets[b], block.rows(), 3) = block.H_landmark;
      if (block.is_of_ray()) H.block(i, offsets[b] + 3, block.rows(), 3) = block.H_ray;
      i += block.rows();
    }
    Eigen::VectorXd innovation(Y.cols());
    i = 0;
    for (const StateRows& block : rows) {
      innovation.segment(i, block.rows()) = block.vehicle.residual;
      i += block.rows();
    }
    const Eigen::MatrixXd lower = L.triangularView<Eigen::Lower>();
    const Eigen::MatrixXd gain = cross_ * H.transpose() * (lower * lower.transpose()).inverse();
    pose_ += gain * innovation;
    covariance_ -= gain * H * cross_.transpose();
    const Eigen::MatrixXd K = Y * Eigen::MatrixXd(L.triangularView<Eigen::Lower>()).inverse();
    cross_ -= (cross_ * H.transpose() * K.transpose()).eval();
  }
  void on_add(const Eigen::Ref<const Eigen::MatrixXd>& J_vehicle) override {
    if (cross_.size() == 0) return;
    const Eigen::MatrixXd added = cross_.leftCols<kVehicle>() * J_vehicle.transpose();
    cross_.conservativeResize(Eigen::NoChange, cross_.cols() + added.cols());
    cross_.rightCols(added.cols()) = added;
  }
  void on_convert(Eigen::Index offset, const Eigen::Matrix<double, 3, 6>& J) override {
    if (cross_.size() == 0) return;
    cross_.middleCols<3>(offset) = (cross_.middleCols<6>(offset) * J.transpose()).eval();
    on_drop(offset + 3, 3);
  }
  void on_drop(Eigen::Index offset, Eigen::Index rows) override {
    if (cross_.size() == 0) return;
    const Eigen::MatrixXd after = cross_.rightCols(cross_.cols() - offset - rows);
    cross_.conservativeResize(Eigen::NoChange, cross_.cols() - rows);
    cross_.rightCols(after.cols()) = after;
  }

 private:
  Eigen::MatrixXd cross_;
  Vector6d pose_;
  Matrix6d covariance_;
};

/// Both watchers at once.
class Both final : public LevelledFilterWatcher {
 public:
  Both(LevelledFilterWatcher& first, LevelledFilterWatcher& second) : first_(first), second_(second) {}
  void on_predict(const VehicleMatrix& F) override {
    first_.on_predict(F);
    second_.on_predict(F);
  }
  void on_update(const std::vector<StateRows>& rows, const std::vector<Eigen::Index>& offsets, const Eigen::Ref<const Eigen::MatrixXd>& Y,
                 const Eigen::Ref<const Eigen::MatrixXd>& L) override {
    first_.on_update(rows, offsets, Y, L);
    second_.on_update(rows, offsets, Y, L);
  }
  void on_add(const Eigen::Ref<const Eigen::MatrixXd>& J_vehicle) override {
    first_.on_add(J_vehicle);
    second_.on_add(J_vehicle);
  }
  void on_convert(Eigen::Index offset, const Eigen::Matrix<double, 3, 6>& J) override {
    first_.on_convert(offset, J);
    second_.on_convert(offset, J);
  }
  void on_drop(Eigen::Index offset, Eigen::Index rows) override {
    first_.on_drop(offset, rows);
    second_.on_drop(offset, rows);
  }

 private:
  LevelledFilterWatcher& first_;
  LevelledFilterWatcher& second_;
};

TEST(LevelledJournal, A18_BackwardsEqualsForwards) {
  Rng rng(81);
  LevelledFilter filter(4);
  LevelledJournal journal;
  ForwardCovariance forward;
  Both both(journal, forward);
  filter.watch(&both);
  VehicleVector x = VehicleVector::Zero();
  x(6) = 1.5;
  x(9) = 4.0;
  filter.reset(x, VehicleMatrix(0.01 * VehicleMatrix::Identity()));
  SideScanConfig side_scan;
  for (int tick = 0; tick < 60; ++tick) {
    filter.predict(predict_constant_velocity(filter.vehicle(), {0.05, -0.02, 0.2}, 0.1, {}));
    std::vector<StateRows> rows;
    if (tick % 2 == 0) rows.push_back({depth_rows(filter.vehicle(), filter.vehicle()(2) + rng.normal(0.05), {})});
    if (tick % 3 == 0) rows.push_back({compass_rows(filter.vehicle(), rng.normal(0.01), {})});
    SideScanSighting sighting;
    if (filter.landmarks() > 0 && tick % 5 == 0) {
      const Eigen::Index nth = tick % filter.landmarks();
      sighting.vehicle_p_point = map_T_vehicle(filter.vehicle()).inverse() * filter.landmark_position(nth) +
                                 Eigen::Vector3d(rng.normal(0.1), rng.normal(0.1), 0.0);
      const SideScanRows seen = side_scan_rows(filter.vehicle(), sighting, filter.landmark_position(nth), side_scan);
      rows.push_back({seen.vehicle, nth, seen.H_landmark});
    }
    filter.update(rows);
    if (tick % 10 == 7) {
      sighting.vehicle_p_point = {0.0, tick % 4 == 1 ? -10.0 : 8.0, 4.0};
      filter.add_landmark(*landmark_from_side_scan(filter.vehicle(), sighting, side_scan));
    }
    if (tick == 20 || tick == 40) journal.step(tick, filter);
    if (tick == 20) forward.begin(filter);
  }
  const std::vector<Eigen::Index> exit{0, 1, 5, 11, 10};
  const Eigen::MatrixXd expected = forward.cross()(Eigen::all, exit) * filter.covariance()(exit, exit).inverse();
  const std::vector<LevelledStep> steps = journal.take_steps(filter, exit);
  ASSERT_EQ(steps.size(), 2U);
  EXPECT_LT((steps[0].gain - expected).cwiseAbs().maxCoeff(), 1e-6 * expected.cwiseAbs().maxCoeff());
  const Matrix6d conditional = steps[0].covariance - expected * forward.cross()(Eigen::all, exit).transpose();
  EXPECT_LT((steps[0].conditional_covariance - conditional).cwiseAbs().maxCoeff(), 1e-7);
}

TEST(LevelledJournal, I10_BackwardsEqualsForwardsOverRaysThatChangeAndGo) {
  Rng rng(83);
  LevelledFilter filter(4);
  LevelledJournal journal;
  ForwardCovariance forward;
  Both both(journal, forward);
  filter.watch(&both);
  const PinholeCamera camera{320, 240, 280.0, 280.0, 159.5, 119.5};
  const CameraConfig config;
  VehicleVector x = VehicleVector::Zero();
  x(6) = 0.5;
  x(9) = 4.0;
  filter.reset(x, VehicleMatrix(1e-3 * VehicleMatrix::Identity()));
  int converted = 0, dropped = 0;
  for (int tick = 0; tick < 60; ++tick) {
    filter.predict(predict_constant_velocity(filter.vehicle(), {0.05, -0.02, 0.2}, 0.1, {}));
    std::vector<StateRows> rows;
    if (tick % 2 == 0) rows.push_back({depth_rows(filter.vehicle(), filter.vehicle()(2) + rng.normal(0.05), {})});
    if (tick % 3 == 0) rows.push_back({compass_rows(filter.vehicle(), rng.normal(0.01), {})});
    for (Eigen::Index i = tick % 2; i < filter.landmarks(); i += 2) {
      StateRows block{VehicleRows(2), i, {}, {}};
      const auto take = [&](const auto& seen) {
        block.vehicle.residual << rng.normal(), rng.normal();
        block.vehicle.H = seen.H_vehicle;
        block.vehicle.R.setIdentity();
        block.H_landmark = seen.H_landmark.template leftCols<3>();
      };
      if (filter.is_ray(i)) {
        const auto seen = predict_pixel(filter.vehicle(), filter.ray(i), camera, config);
        take(*seen);
        block.H_ray = seen->H_landmark.rightCols<3>();
      } else {
        take(*predict_pixel(filter.vehicle(), filter.landmark_position(i), camera, config));
      }
      rows.push_back(block);
    }
    filter.update(rows);
    if (tick % 6 == 1) filter.add_landmark(*ray_from_pixel(filter.vehicle(), {rng.uniform(40, 280), rng.uniform(40, 200)}, camera, config));
    if (tick % 9 == 8 && filter.is_ray(tick % filter.landmarks())) {
      filter.convert_to_point(tick % filter.landmarks());
      ++converted;
    }
    if (tick % 11 == 10) {
      filter.drop_landmark(tick % filter.landmarks());
      ++dropped;
    }
    if (tick == 20 || tick == 40) journal.step(tick, filter);
    if (tick == 20) forward.begin(filter);
  }
  EXPECT_GT(converted, 2);
  EXPECT_GT(dropped, 2);
  EXPECT_TRUE(journal.fits(filter));
  const std::vector<Eigen::Index> exit{0, 1, 5, 11, 10};
  const Eigen::MatrixXd expected = forward.cross()(Eigen::all, exit) * filter.covariance()(exit, exit).inverse();
  const std::vector<LevelledStep> steps = journal.take_steps(filter, exit);
  ASSERT_EQ(steps.size(), 2U);
  EXPECT_LT((steps[0].gain - expected).cwiseAbs().maxCoeff(), 1e-5 * expected.cwiseAbs().maxCoeff());
  EXPECT_LT((steps[0].base_T_vehicle - forward.pose()).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((steps[0].covariance - forward.covariance()).cwiseAbs().maxCoeff(), 1e-10);
}

/// A linear system over the vehicle's state and landmarks, beside the least-squares solution over all of its past.
TEST(LevelledJournal, A24_StepsAreTheLeastSquaresSolutionOfTheWholeMapInALinearWorld) {
  constexpr int kTimes = 8;
  constexpr int kStepAt = 3;
  Rng rng(82);
  LevelledFilter filter(2);
  LevelledJournal journal;
  filter.watch(&journal);
  const auto normal_matrix = [&](Eigen::Index rows, Eigen::Index columns, double scale) {
    Eigen::MatrixXd A(rows, columns);
    for (Eigen::Index i = 0; i < A.size(); ++i) A(i) = scale * rng.normal();
    return A;
  };
  const VehicleMatrix P0 = 0.01 * VehicleMatrix::Identity();
  filter.reset(VehicleVector::Zero(), P0);
  // unknowns: the vehicle at every time, then one landmark, which is added at time 1
  const Eigen::Index landmark_at = kVehicle * kTimes;
  const Eigen::Index size = landmark_at + 3;
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(size, size);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(size);
  const auto add_rows = [&](const Eigen::MatrixXd& A, const Eigen::VectorXd& b, const Eigen::MatrixXd& covariance) {
    const Eigen::MatrixXd W = covariance.inverse();
    information += A.transpose() * W * A;
    right += A.transpose() * W * b;
  };
  const auto at = [&](int time, const Eigen::MatrixXd& J) {
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(J.rows(), size);
    A.middleCols(kVehicle * time, kVehicle) = J;
    return A;
  };
  add_rows(at(0, VehicleMatrix::Identity()), VehicleVector::Zero(), P0);
  for (int time = 0; time < kTimes; ++time) {
    if (time > 0) {
      VehiclePrediction motion{filter.vehicle(), VehicleMatrix::Identity(), VehicleMatrix::Zero()};
      motion.F += normal_matrix(kVehicle, kVehicle, 0.1);
      motion.state = motion.F * filter.vehicle();
      motion.Q = 1e-4 * VehicleMatrix::Identity();
      filter.predict(motion);
      Eigen::MatrixXd A = at(time, VehicleMatrix::Identity());
      A.middleCols(kVehicle * (time - 1), kVehicle) = -motion.F;
      add_rows(A, VehicleVector::Zero(), motion.Q);
    }
    if (time == 1) {
      SideScanLandmark landmark;
      landmark.J_vehicle = normal_matrix(3, kVehicle, 1.0);
      landmark.map_p_landmark = landmark.J_vehicle * filter.vehicle();
      landmark.noise = 1e-3 * Eigen::Matrix3d::Identity();
      filter.add_landmark(landmark);
      Eigen::MatrixXd A = at(time, -landmark.J_vehicle);
      A.rightCols<3>().setIdentity();
      add_rows(A, Eigen::Vector3d::Zero(), landmark.noise);
    }
    StateRows rows{VehicleRows(3)};
    rows.vehicle.H = normal_matrix(3, kVehicle, 1.0);
    rows.vehicle.R = 1e-3 * Eigen::Matrix3d::Identity();
    Eigen::MatrixXd A = at(time, rows.vehicle.H);
    Eigen::Vector3d expected = rows.vehicle.H * filter.vehicle();
    if (time > 1) {
      rows.landmark = 0;
      rows.H_landmark = normal_matrix(3, 3, 1.0);
      A.rightCols<3>() = rows.H_landmark;
      expected += rows.H_landmark * filter.landmark_position(0);
    }
    const Eigen::Vector3d z = normal_matrix(3, 1, 0.02);
    rows.vehicle.residual = z - expected;
    filter.update({rows});
    add_rows(A, z, rows.vehicle.R);
    if (time == kStepAt) journal.step(time, filter);
  }
  const Eigen::MatrixXd covariance = information.inverse();
  const Eigen::VectorXd solution = covariance * right;
  const std::vector<LevelledStep> steps = journal.take_steps(filter, {0, 1, 5});
  ASSERT_EQ(steps.size(), 1U);
  const Eigen::Index first = kVehicle * kStepAt;
  EXPECT_LT((steps[0].base_T_vehicle - solution.segment<6>(first)).norm(), 1e-9);
  EXPECT_LT((steps[0].covariance - covariance.block<6, 6>(first, first)).norm(), 1e-9);
  const std::vector<Eigen::Index> exit{kVehicle * (kTimes - 1), kVehicle * (kTimes - 1) + 1, kVehicle * (kTimes - 1) + 5};
  const Eigen::MatrixXd with_exit = covariance.middleRows<6>(first)(Eigen::all, exit);
  EXPECT_LT((steps[0].gain - with_exit * covariance(exit, exit).inverse()).norm(), 1e-5);
}

TEST(LevelledJournal, A24_WhatItCannotRememberStaysAsFiltered) {
  LevelledFilter filter(4);
  LevelledJournal journal(true, std::size_t{1} << 20U);
  filter.watch(&journal);
  VehicleVector x = VehicleVector::Zero();
  x(6) = 1.5;
  filter.reset(x, VehicleMatrix(0.01 * VehicleMatrix::Identity()));
  for (int tick = 0; tick < 1000; ++tick) {
    filter.predict(predict_constant_velocity(filter.vehicle(), Eigen::Vector3d::Zero(), 0.1, {}));
    filter.update({{depth_rows(filter.vehicle(), 0.05, {})}});
    if (tick % 100 == 50) journal.step(tick, filter);
  }
  const std::vector<LevelledStep> steps = journal.take_steps(filter, {0, 1, 5});
  ASSERT_EQ(steps.size(), 10U);
  EXPECT_EQ(steps.front().gain.norm(), 0.0);
  EXPECT_GT(steps.back().gain.norm(), 0.1);
}

TEST(LevelledJournal, A18_ConditionedPosesAreConsistent) {
  // the middle step of every map, given the TRUE exit and offsets of the map
  double sum = 0.0, as_filtered = 0.0, conditioned = 0.0;
  int maps = 0;
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    const SimulatedSurvey survey = simulate_survey(survey_world({}, seed), {}, seed);
    LevelledBuilderConfig config = matched({});
    split_every(config, 50.0);
    for (const LevelledSubmap& map : build_maps(survey, config)) {
      if (map.closed_because == "end") continue;
      const LevelledStep& step = map.steps[map.steps.size() / 2];
      const VehicleVector truth = true_vehicle(truth_at(survey, step.time_s), truth_at(survey, map.start_time_s));
      const Eigen::VectorXd exit_error = map_error(map, survey).head<5>();
      ASSERT_EQ(step.gain.cols(), 5);
      Vector6d error = truth.head<6>() - step.base_T_vehicle - step.gain * exit_error;
      for (Eigen::Index i = 3; i < 6; ++i) error(i) = wrap_angle(error(i));
      sum += normalized_squared_error(error, step.conditional_covariance);
      as_filtered += step.covariance(0, 0) + step.covariance(1, 1);
      conditioned += step.conditional_covariance(0, 0) + step.conditional_covariance(1, 1);
      ++maps;
    }
  }
  const Band band = mean_band(6, maps, 0.999);
  EXPECT_GT(sum / maps, band.lower);
  EXPECT_LT(sum / maps, band.upper);
  EXPECT_LT(conditioned, 0.8 * as_filtered);
}

}  // namespace
}  // namespace ssjs
