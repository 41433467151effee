// What Estimator::feed() takes from the heap over a whole survey, the background at work beside it.
#include <gtest/gtest.h>

#include <algorithm>

#include "allocation/counted_heap.hpp"
#include "ssjs/embed/online.hpp"
#include "ssjs/simulation/auv_survey.hpp"

namespace ssjs {
namespace {

TEST(Estimator, APlainStepTakesNothingFromTheHeap) {
#ifndef SSJS_COUNTS_ALLOCATIONS
  GTEST_SKIP() << "the heap cannot be watched here (a sanitizer owns it, or the C library is not glibc)";
#endif
  SurveyWorldConfig world;
  world.landmarks = 150;
  AuvSimulationConfig simulation;
  simulation.velocity_gap_s = 0.0;
  const SimulatedSurvey survey = simulate_survey(survey_world(world, 7), simulation, 7);
  const online::Setting settings[] = {{"split.max_distance_m", "60"}};
  online::Estimator estimator(settings, 1);
  long plain = 0, taken = 0, others = 0, sighted = 0, asked = 0;
  online::Status before = estimator.status();
  const auto feed = [&](const auto& sample) {
    const long at_first = testing::allocations;
    ASSERT_EQ(estimator.feed(sample), online::Arrival::kTaken);
    const long by_this = testing::allocations - at_first;
    const online::Status now = estimator.status();
    online::Pose pose;
    static_cast<void>(estimator.pose(&pose));
    asked += testing::allocations - at_first - by_this;
    const bool closed_or_taken_over = now.submaps != before.submaps || now.loop_closures != before.loop_closures;
    const bool is_plain = now.submaps > 6 && !closed_or_taken_over && now.landmarks == before.landmarks;
    before = now;
    if (!is_plain) {
      others += by_this;
      return;
    }
    ++plain;
    taken += by_this;
    EXPECT_EQ(by_this, 0) << "at " << sample.time_s << " s";
  };
  for (const NavigationTick& tick : survey.ticks) {
    const double t = tick.time_s;
    if (tick.gyro_rad_s) feed(online::Gyro{t, {tick.gyro_rad_s->x(), tick.gyro_rad_s->y(), tick.gyro_rad_s->z()}});
    if (tick.roll_pitch_rad) feed(online::Attitude{t, tick.roll_pitch_rad->x(), tick.roll_pitch_rad->y()});
    if (tick.compass_rad) feed(online::Compass{t, *tick.compass_rad});
    if (tick.depth_m) feed(online::Depth{t, *tick.depth_m});
    if (tick.altitude_m) feed(online::Altitude{t, *tick.altitude_m});
    if (tick.velocity) {
      const Eigen::Vector3d& v = tick.velocity->velocity_m_s;
      feed(online::Velocity{t, {v.x(), v.y(), v.z()}, tick.velocity->bottom_lock});
    }
    if (tick.sightings.size() == 1) {  // several of one ping are searched jointly, which may allocate
      const SideScanSighting& sighting = tick.sightings.front();
      const Eigen::Vector3d& p = sighting.vehicle_p_point;
      online::Sighting sample{t, {p.x(), p.y(), p.z()}, true, {}, -1};
      std::copy_n(sighting.covariance->data(), 9, sample.covariance_m2);
      feed(sample);
      ++sighted;
    }
  }
  EXPECT_GT(estimator.status().submaps, 15);
  EXPECT_GT(sighted, 100);
  EXPECT_GT(plain, 15000);
  EXPECT_GT(others, 0);  // the counter counts
  EXPECT_EQ(taken, 0);
  EXPECT_EQ(asked, 0);  // by pose() and status()
}

}  // namespace
}  // namespace ssjs
