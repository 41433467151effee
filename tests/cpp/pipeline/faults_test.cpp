// The essentials of docs/faults.md; all of it: ssjs_study faults.
#include <gtest/gtest.h>

#include <algorithm>

#include "pipeline/fault_run.hpp"

namespace ssjs {
namespace {

const SimulatedSurvey& survey() {
  static const SimulatedSurvey simulated = testing::two_dives(1);
  return simulated;
}

/// Runs the fault of that name and checks what holds of all of them: nothing throws, and after it the position comes back inside three
/// sigma within two loop closures, or with the first fix.
testing::FaultOutcome run(const std::string& name) {
  const std::vector<testing::FaultCase> faults = testing::faults(survey());
  const auto fault = std::find_if(faults.begin(), faults.end(), [&](const testing::FaultCase& each) { return each.name == name; });
  if (fault == faults.end()) throw InvalidArgument("fault", name, "none of the faults has this name");
  const testing::FaultOutcome outcome = testing::run_fault(survey(), *fault, 1);
  EXPECT_EQ(outcome.failures, 0) << name;
  EXPECT_TRUE(outcome.recovered_s) << name;
  EXPECT_TRUE(outcome.closures_until <= 2 || outcome.fixes_until == 1) << name << ": " << outcome.closures_until << " closures";
  return outcome;
}

bool says(const testing::FaultOutcome& outcome, const std::string& part) {
  return std::any_of(outcome.notes.begin(), outcome.notes.end(),
                     [&](const std::string& note) { return note.find(part) != std::string::npos; });
}

TEST(Faults, AClockThatIsSetBackCostsHardlyAnything) {
  const testing::FaultOutcome outcome = run("clock back by 3 h, for good");
  EXPECT_TRUE(says(outcome, "clock of the samples was set"));
  EXPECT_EQ(outcome.status.clock_changes, 1);
  EXPECT_LT(outcome.during_sigmas, 3.0);
}

TEST(Faults, TenMinutesWithoutVelocityAreReportedAndHonest) {
  const testing::FaultOutcome outcome = run("velocity log silent for 600 s");
  EXPECT_TRUE(says(outcome, "no velocity over the bottom"));
  EXPECT_GE(outcome.worst, SurveyHealth::kDegraded);
  EXPECT_LT(outcome.during_sigmas, 4.0);
}

TEST(Faults, DepthInMillimetresIsRefusedAndNamed) {
  const testing::FaultOutcome outcome = run("depth in mm for 120 s");
  EXPECT_TRUE(says(outcome, "depth seems to come in another unit"));
  EXPECT_LT(outcome.during_sigmas, 3.0);
}

TEST(Faults, AVelocityLogThatHangsIsNotUsed) {
  const testing::FaultOutcome outcome = run("velocity log hangs for 120 s");
  EXPECT_TRUE(says(outcome, "velocity log hangs"));
}

TEST(Faults, AFloodOfSightingsIsBounded) {
  const testing::FaultOutcome outcome = run("10,000 sightings of nothing in 60 s");
  EXPECT_TRUE(says(outcome, "more sightings than there can be"));
  EXPECT_GT(outcome.status.refused[static_cast<std::size_t>(NavigationSensor::kSideScan)], 9000);
}

}  // namespace
}  // namespace ssjs
