#include "ssjs/embed/online.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "embed/samples.hpp"
#include "ssjs/pipeline/levelled_run.hpp"

namespace ssjs {
namespace {

using testing::Arriving;
using testing::feed;
using testing::samples_of;
using testing::survey;

std::vector<online::Pose> trajectory_of(online::Estimator& estimator) {
  std::vector<online::Pose> poses(estimator.trajectory(nullptr, 0));
  EXPECT_EQ(estimator.trajectory(poses.data(), poses.size()), poses.size());
  return poses;
}

constexpr online::Setting kKnown[] = {{"association.method", "known"}};

std::vector<online::Pose> run(const std::vector<Arriving>& samples, std::vector<online::Pose>* live = nullptr) {
  online::Estimator estimator(kKnown, 1);
  for (const Arriving& arriving : samples) {
    EXPECT_EQ(feed(estimator, arriving.sample), online::Arrival::kTaken) << arriving.at_s;
    online::Pose pose;
    if (live != nullptr && estimator.pose(&pose)) live->push_back(pose);
  }
  EXPECT_TRUE(estimator.finish()) << estimator.last_error();
  return trajectory_of(estimator);
}

bool same_bytes(const std::vector<online::Pose>& a, const std::vector<online::Pose>& b) {
  const auto equal = [](const online::Pose& p, const online::Pose& q) {
    return p.time_s == q.time_s && p.x_m == q.x_m && p.y_m == q.y_m && p.z_m == q.z_m && p.roll_rad == q.roll_rad &&
           p.pitch_rad == q.pitch_rad && p.yaw_rad == q.yaw_rad && std::equal(p.covariance, p.covariance + 36, q.covariance);
  };
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), equal);
}

TEST(Estimator, EndsWithTheTrajectoryOfTheWholeMissionAtOnce) {
  const SimulatedSurvey simulated = survey(3);
  const std::vector<online::Pose> way = run(samples_of(simulated.ticks));
  LevelledConfig config;
  config.local.association.method = AssociationMethod::kKnown;
  const LevelledResult whole = run_levelled_mission(config, simulated.ticks);
  ASSERT_EQ(static_cast<Eigen::Index>(way.size()), whole.pose.rows());
  for (std::size_t i = 0; i < way.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    EXPECT_EQ(way[i].time_s, whole.time_s(row));
    EXPECT_NEAR(way[i].x_m, whole.pose(row, 0), 1e-8);  // sightings of one time come in an order of their own
    EXPECT_NEAR(way[i].y_m, whole.pose(row, 1), 1e-8);
    EXPECT_NEAR(way[i].yaw_rad, whole.pose(row, 5), 1e-9);
    EXPECT_NEAR(way[i].covariance[0], whole.covariance(row, 0), 1e-9);
  }
}

/// Where the vehicle truly was at one moment, seen from another.
online::LoopClosure true_closure(const SimulatedSurvey& simulated, std::size_t from, std::size_t to) {
  const auto pose = [&](std::size_t tick) {
    const Vector6d x = simulated.truth[tick].world_T_vehicle.vector();
    return Se2{x(0), x(1), x(5)};
  };
  const Se2 from_T_to = pose(from).inverse() * pose(to);
  return {simulated.ticks[from].time_s,        simulated.ticks[to].time_s, from_T_to.x, from_T_to.y, from_T_to.heading,
          {0.01, 0, 0, 0, 0.01, 0, 0, 0, 1e-4}};
}

