#include "ssjs/joining/conditionally_independent.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <map>
#include <vector>

#include "joining/drive.hpp"
#include "joining/equal_answers.hpp"
#include "pipeline/short_survey.hpp"
#include "ssjs/sensors/range_bearing.hpp"

namespace ssjs {
namespace {

using testing::AnswerDifference;
using testing::drive;
using testing::ShortSurvey;

constexpr double kSame = 1e-9;  // m, m^2, rad: the project's bar for this method

/// A textbook EKF over [vehicle | clones of past poses | landmarks], all of it in one matrix: nothing of the library but the models.
class ClonedFilter {
 public:
  void predict(const MotionPrediction& motion) {
    mean_.head<3>() = motion.submap_T_vehicle.vector();
    Eigen::MatrixXd F = Eigen::MatrixXd::Identity(mean_.size(), mean_.size());
    F.topLeftCorner<3, 3>() = motion.F;
    P_ = (F * P_ * F.transpose()).eval();
    P_.topLeftCorner<3, 3>() += motion.Q;
  }
  void update(const Features& scan) {
    std::vector<const Feature*> known;
    for (const Feature& feature : scan) {
      if (row_of_.count(*feature.landmark_id) != 0) known.push_back(&feature);
    }
    const auto k = static_cast<Eigen::Index>(2 * known.size());
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(k, mean_.size());
    Eigen::MatrixXd R = Eigen::MatrixXd::Zero(k, k);
    Eigen::VectorXd residual(k);
    for (Eigen::Index i = 0; i < k; i += 2) {
      const Feature& feature = *known[static_cast<std::size_t>(i / 2)];
      const Eigen::Index row = row_of_.at(*feature.landmark_id);
      const RangeBearingPrediction h = predict_range_bearing(vehicle(), Eigen::Vector2d(mean_.segment<2>(row)));
      residual.segment<2>(i) << feature.range() - h.range_bearing.x(), angle_difference(feature.bearing(), h.range_bearing.y());
      H.block<2, 3>(i, 0) = h.H_vehicle;
      H.block<2, 2>(i, row) = h.H_landmark;
      R.block<2, 2>(i, i) = feature.covariance;
    }
    if (k > 0) {
      const Eigen::MatrixXd K = P_ * H.transpose() * (H * P_ * H.transpose() + R).inverse();
      const Eigen::MatrixXd A = Eigen::MatrixXd::Identity(mean_.size(), mean_.size()) - K * H;
      mean_ += K * residual;
      P_ = (A * P_ * A.transpose() + K * R * K.transpose()).eval();
    }
  }
  void add(const Features& scan) {
    for (const Feature& feature : scan) {
      if (row_of_.count(*feature.landmark_id) != 0) continue;
      const LandmarkFromRangeBearing seen = landmark_from_range_bearing(vehicle(), feature.range_bearing);
      row_of_[*feature.landmark_id] = append(2);
      mean_.tail<2>() = seen.submap_p_landmark;
      couple(seen.J_vehicle, seen.J_measurement * feature.covariance * seen.J_measurement.transpose());
    }
  }
  void clone() {
    clones_.push_back(append(3));
    mean_.tail<3>() = mean_.head<3>();
    couple(Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Zero());
  }

  [[nodiscard]] Se2 vehicle() const { return Se2::from_vector(mean_.head<3>()); }
  [[nodiscard]] Eigen::Matrix3d vehicle_covariance() const { return P_.topLeftCorner<3, 3>(); }
  [[nodiscard]] Eigen::Vector2d landmark(std::int64_t id) const { return mean_.segment<2>(row_of_.at(id)); }
  [[nodiscard]] Eigen::Matrix2d landmark_covariance(std::int64_t id) const { return P_.block<2, 2>(row_of_.at(id), row_of_.at(id)); }
  /// Clones in their order, then the vehicle.
  [[nodiscard]] std::vector<Eigen::Index> pose_rows() const {
    std::vector<Eigen::Index> rows;
    for (const Eigen::Index clone : clones_) rows.insert(rows.end(), {clone, clone + 1, clone + 2});
    rows.insert(rows.end(), {0, 1, 2});
    return rows;
  }
  [[nodiscard]] const Eigen::VectorXd& mean() const { return mean_; }
  [[nodiscard]] const Eigen::MatrixXd& covariance() const { return P_; }

 private:
  Eigen::Index append(Eigen::Index count) {
    const Eigen::Index n = mean_.size();
    mean_.conservativeResize(n + count);
    P_.conservativeResize(n + count, n + count);
    return n;
  }
  /// The last rows are J times the vehicle, plus noise.
  void couple(const Eigen::MatrixXd& J, const Eigen::MatrixXd& noise) {
    const Eigen::Index n = P_.rows() - J.rows();
    P_.bottomLeftCorner(J.rows(), n) = J * P_.topLeftCorner(3, n);
    P_.topRightCorner(n, J.rows()) = P_.bottomLeftCorner(J.rows(), n).transpose();
    P_.bottomRightCorner(J.rows(), J.rows()) = J * P_.topLeftCorner<3, 3>() * J.transpose() + noise;
  }

