#include "ssjs/pipeline/event_check.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

VehicleConfig vehicle(VehicleKind kind) {
  VehicleConfig config;
  config.kind = kind;
  return config;
}

template <class Expected>
void expect_refused(const Event& event, VehicleKind kind, const std::string& message) {
  try {
    check_event(event, 10.0, vehicle(kind));
    ADD_FAILURE() << "accepted; should say: " << message;
  } catch (const Expected& error) {
    EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
  }
}

Feature good_feature() { return {Eigen::Vector2d(5.0, 0.1), Eigen::Vector2d(0.01, 0.0003).asDiagonal(), 3}; }

TEST(EventCheck, GoodEventsPass) {
  EXPECT_NO_THROW(check_event({10.0, AckermanControl{1.0, 0.1}}, 10.0, vehicle(VehicleKind::kAckerman)));
  EXPECT_NO_THROW(check_event({-5.0, AckermanControl{-1.0, -0.1}}, std::nullopt, vehicle(VehicleKind::kAckerman)));
  EXPECT_NO_THROW(check_event({11.0, VelocityControl{1.0, 0.1}}, 10.0, vehicle(VehicleKind::kUnicycle)));
  EXPECT_NO_THROW(check_event({11.0, OdometryIncrement{}}, 10.0, vehicle(VehicleKind::kIncrements)));  // certain: no noise at all
  EXPECT_NO_THROW(check_event({11.0, Features{good_feature()}}, 10.0, vehicle(VehicleKind::kIncrements)));
  EXPECT_NO_THROW(check_event({11.0, Features{}}, 10.0, vehicle(VehicleKind::kAckerman)));
}

TEST(EventCheck, TimesAreNamed) {
  expect_refused<InvalidArgument>({9.999, Features{}}, VehicleKind::kAckerman, "time_s = 9.999: goes back behind 10 s");
  expect_refused<InvalidArgument>({kNaN, Features{}}, VehicleKind::kAckerman, "time = not finite at time 10 s");
}

TEST(EventCheck, OdometryMustBeOfTheConfiguredKind) {
  for (const VehicleKind kind : {VehicleKind::kAckerman, VehicleKind::kUnicycle, VehicleKind::kIncrements}) {
    for (const Event& event : {Event{11.0, AckermanControl{}}, Event{11.0, VelocityControl{}}, Event{11.0, OdometryIncrement{}}}) {
      if (event.record.index() == static_cast<std::size_t>(kind)) continue;
      expect_refused<InvalidArgument>(event, kind, "odometry = of another kind: must match vehicle.kind of the configuration");
    }
  }
}

TEST(EventCheck, ValuesThatAreNotFinite) {
  const std::string mend = "not finite at time 11 s: remove the record or mend the log";
  expect_refused<InvalidArgument>({11.0, AckermanControl{kNaN, 0.0}}, VehicleKind::kAckerman, "odometry = " + mend);
  expect_refused<InvalidArgument>({11.0, AckermanControl{0.0, kNaN}}, VehicleKind::kAckerman, "odometry = " + mend);
  expect_refused<InvalidArgument>({11.0, VelocityControl{0.0, kNaN}}, VehicleKind::kUnicycle, "odometry = " + mend);
  OdometryIncrement increment;
  increment.old_T_new.covariance(0, 1) = kNaN;
  expect_refused<InvalidArgument>({11.0, increment}, VehicleKind::kIncrements, "odometry increment = " + mend);
  Feature feature = good_feature();
  feature.covariance(1, 0) = std::numeric_limits<double>::infinity();
  expect_refused<InvalidArgument>({11.0, Features{good_feature(), feature}}, VehicleKind::kAckerman, "observation = " + mend);
}

TEST(EventCheck, SteeringThatTheModelCannotDrive) {
  expect_refused<InvalidArgument>({11.0, AckermanControl{1.0, 1.6}}, VehicleKind::kAckerman, "AckermanControl.steering_rad = 1.6");
  expect_refused<InvalidArgument>({11.0, AckermanControl{1.0, 1.5}}, VehicleKind::kAckerman, "tan(steering) H / L < 1");  // 14.1 * 0.27
}

TEST(EventCheck, NumbersThatAreNoCovariance) {
  Feature feature = good_feature();
  feature.covariance << 1.0, 1.1, 1.1, 1.0;
  expect_refused<NotPositiveDefinite>({11.0, Features{feature}}, VehicleKind::kAckerman,
                                      "observation covariance is not positive definite (an observation at time 11 s)");
  feature.covariance << -1.0, 0.0, 0.0, -1.0;
  expect_refused<NotPositiveDefinite>({11.0, Features{feature}}, VehicleKind::kAckerman, "observation covariance");
  feature = good_feature();
  feature.range_bearing.x() = 0.0;
  expect_refused<InvalidArgument>({11.0, Features{feature}}, VehicleKind::kAckerman, "observation range = 0: must be positive");
  OdometryIncrement increment;
  increment.old_T_new.covariance = Eigen::Vector3d(0.1, 0.1, -0.01).asDiagonal();
  expect_refused<NotPositiveDefinite>({11.0, increment}, VehicleKind::kIncrements,
                                      "odometry covariance is not positive definite (an increment at time 11 s)");
}

}  // namespace
}  // namespace ssjs
