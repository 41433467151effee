#include "ssjs/pipeline/slam_config.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "ssjs/base/error.hpp"
#include "ssjs/pipeline/slam_pipeline.hpp"

namespace ssjs {
namespace {

TEST(SlamConfig, DefaultsAreValid) {
  EXPECT_TRUE(SlamConfig().violations().empty());
  EXPECT_NO_THROW(SlamPipeline(SlamConfig(), 1));
}

TEST(SlamConfig, EveryViolationIsListedWithItsKey) {
  SlamConfig config;
  config.association.gate_probability = 1.2;
  config.submap.split.max_landmarks = 2;
  config.vehicle.ackerman.wheelbase_m = std::numeric_limits<double>::quiet_NaN();
  config.joining.max_pairing_sigma_m = 0.0;
  const std::vector<std::string> all = config.violations();
  ASSERT_EQ(all.size(), 4U);
  EXPECT_EQ(all[0], "vehicle.ackerman.wheelbase_m = nan: must be positive and finite");
  EXPECT_EQ(all[1], "association.gate_probability = 1.2: must lie in (0, 1)");
  EXPECT_EQ(all[2], "submap.max_landmarks = 2: must be at least 3");
  EXPECT_EQ(all[3], "joining.max_pairing_sigma_m = 0: must be positive and finite");
  try {
    SlamPipeline pipeline(config, 1);
    FAIL() << "an invalid configuration was accepted";
  } catch (const InvalidArgument& error) {
    for (const std::string& violation : all) EXPECT_NE(std::string(error.what()).find(violation), std::string::npos) << error.what();
  }
}

TEST(SlamConfig, RulesBetweenFields) {
  SlamConfig config;
  config.sensor.min_range_m = config.sensor.max_range_m = 5.0;
  EXPECT_EQ(config.violations(), std::vector<std::string>{"sensor.min_range_m = 5: must be below sensor.max_range_m = 5"});
  config = {};
  config.trees.min_range_m = 50.0;
  EXPECT_EQ(config.violations(), std::vector<std::string>{"trees.min_range_m = 50: must be below trees.max_range_m = 40"});
  config = {};
  config.trees.min_diameter_m = 1.5;
  EXPECT_EQ(config.violations(), std::vector<std::string>{"trees.min_diameter_m = 1.5: must be below trees.max_diameter_m = 1.2"});
  config = {};
  config.aekf.max_missed_views = 20;
  EXPECT_EQ(config.violations(), std::vector<std::string>{"aekf.max_missed_views = 20: must be at most aekf.view_window = 10"});
  config = {};
  config.joining.max_fused_landmarks = 10;
  EXPECT_EQ(config.violations(), std::vector<std::string>{"joining.max_fused_landmarks = 10: must be at least submap.max_landmarks = 15"});
}

}  // namespace
}  // namespace ssjs