  Eigen::VectorXd mean_ = Eigen::VectorXd::Zero(3);
  Eigen::MatrixXd P_ = Eigen::MatrixXd::Zero(3, 3);
  std::map<std::int64_t, Eigen::Index> row_of_;
  std::vector<Eigen::Index> clones_;
};

/// Two laps of a circle of 20 landmarks: the second lap recalls every one of them.
struct TwoLaps {
  SimulatedMission mission;
  SlamConfig config;

  TwoLaps() {
    World world;
    constexpr int kLandmarks = 20;
    world.landmarks_m.resize(2, kLandmarks);
    for (int i = 0; i < kLandmarks; ++i) {
      const double angle = 2.0 * kPi * i / kLandmarks;
      const double radius_m = i % 2 == 0 ? 25.0 : 15.0;
      world.landmarks_m.col(i) << radius_m * std::cos(angle), radius_m * std::sin(angle);
      world.ids.push_back(i);
    }
    for (int i = 0; i <= 25; ++i) world.waypoints.emplace_back(20.0 * std::cos(0.5 * i), 20.0 * std::sin(0.5 * i));
    VehicleSimulationConfig simulation = grid_survey_stress_config();
    simulation.max_range_m = 9.0;
    mission = simulate(world, simulation, 5);
    config = testing::matching_config(simulation);
    config.submap.split.max_landmarks = 5;
  }
};

TEST(ConditionallyIndependent, I1_I7_EqualsOneFilterWithClonesThroughALoop) {
  const TwoLaps laps;
  ConditionallyIndependentMapper mapper({}, laps.config.submap, laps.config.association, 1);
  ClonedFilter oracle;
  oracle.clone();  // base 0
  std::optional<AckermanControl> held;
  double time_s = 0.0;
  int loops = 0;
  double online_difference = 0.0;
  drive(mapper, laps.mission, laps.config.vehicle.ackerman, 1e9, [&](const Event& event, const std::optional<MapperReport>& report) {
    if (held && event.time_s > time_s) {
      oracle.predict(predict_ackerman(oracle.vehicle(), *held, event.time_s - time_s, laps.config.vehicle.ackerman));
    }
    time_s = event.time_s;
    if (const auto* control = std::get_if<AckermanControl>(&event.record)) held = *control;
    if (report) {
      oracle.update(std::get<Features>(event.record));
      if (report->join) oracle.clone();
      oracle.add(std::get<Features>(event.record));
      if (report->join) loops += static_cast<int>(report->join->loops.size());
    }
    online_difference = std::max(online_difference, additive_difference(mapper.global_T_vehicle().mean, oracle.vehicle()).norm());
    online_difference =
        std::max(online_difference, (mapper.global_T_vehicle().covariance - oracle.vehicle_covariance()).cwiseAbs().maxCoeff());
  });
  EXPECT_LE(online_difference, kSame);
  EXPECT_GE(mapper.submap(), 10);
  EXPECT_GE(loops, 5);

  const auto check = [&](const WorldEstimate& world) {
    ASSERT_EQ(world.landmarks.size(), 20U);
    for (const LandmarkEstimate& landmark : world.landmarks) {
      const std::int64_t id = *landmark.landmark.source_id;
      EXPECT_LE((landmark.position.mean - oracle.landmark(id)).norm(), kSame) << id;
      EXPECT_LE((landmark.position.covariance - oracle.landmark_covariance(id)).cwiseAbs().maxCoeff(), kSame) << id;
    }
    const std::vector<Eigen::Index> rows = oracle.pose_rows();
    ASSERT_EQ(3 * world.global_T_base.size(), rows.size());
    const Eigen::MatrixXd P = oracle.covariance()(rows, rows);
    for (std::size_t k = 0; k < world.global_T_base.size(); ++k) {
      const Eigen::Vector3d pose = oracle.mean()(rows).segment<3>(static_cast<Eigen::Index>(3 * k));
      EXPECT_LE(additive_difference(world.global_T_base[k], Se2::from_vector(pose)).norm(), kSame) << k;
    }
    EXPECT_LE((world.base_covariance - P).cwiseAbs().maxCoeff(), kSame);  // every pair of borders
    for (std::size_t k = 0; k < world.border_covariance.size(); ++k) {
      const auto at = static_cast<Eigen::Index>(3 * k);
      EXPECT_LE((world.border_covariance[k] - P.block<6, 6>(at, at)).cwiseAbs().maxCoeff(), kSame) << k;
    }
  };
  check(mapper.world(BaseCovariance::kJoint));  // on demand
  EXPECT_TRUE(mapper.finish().loops.empty());
  check(mapper.world(BaseCovariance::kJoint));
  EXPECT_EQ(mapper.world(BaseCovariance::kBorders).base_covariance.size(), 0);
}

/// The answers of two methods to the same events.
struct Answer {
  WorldEstimate world;
  GaussianSe2 vehicle;
  std::vector<GaussianSe2> online;
  std::vector<Submap> submaps;
  std::vector<TrajectoryPoint> trajectory;

