#include "ssjs/io/event_log.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Eigen::VectorXd column(std::initializer_list<double> values) {
  Eigen::VectorXd v(static_cast<Eigen::Index>(values.size()));
  std::copy(values.begin(), values.end(), v.data());
  return v;
}

/// Row-major upper triangles of rows x triangle numbers, row i being 100 i + 1, 100 i + 2, ...
Eigen::MatrixXd numbered(Eigen::Index rows, Eigen::Index columns) {
  Eigen::MatrixXd m(rows, columns);
  for (Eigen::Index r = 0; r < rows; ++r) {
    for (Eigen::Index c = 0; c < columns; ++c) m(r, c) = static_cast<double>(100 * r + c + 1);
  }
  return m;
}

template <class Call>
void expect_refused(Call call, const std::string& message) {
  EventLog log;
  try {
    call(log);
    ADD_FAILURE() << "accepted; should say: " << message;
  } catch (const InvalidArgument& error) {
    EXPECT_EQ(std::string(error.what()), message);
  }
  EXPECT_TRUE(log.events().empty());  // nothing half read
}

TEST(EventLog, MergesItsSensorsByTime) {
  EventLog log;
  log.add_features(column({0.1, 0.1, 0.3}), column({1.0, 2.0, 3.0}), column({0.0, 0.0, 0.0}), numbered(3, 3), std::nullopt);
  log.add_ackerman(column({0.0, 0.1, 0.2}), column({1.0, 2.0, 3.0}), column({0.01, 0.02, 0.03}));
  log.add_scans(column({0.1, 0.25}), Eigen::MatrixXd::Constant(2, 4, 7.0), -1.0, 0.5);
  const std::vector<Event>& events = log.events();
  ASSERT_EQ(events.size(), 7U);
  const std::vector<double> times{0.0, 0.1, 0.1, 0.1, 0.2, 0.25, 0.3};
  const std::vector<std::size_t> kinds{0, 0, 3, 4, 0, 4, 3};  // odometry before observations; features were added before scans
  for (std::size_t i = 0; i < events.size(); ++i) {
    EXPECT_EQ(events[i].time_s, times[i]) << i;
    EXPECT_EQ(events[i].record.index(), kinds[i]) << i;
  }
  EXPECT_EQ(std::get<AckermanControl>(events[4].record).speed_m_s, 3.0);
  EXPECT_EQ(std::get<AckermanControl>(events[4].record).steering_rad, 0.03);
  EXPECT_EQ(std::get<Features>(events[2].record).size(), 2U);
  EXPECT_EQ(std::get<LaserScan>(events[5].record).range_m.size(), 4);
  EXPECT_EQ(std::get<LaserScan>(events[5].record).first_angle_rad, -1.0);
  EXPECT_EQ(std::get<LaserScan>(events[5].record).step_rad, 0.5);
}

TEST(EventLog, MergesWhatIsAddedAfterALook) {
  EventLog log;
  log.add_velocity(column({1.0, 3.0}), column({1.0, 1.0}), column({0.0, 0.0}));
  EXPECT_EQ(log.events().size(), 2U);
  log.add({2.0, Features{}});
  ASSERT_EQ(log.events().size(), 3U);
  EXPECT_EQ(log.events()[1].time_s, 2.0);
}

TEST(EventLog, EqualTimesKeepTheOrderInWhichTheyWereAdded) {
  EventLog log;
  log.add_velocity(column({1.0, 1.0}), column({5.0, 6.0}), column({0.0, 0.0}));
  log.add_velocity(column({1.0}), column({7.0}), column({0.0}));
  const std::vector<Event>& events = log.events();
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(std::get<VelocityControl>(events[i].record).speed_m_s, 5.0 + static_cast<double>(i));
}

TEST(EventLog, RowsOfEqualTimeAreOneScan) {
  EventLog log;
  log.add_features(column({1.0, 1.0, 2.0, 2.0, 2.0}), column({1.0, 2.0, 3.0, 4.0, 5.0}), column({0.1, 4.0, -0.1, 0.0, 0.0}), numbered(5, 3),
                   std::vector<std::int64_t>{7, -1, 0, 9, -5});
  ASSERT_EQ(log.events().size(), 2U);
  const Features& first = std::get<Features>(log.events()[0].record);
  const Features& second = std::get<Features>(log.events()[1].record);
  ASSERT_EQ(first.size(), 2U);
  ASSERT_EQ(second.size(), 3U);
  EXPECT_EQ(first[1].range(), 2.0);
  EXPECT_NEAR(first[1].bearing(), 4.0 - 2.0 * kPi, 1e-15);  // wrapped
  EXPECT_EQ(first[1].covariance, (Eigen::Matrix2d() << 101.0, 102.0, 102.0, 103.0).finished());
  EXPECT_EQ(first[0].landmark_id, 7);
  EXPECT_EQ(first[1].landmark_id, std::nullopt);  // negative: unknown
  EXPECT_EQ(second[0].landmark_id, 0);
  EXPECT_EQ(second[2].landmark_id, std::nullopt);
}