TEST(Estimator, LoopClosuresFromElsewhereTakePart) {
  const SimulatedSurvey simulated = survey(3);
  std::vector<Arriving> samples = samples_of(simulated.ticks);
  const auto is_sighting = [](const Arriving& arriving) { return std::holds_alternative<online::Sighting>(arriving.sample); };
  samples.erase(std::remove_if(samples.begin(), samples.end(), is_sighting), samples.end());  // nothing else ties the submaps
  online::Estimator estimator;
  std::string notes;
  const auto keep = [](void* text, online::Note note, double, const char* said) {
    if (note == online::Note::kClosure) *static_cast<std::string*>(text) += std::string(said) + "\n";
  };
  estimator.set_log(keep, &notes);
  const std::size_t last = simulated.ticks.size() - 1;
  for (const Arriving& arriving : samples) ASSERT_EQ(feed(estimator, arriving.sample), online::Arrival::kTaken);
  for (std::size_t i = 1; i <= 4; ++i) {
    EXPECT_EQ(estimator.feed(true_closure(simulated, i * last / 20, last - i * last / 20)), online::Arrival::kTaken);
  }
  online::LoopClosure wrong = true_closure(simulated, last / 10, last - last / 8);
  wrong.x_m += 25.0;
  EXPECT_EQ(estimator.feed(wrong), online::Arrival::kTaken);
  online::LoopClosure nowhere = true_closure(simulated, last / 4, last / 2);
  nowhere.from_time_s = -1e5;
  EXPECT_EQ(estimator.feed(nowhere), online::Arrival::kTaken);
  online::LoopClosure none = true_closure(simulated, last / 4, last / 2);
  none.covariance[0] = -1.0;
  EXPECT_EQ(estimator.feed(none), online::Arrival::kNotFinite);
  none = true_closure(simulated, last / 2, last / 4);
  EXPECT_EQ(estimator.feed(none), online::Arrival::kNotFinite);  // backwards

  std::string state(estimator.checkpoint(nullptr, 0), '\0');
  ASSERT_EQ(estimator.checkpoint(state.data(), state.size()), state.size());
  ASSERT_TRUE(estimator.finish()) << estimator.last_error();
  const online::Status status = estimator.status();
  EXPECT_EQ(status.loop_closures, 4);
  EXPECT_EQ(status.closures_refused, 2);
  EXPECT_EQ(status.arrivals[static_cast<int>(online::Arrival::kNotFinite)], 2);
  EXPECT_NE(notes.find("no two submaps lie at -100000"), std::string::npos) << notes;
  const std::vector<online::Pose> way = trajectory_of(estimator);
  const Eigen::Vector3d& end = simulated.truth[last].world_T_vehicle.translation;
  EXPECT_LT(std::hypot(way.back().x_m - end(0), way.back().y_m - end(1)),
            3.0 * std::sqrt(way.back().covariance[0] + way.back().covariance[7]));

  online::Estimator again;  // those that wait are part of the state
  ASSERT_TRUE(again.restore(state.data(), state.size())) << again.last_error();
  ASSERT_TRUE(again.finish());
  EXPECT_TRUE(same_bytes(trajectory_of(again), way));
}

TEST(Estimator, SamplesOutOfOrderWithinTheWindowChangeNothing) {
  const std::vector<Arriving> in_order = samples_of(survey(4).ticks);
  std::vector<Arriving> late = in_order;
  std::mt19937_64 random(1);
  for (Arriving& arriving : late) arriving.at_s += 0.8 * static_cast<double>(random() % 1000) / 1000.0;
  std::stable_sort(late.begin(), late.end(), [](const Arriving& a, const Arriving& b) { return a.at_s < b.at_s; });
  EXPECT_TRUE(same_bytes(run(late), run(in_order)));
}

TEST(Estimator, TheSameSamplesGiveTheSameLivePosesWhateverTheBackgroundDoes) {
  const std::vector<Arriving> samples = samples_of(survey(5).ticks);
  std::vector<online::Pose> first, second;
  run(samples, &first);
  run(samples, &second);
  EXPECT_GT(first.size(), 1000U);
  EXPECT_TRUE(same_bytes(first, second));
}

TEST(Estimator, TheLivePoseIsOfTheNewestSampleAndHonest) {
  const SimulatedSurvey simulated = survey(6);
  std::vector<online::Pose> live;
  run(samples_of(simulated.ticks), &live);
  std::size_t at = 0;
  double squared = 0.0;
  int inside = 0;
  for (const online::Pose& pose : live) {
    while (at + 1 < simulated.truth.size() && simulated.truth[at].time_s < pose.time_s) ++at;
    const Eigen::Vector2d error = simulated.truth[at].world_T_vehicle.translation.head<2>() - Eigen::Vector2d(pose.x_m, pose.y_m);
    EXPECT_EQ(pose.time_s, simulated.truth[at].time_s);
    squared += error.squaredNorm();
    if (std::abs(error.x()) <= 3 * std::sqrt(pose.covariance[0]) && std::abs(error.y()) <= 3 * std::sqrt(pose.covariance[7])) ++inside;
  }
  EXPECT_LT(std::sqrt(squared / static_cast<double>(live.size())), 1.5);
  EXPECT_GT(inside, 0.95 * static_cast<double>(live.size()));
}