  Answer(const ShortSurvey& survey, Method method) {
    SlamConfig config = survey.config;
    config.method = method;
    SlamPipeline pipeline(config, 1);
    for (const Event& event : survey.mission.events) online.push_back(pipeline.feed(event).global_T_vehicle);
    vehicle = pipeline.global_T_vehicle();
    pipeline.finish();
    world = pipeline.world();
    submaps = pipeline.submaps();
    trajectory = pipeline.trajectory();
  }
};

TEST(ConditionallyIndependent, EqualsTheEkfOverASurveyWithLoops) {
  ShortSurvey survey(200.0);
  for (const AssociationMethod association : {AssociationMethod::kKnown, AssociationMethod::kJointCompatibility}) {
    survey.config.association.method = association;
    const Answer cis(survey, Method::kConditionallyIndependent);
    const Answer ekf(survey, Method::kEkf);
    const AnswerDifference difference(cis.world, ekf.world);
    EXPECT_LE(difference.mean_m, kSame);
    EXPECT_LE(difference.covariance, kSame);
    EXPECT_EQ(difference.sightings, 0);
    EXPECT_LE(additive_difference(cis.vehicle.mean, ekf.vehicle.mean).norm(), kSame);
    EXPECT_LE((cis.vehicle.covariance - ekf.vehicle.covariance).cwiseAbs().maxCoeff(), kSame);
    ASSERT_EQ(cis.trajectory.size(), cis.online.size());
    for (std::size_t i = 0; i < cis.trajectory.size(); ++i) {  // past poses as filtered
      ASSERT_EQ(cis.trajectory[i].global_T_vehicle.mean.vector(), cis.online[i].mean.vector());
      ASSERT_EQ(cis.trajectory[i].global_T_vehicle.covariance, cis.online[i].covariance);
    }
  }
}

TEST(ConditionallyIndependent, ListsItsMapsOneAfterTheOther) {
  const ShortSurvey survey(60.0);
  const Answer cis(survey, Method::kConditionallyIndependent);
  ASSERT_GE(cis.submaps.size(), 5U);
  ASSERT_EQ(cis.world.global_T_base.size(), cis.submaps.size() + 1);
  ASSERT_EQ(cis.world.maps.size(), cis.submaps.size());
  std::size_t held = 0;
  for (std::size_t k = 0; k < cis.submaps.size(); ++k) {
    const Submap& submap = cis.submaps[k];
    EXPECT_EQ(submap.index, static_cast<int>(k));
    EXPECT_EQ(submap.start_time_s, k == 0 ? survey.mission.events.front().time_s : cis.submaps[k - 1].end_time_s);
    EXPECT_EQ(submap.state.landmarks(), static_cast<Eigen::Index>(submap.landmarks.size()));
    EXPECT_EQ(cis.world.maps[k].members, std::vector<int>{static_cast<int>(k)});
    held += static_cast<std::size_t>(cis.world.maps[k].landmarks);
    // the link as the submap knew it: the borders have moved since, but not far
    const Se2 link = cis.world.global_T_base[k].inverse() * cis.world.global_T_base[k + 1];
    EXPECT_LE(additive_difference(link, submap.state.vehicle().mean).norm(), 0.5);
  }
  EXPECT_EQ(cis.submaps.back().closed_because, "end of the mission");
  EXPECT_EQ(held, cis.world.landmarks.size());
}

TEST(ConditionallyIndependent, ALocalStepDependsOnThePresentMapOnly) {
  // However long the mission, the filter holds the landmarks of one map.
  const ShortSurvey survey(600.0);
  SlamConfig config = survey.config;
  config.method = Method::kConditionallyIndependent;
  SlamPipeline pipeline(config, 1);
  for (const Event& event : survey.mission.events) pipeline.feed(event);
  pipeline.finish();
  std::size_t largest = 0;
  for (const Submap& submap : pipeline.submaps()) largest = std::max(largest, submap.landmarks.size());
  EXPECT_LE(largest, 30U);
  EXPECT_EQ(pipeline.world().landmarks.size(), 441U);
}

}  // namespace
}  // namespace ssjs