TEST(EventLog, IncrementsCarryTheirCovariance) {
  EventLog log;
  log.add_increments(column({1.0}), column({0.5}), column({-0.1}), column({3.5}), numbered(1, 6));
  const GaussianSe2& increment = std::get<OdometryIncrement>(log.events()[0].record).old_T_new;
  EXPECT_EQ(increment.mean.x, 0.5);
  EXPECT_EQ(increment.mean.y, -0.1);
  EXPECT_NEAR(increment.mean.heading, 3.5 - 2.0 * kPi, 1e-15);
  EXPECT_EQ(increment.covariance, (Eigen::Matrix3d() << 1.0, 2.0, 3.0, 2.0, 4.0, 5.0, 3.0, 5.0, 6.0).finished());
}

TEST(EventLog, BeamsWithoutReturnMayBeAnything) {
  EventLog log;
  Eigen::MatrixXd ranges(1, 3);
  ranges << kNaN, kInfinity, 4.0;
  log.add_scans(column({1.0}), ranges, 0.0, -0.1);
  EXPECT_EQ(std::get<LaserScan>(log.events()[0].record).range_m(2), 4.0);
}

TEST(EventLog, SonarHitsOfEqualTimeAreOneImage) {
  EventLog log;
  log.add_sonar_hits(column({1.0, 1.0, 2.0}), column({5.0, 6.0, 7.0}), column({0.1, 0.2, 0.3}));
  ASSERT_EQ(log.events().size(), 2U);
  const SonarHits& first = std::get<SonarHits>(log.events()[0].record);
  ASSERT_EQ(first.range_bearing.size(), 2U);
  EXPECT_EQ(first.range_bearing[1], Eigen::Vector2d(6.0, 0.2));
  EXPECT_THROW(log.add_sonar_hits(column({1.0}), column({5.0, 6.0}), column({0.1})), InvalidArgument);
  EXPECT_THROW(log.add_sonar_hits(column({2.0, 1.0}), column({5.0, 6.0}), column({0.1, 0.2})), InvalidArgument);
  EXPECT_THROW(log.add_sonar_hits(column({1.0}), column({kNaN}), column({0.1})), InvalidArgument);
}

TEST(EventLog, EmptyColumnsAddNothing) {
  EventLog log;
  log.add_ackerman(column({}), column({}), column({}));
  log.add_features(column({}), column({}), column({}), Eigen::MatrixXd(0, 3), std::nullopt);
  EXPECT_TRUE(log.events().empty());
}

TEST(EventLog, ShapesThatDoNotFitAreNamed) {
  const Eigen::VectorXd two = column({1.0, 2.0});
  const Eigen::VectorXd three = column({1.0, 2.0, 3.0});
  expect_refused([&](EventLog& log) { log.add_ackerman(two, three, two); }, "speed_m_s = 3 rows: must have as many rows as time_s, 2");
  expect_refused([&](EventLog& log) { log.add_ackerman(two, two, three); }, "steering_rad = 3 rows: must have as many rows as time_s, 2");
  expect_refused([&](EventLog& log) { log.add_velocity(two, three, two); }, "speed_m_s = 3 rows: must have as many rows as time_s, 2");
  expect_refused([&](EventLog& log) { log.add_velocity(two, two, three); },
                 "turn_rate_rad_s = 3 rows: must have as many rows as time_s, 2");
  const Eigen::MatrixXd P = numbered(2, 6);
  expect_refused([&](EventLog& log) { log.add_increments(two, three, two, two, P); }, "dx_m = 3 rows: must have as many rows as time_s, 2");
  expect_refused([&](EventLog& log) { log.add_increments(two, two, three, two, P); }, "dy_m = 3 rows: must have as many rows as time_s, 2");
  expect_refused([&](EventLog& log) { log.add_increments(two, two, two, three, P); },
                 "dheading_rad = 3 rows: must have as many rows as time_s, 2");
  expect_refused([&](EventLog& log) { log.add_increments(two, two, two, two, numbered(3, 6)); },
                 "odometry covariance = 3 rows: must have as many rows as time_s, 2");
  expect_refused([&](EventLog& log) { log.add_increments(two, two, two, two, numbered(2, 9)); },
                 "odometry covariance = 9 columns: must have 6");
  const Eigen::MatrixXd R = numbered(2, 3);
  expect_refused([&](EventLog& log) { log.add_features(two, three, two, R, std::nullopt); },
                 "range_m = 3 rows: must have as many rows as time_s, 2");
  expect_refused([&](EventLog& log) { log.add_features(two, two, three, R, std::nullopt); },
                 "bearing_rad = 3 rows: must have as many rows as time_s, 2");
  expect_refused([&](EventLog& log) { log.add_features(two, two, two, numbered(1, 3), std::nullopt); },
                 "observation covariance = 1 rows: must have as many rows as time_s, 2");
  expect_refused([&](EventLog& log) { log.add_features(two, two, two, numbered(2, 4), std::nullopt); },
                 "observation covariance = 4 columns: must have 3");
  expect_refused([&](EventLog& log) { log.add_features(two, two, two, R, std::vector<std::int64_t>{1}); },
                 "landmark_id = 1 rows: must have as many rows as time_s, 2");
  expect_refused([&](EventLog& log) { log.add_scans(two, numbered(3, 5), 0.0, 0.1); },
                 "range_m = 3 rows: must have as many rows as time_s, 2");
}

