// What is left of the vehicle's estimator when the level above the submaps has failed: here by a north offset believed so exactly that its
// information is no number, which the first finished submap finds.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "embed/samples.hpp"

namespace ssjs {
namespace {

using testing::Arriving;
using testing::feed;
using testing::samples_of;
using testing::survey;

constexpr online::Setting kNoLevel[] = {{"joining.north_offset_rad", "0"}, {"joining.north_offset_sigma_rad", "1e-200"}};

class FailedJoin : public ::testing::Test {
 protected:
  void SetUp() override {
    estimator_.set_log(
        [](void* told, online::Note note, double, const char* text) {
          if (note == online::Note::kFailure) static_cast<std::vector<std::string>*>(told)->emplace_back(text);
        },
        &failures_);
  }

  /// The simulated survey up to `share` of its samples.
  void sail(double share) {
    const auto end = static_cast<std::size_t>(share * static_cast<double>(samples_.size()));
    for (; fed_ < end; ++fed_) {
      ASSERT_EQ(feed(estimator_, samples_[fed_].sample), online::Arrival::kTaken) << estimator_.last_error();
    }
  }

  struct Place {
    Eigen::Vector2d estimated, true_one;
  };

  [[nodiscard]] Place place() const {
    online::Pose pose{};
    EXPECT_TRUE(estimator_.pose(&pose));
    std::size_t at = 0;
    while (at + 1 < simulated_.truth.size() && simulated_.truth[at].time_s < pose.time_s) ++at;
    return {{pose.x_m, pose.y_m}, simulated_.truth[at].world_T_vehicle.translation.head<2>()};
  }

  const SimulatedSurvey simulated_ = survey(3);
  const std::vector<Arriving> samples_ = samples_of(simulated_.ticks);
  std::size_t fed_ = 0;
  online::Estimator estimator_{kNoLevel, 2};
  std::vector<std::string> failures_;
};

/// How far two places are from each other is the same in the frame of the truth and in the estimator's own.
TEST_F(FailedJoin, SubmapsFollowEachOtherByDeadReckoning) {
  sail(0.03);
  EXPECT_EQ(estimator_.status().health, online::Health::kGood);
  std::vector<Place> places = {place()};
  int submaps = estimator_.status().submaps;
  for (const double share : {0.25, 0.5, 0.75, 1.0}) {
    sail(share);
    EXPECT_GT(estimator_.status().submaps, submaps);  // the filter goes on
    submaps = estimator_.status().submaps;
    places.push_back(place());
    for (const Place& before : places) {
      const double way_m = (places.back().true_one - before.true_one).norm();
      EXPECT_NEAR((places.back().estimated - before.estimated).norm(), way_m, 10.0) << share;
    }
  }
  EXPECT_GT((places[1].true_one - places[0].true_one).norm(), 20.0);  // there is a way to be wrong about
}

TEST_F(FailedJoin, IsSaidOnceWithItsReasonAndWhatToDo) {
  sail(1.0);
  ASSERT_EQ(failures_.size(), 1U);
  EXPECT_NE(failures_.front().find("information matrix"), std::string::npos) << failures_.front();
  const online::Status status = estimator_.status();
  EXPECT_EQ(status.health, online::Health::kDegraded);
  EXPECT_NE(std::string(status.advice).find("restore the last checkpoint"), std::string::npos) << status.advice;
  EXPECT_FALSE(status.joining);
}

TEST_F(FailedJoin, HasNoMapNoStateAndNoEnd) {
  sail(0.05);
  std::string before(estimator_.checkpoint(nullptr, 0), '\0');
  ASSERT_FALSE(before.empty());
  ASSERT_EQ(estimator_.checkpoint(before.data(), before.size()), before.size());
  sail(1.0);
  EXPECT_EQ(estimator_.landmarks(nullptr, 0), 0U);
  EXPECT_EQ(estimator_.trajectory(nullptr, 0), 0U);
  EXPECT_EQ(estimator_.checkpoint(nullptr, 0), 0U);
  EXPECT_NE(std::string(estimator_.last_error()).find("no state to write"), std::string::npos) << estimator_.last_error();
  const std::string path = ::testing::TempDir() + "failed_join.state";
  EXPECT_FALSE(estimator_.checkpoint(path.c_str()));
  EXPECT_FALSE(estimator_.finish());
  EXPECT_NE(std::string(estimator_.last_error()).find("could not be joined"), std::string::npos) << estimator_.last_error();
  EXPECT_FALSE(estimator_.finish()) << "and no better when asked again";

  online::Estimator again(kNoLevel, 2);  // the state from before is as good as ever
  ASSERT_TRUE(again.restore(before.data(), before.size())) << again.last_error();
  EXPECT_EQ(again.status().health, online::Health::kGood);
}

TEST_F(FailedJoin, LateLoopClosuresDoNotPileUp) {
  sail(1.0);
  const double now_s = samples_.back().at_s;
  for (int i = 0; i < 5000; ++i) {
    const online::Arrival arrival = estimator_.feed(online::LoopClosure{1.0, now_s, 0.0, 0.0, 0.0, {1, 0, 0, 0, 1, 0, 0, 0, 1}});
    EXPECT_TRUE(arrival == online::Arrival::kTaken || arrival == online::Arrival::kFlood) << static_cast<int>(arrival);
  }
  EXPECT_LE(estimator_.status().arrivals[static_cast<int>(online::Arrival::kTaken)], static_cast<std::int64_t>(samples_.size()) + 1024);
}

/// One sample from outside cannot bring this about.
TEST(JoiningHolds, WhateverTheCovarianceOfAFixOrAClosure) {
  const std::vector<Arriving> samples = samples_of(survey(3).ticks);
  online::Estimator estimator;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    feed(estimator, samples[i].sample);
    if (i != samples.size() / 2) continue;
    const double t = samples[i].at_s;
    for (const double variance : {1e-320, 1e-310, 1e-30, 1e30, 1e300}) {
      EXPECT_EQ(estimator.feed(online::Fix{t, 0.0, 0.0, {variance, 0, 0, variance}, true}), online::Arrival::kNotFinite);
      EXPECT_EQ(estimator.feed(online::LoopClosure{t - 300.0, t, 0.0, 0.0, 0.0, {variance, 0, 0, 0, variance, 0, 0, 0, variance}}),
                online::Arrival::kNotFinite);
    }
    EXPECT_EQ(estimator.feed(online::LoopClosure{t - 300.0, t, 1e200, 0.0, 0.0, {1, 0, 0, 0, 1, 0, 0, 0, 1}}), online::Arrival::kNotFinite);
    EXPECT_EQ(estimator.feed(online::LoopClosure{t - 300.0, t, 0.0, 0.0, 0.0, {1e-17, 0, 0, 0, 1e-17, 0, 0, 0, 1e-17}}),
              online::Arrival::kTaken);
    EXPECT_EQ(estimator.feed(online::LoopClosure{t - 200.0, t, 0.0, 0.0, 0.0, {1e11, 0, 0, 0, 1e11, 0, 0, 0, 1e11}}),
              online::Arrival::kTaken);
  }
  EXPECT_TRUE(estimator.finish()) << estimator.last_error();
}

}  // namespace
}  // namespace ssjs