TEST(Estimator, BadSamplesAreRefusedCountedAndForgotten) {
  const std::vector<Arriving> samples = samples_of(survey(3).ticks);
  const std::vector<online::Pose> clean = run(samples);
  online::Estimator estimator(kKnown, 1);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  std::size_t i = 0;
  for (const Arriving& arriving : samples) {
    const double t = arriving.at_s;
    EXPECT_EQ(feed(estimator, arriving.sample), online::Arrival::kTaken);
    switch (++i % 500) {
      case 1:
        EXPECT_EQ(estimator.feed(online::Depth{t, kNan}), online::Arrival::kNotFinite);
        break;
      case 2:
        EXPECT_EQ(estimator.feed(online::Depth{kNan, 1.0}), online::Arrival::kNotFinite);
        break;
      case 3:
        EXPECT_EQ(estimator.feed(online::Depth{t - 100.0, 3.0}), online::Arrival::kLate);
        break;
      case 4:
        EXPECT_EQ(estimator.feed(online::Depth{t + 1e6, 3.0}), online::Arrival::kClockJump);
        break;
      case 5:
        EXPECT_EQ(feed(estimator, arriving.sample),
                  std::holds_alternative<online::Sighting>(arriving.sample) ? online::Arrival::kTaken : online::Arrival::kDuplicate);
        break;
      default:
        break;
    }
  }
  EXPECT_TRUE(estimator.finish());
  EXPECT_TRUE(same_bytes(trajectory_of(estimator), clean));
  const online::Status status = estimator.status();
  for (const online::Arrival refused :
       {online::Arrival::kLate, online::Arrival::kDuplicate, online::Arrival::kNotFinite, online::Arrival::kClockJump})
    EXPECT_GT(status.arrivals[static_cast<std::size_t>(refused)], 10) << static_cast<int>(refused);
  EXPECT_EQ(estimator.feed(online::Depth{1e4, 1.0}), online::Arrival::kFailed);  // after the end
  EXPECT_NE(std::string(estimator.last_error()).find("finished"), std::string::npos);
}

TEST(Estimator, SaysHowItIs) {
  const std::vector<Arriving> samples = samples_of(survey(3).ticks);
  online::Estimator estimator;
  online::Pose pose;
  EXPECT_FALSE(estimator.pose(&pose));
  EXPECT_EQ(estimator.status().health, online::Health::kWaiting);
  for (const Arriving& arriving : samples) {
    const double t = arriving.at_s;
    const bool silenced = std::holds_alternative<online::Velocity>(arriving.sample) && t > 60.0 && t < 90.0;
    if (!silenced) {
      EXPECT_EQ(feed(estimator, arriving.sample), online::Arrival::kTaken);
    }
    const auto health = estimator.status().health;
    if ((t > 50.0 && t < 55.0) || (t > 95.0 && t < 99.0)) {
      EXPECT_EQ(health, online::Health::kGood) << t;
    } else if (t > 75.0 && t < 89.0) {
      EXPECT_EQ(health, online::Health::kDegraded) << t;
    }
    if (t > 100.0) break;
  }
  EXPECT_GT(estimator.status().used[static_cast<std::size_t>(online::Sensor::kDepth)], 500);
}

TEST(Estimator, SettingsAreNamedInItsComplaints) {
  const auto complaint = [](const char* key, const char* value) -> std::string {
    const online::Setting setting{key, value};
    try {
      const online::Estimator estimator(&setting, 1);
    } catch (const std::invalid_argument& problem) {
      return problem.what();
    }
    return "";
  };
  EXPECT_EQ(complaint("split.longest_m", "150"), "");
  EXPECT_NE(complaint("split.longets_m", "150").find("nearest is split.longest_m"), std::string::npos);
  EXPECT_NE(complaint("split.longest_m", "-1").find("split.longest_m"), std::string::npos);
  EXPECT_NE(complaint("split.longest_m", "far").find("must be a number"), std::string::npos);
  EXPECT_NE(complaint("compass_use", "often").find("first_reading"), std::string::npos);
  EXPECT_NE(complaint("method", "ekf").find("ssjs"), std::string::npos);
}