TEST(EventLog, TimesThatGoBackOrAreNotFiniteAreNamedWithTheirRow) {
  const Eigen::VectorXd good = column({0.0, 0.0, 0.0});
  const Eigen::VectorXd back = column({1.0, 3.0, 2.5});
  const Eigen::VectorXd broken = column({1.0, kNaN, 2.5});
  const std::string goes_back = " time_s, row 3 = 2.5: goes back: times must not decrease";
  const std::string not_finite = " time_s, row 2 = nan: must be finite";
  expect_refused([&](EventLog& log) { log.add_ackerman(back, good, good); }, "odometry" + goes_back);
  expect_refused([&](EventLog& log) { log.add_ackerman(broken, good, good); }, "odometry" + not_finite);
  expect_refused([&](EventLog& log) { log.add_velocity(back, good, good); }, "odometry" + goes_back);
  expect_refused([&](EventLog& log) { log.add_increments(back, good, good, good, numbered(3, 6)); }, "odometry" + goes_back);
  expect_refused([&](EventLog& log) { log.add_features(back, good, good, numbered(3, 3), std::nullopt); }, "observations" + goes_back);
  expect_refused([&](EventLog& log) { log.add_features(broken, good, good, numbered(3, 3), std::nullopt); }, "observations" + not_finite);
  expect_refused([&](EventLog& log) { log.add_scans(back, numbered(3, 4), 0.0, 0.1); }, "scans" + goes_back);
}

TEST(EventLog, ValuesThatAreNotFiniteAreNamedWithTheirRow) {
  const Eigen::VectorXd time = column({1.0, 2.0});
  const Eigen::VectorXd good = column({0.5, 0.5});
  const Eigen::VectorXd bad = column({0.5, kInfinity});
  const std::string mend = ", row 2 = not finite: remove the row or mend the log";
  expect_refused([&](EventLog& log) { log.add_ackerman(time, bad, good); }, "odometry speed_m_s" + mend);
  expect_refused([&](EventLog& log) { log.add_ackerman(time, good, bad); }, "odometry steering_rad" + mend);
  expect_refused([&](EventLog& log) { log.add_velocity(time, bad, good); }, "odometry speed_m_s" + mend);
  expect_refused([&](EventLog& log) { log.add_velocity(time, good, bad); }, "odometry turn_rate_rad_s" + mend);
  Eigen::MatrixXd P = numbered(2, 6);
  expect_refused([&](EventLog& log) { log.add_increments(time, bad, good, good, P); }, "odometry dx_m" + mend);
  expect_refused([&](EventLog& log) { log.add_increments(time, good, bad, good, P); }, "odometry dy_m" + mend);
  expect_refused([&](EventLog& log) { log.add_increments(time, good, good, bad, P); }, "odometry dheading_rad" + mend);
  P(1, 4) = kNaN;
  expect_refused([&](EventLog& log) { log.add_increments(time, good, good, good, P); }, "odometry covariance" + mend);
  Eigen::MatrixXd R = numbered(2, 3);
  expect_refused([&](EventLog& log) { log.add_features(time, bad, good, R, std::nullopt); }, "observations range_m" + mend);
  expect_refused([&](EventLog& log) { log.add_features(time, good, bad, R, std::nullopt); }, "observations bearing_rad" + mend);
  R(1, 0) = kNaN;
  expect_refused([&](EventLog& log) { log.add_features(time, good, good, R, std::nullopt); }, "observations covariance" + mend);
}

TEST(EventLog, ScanAnglesAreChecked) {
  const Eigen::VectorXd time = column({1.0});
  expect_refused([&](EventLog& log) { log.add_scans(time, numbered(1, 4), kNaN, 0.1); }, "first_angle_rad = nan: must be finite");
  expect_refused([&](EventLog& log) { log.add_scans(time, numbered(1, 4), 0.0, 0.0); }, "step_rad = 0: must be finite and not zero");
  expect_refused([&](EventLog& log) { log.add_scans(time, numbered(1, 4), 0.0, kInfinity); },
                 "step_rad = inf: must be finite and not zero");
}

}  // namespace
}  // namespace ssjs