/// What the log said, as text.
struct Notes {
  std::vector<std::pair<online::Note, std::string>> all;
  static void take(void* context, online::Note note, double /*time_s*/, const char* text) {
    static_cast<Notes*>(context)->all.emplace_back(note, text);
  }
  [[nodiscard]] bool say(online::Note kind, const std::string& part) const {
    return std::any_of(all.begin(), all.end(),
                       [&](const auto& note) { return note.first == kind && note.second.find(part) != std::string::npos; });
  }
};

TEST(Estimator, ASilentVelocityLogIsReportedWithWhatToDoAndTheLogSaysSo) {
  online::Estimator estimator(kKnown, 1);
  Notes notes;
  estimator.set_log(&Notes::take, &notes);
  constexpr auto kVelocity = static_cast<std::size_t>(online::Sensor::kVelocity);
  for (const Arriving& arriving : samples_of(survey(7).ticks)) {
    const bool silent = arriving.at_s >= 200.0 && arriving.at_s < 240.0;
    if (arriving.at_s > 260.0) break;
    if (silent && std::holds_alternative<online::Velocity>(arriving.sample)) continue;
    feed(estimator, arriving.sample);
    if (!(arriving.at_s > 239.0 && silent)) continue;
    const online::Status status = estimator.status();
    ASSERT_EQ(status.sensors[kVelocity], online::SensorState::kSilent);
    ASSERT_EQ(status.health, online::Health::kDegraded);
    ASSERT_NE(std::string(status.advice).find("velocity over the bottom"), std::string::npos);
  }
  const online::Status status = estimator.status();
  EXPECT_EQ(status.sensors[kVelocity], online::SensorState::kGood);
  EXPECT_EQ(std::string(status.advice), "");
  EXPECT_TRUE(notes.say(online::Note::kSensor, "no velocity over the bottom"));
  EXPECT_TRUE(notes.say(online::Note::kSensor, "velocity log is good again"));
}

TEST(Estimator, AFixFarOffIsRefusedAndAnOperatorIsBelieved) {
  online::Estimator estimator(kKnown, 1);
  Notes notes;
  estimator.set_log(&Notes::take, &notes);
  constexpr auto kFix = static_cast<std::size_t>(online::Sensor::kFix);
  std::vector<online::Fix> fixes = {{0.0, 1000.0, 2000.0, {1.0, 0.0, 0.0, 1.0}, false},    // here the survey lies
                                    {50.0, 1500.0, 2000.0, {1.0, 0.0, 0.0, 1.0}, false},   // half a kilometre off
                                    {100.0, 1000.0, 2500.0, {1.0, 0.0, 0.0, 1.0}, true}};  // an operator
  for (const Arriving& arriving : samples_of(survey(7).ticks)) {
    while (!fixes.empty() && arriving.at_s >= fixes.front().time_s) {
      EXPECT_EQ(estimator.feed(fixes.front()), online::Arrival::kTaken);
      fixes.erase(fixes.begin());
    }
    feed(estimator, arriving.sample);
    if (arriving.at_s > 120.0) break;
    online::Pose pose;
    if (arriving.at_s > 30.0 && arriving.at_s < 90.0 && estimator.pose(&pose)) {
      EXPECT_NEAR(pose.x_m, 1000.0, 200.0);
      EXPECT_NEAR(pose.y_m, 2000.0, 200.0);
    }
  }
  const online::Status status = estimator.status();
  EXPECT_EQ(status.refused[kFix], 1);
  EXPECT_EQ(status.used[kFix], 2);
  EXPECT_EQ(status.relocations, 1);
  EXPECT_TRUE(notes.say(online::Note::kFix, "fix refused"));
  EXPECT_TRUE(notes.say(online::Note::kRelocation, "goes on from the fixes"));
  online::Pose pose;
  ASSERT_TRUE(estimator.pose(&pose));
  EXPECT_NEAR(pose.y_m, 2500.0, 40.0);  // 20 s at 1.5 m/s later
}

}  // namespace
}  // namespace ssjs
