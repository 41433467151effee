#include "ssjs/simulation/side_scan_simulator.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

SeabedConfig flat(double depth_m) {
  SeabedConfig config;
  config.depth_m = depth_m;
  config.undulation_m = 0;
  config.ripple_m = 0;
  config.patch_contrast = 0;
  return config;
}

SideScanSimulationConfig fine() {
  SideScanSimulationConfig config;
  config.samples = 1000;
  config.beam_rays = 1;
  config.transmit_m = 0;
  return config;
}

SonarPose at(double north_m, double depth_m, const Eigen::Vector3d& rpy = Eigen::Vector3d::Zero()) {
  return {0.0, {{north_m, 0.0, depth_m}, rpy}, 1.5};
}

SeabedObject box(double east_m, double length_m, double width_m, double height_m) {
  SeabedObject object;
  object.position_m = {0.0, east_m};
  object.length_m = length_m;
  object.width_m = width_m;
  object.height_m = height_m;
  return object;
}

/// First and last sample of the longest run without echo beyond the first bottom return.
std::pair<int, int> longest_shadow(const std::vector<double>& power, double altitude_m, double spacing_m) {
  std::pair<int, int> longest{0, -1};
  int first = 0;
  for (int i = static_cast<int>(altitude_m / spacing_m) + 2; i < static_cast<int>(power.size()); ++i) {
    if (power[static_cast<std::size_t>(i)] > 0) {
      first = i + 1;
    } else if (i - first > longest.second - longest.first) {
      longest = {first, i};
    }
  }
  return longest;
}

TEST(SideScanSimulatorTest, SS25_ShadowOfABoxEndsWhereTheRayOverItsEdgeLands) {
  // 5 m up; the far upper edge of a 1 m high box is 16 m away: the ray falls 4 m in 16 and lands at 20 m.
  for (const double height_m : {0.4, 1.0, 1.6}) {
    SideScanSimulator simulator(Seabed(flat(20), {box(15.5, 2, 1, height_m)}, 1), fine(), 1);
    const double spacing = simulator.sample_spacing_m();
    const auto [first, last] = longest_shadow(simulator.mean_power(at(0, 15), SonarSide::kStarboard), 5, spacing);
    const double tip_m = 16.0 * 5.0 / (5.0 - height_m);
    // A sample lit in part is not dark; the profile has the edge to half a sample, which the ray over it draws out.
    const double tolerance = spacing + 0.5 * spacing * 5.0 / (5.0 - height_m);
    EXPECT_NEAR((first - 0.5) * spacing, std::hypot(16.0, 5.0 - height_m), tolerance) << height_m;
    EXPECT_NEAR((last + 0.5) * spacing, std::hypot(tip_m, 5.0), tolerance) << height_m;
    const std::vector<double> port = simulator.mean_power(at(0, 15), SonarSide::kPort);
    EXPECT_GT(*std::min_element(port.begin() + static_cast<int>(5.1 / spacing), port.end()), 0) << "no shadow on the other side";
  }
}

TEST(SideScanSimulatorTest, SS27_FlatSeabedFollowsLambert) {
  SideScanSimulationConfig config = fine();
  config.vertical_beam_rad = 3.0;  // nearly even
  config.depression_rad = 0.0;
  config.absorption_db_m = config.gain_db_m;
  SideScanSimulator simulator(Seabed(flat(20), {}, 1), config, 1);
  const double spacing = simulator.sample_spacing_m();
  const std::vector<double> power = simulator.mean_power(at(0, 15), SonarSide::kPort);
  const double exponent = std::log(0.5) / std::log(std::cos(1.5));
  for (const int sample : {250, 400, 900}) {
    const double range = sample * spacing;
    const double sine = 5.0 / range;
    const double cosine = std::sqrt(1 - sine * sine);
    // mu sin^2 times the length of seabed that one sample covers, in samples, and the pattern
    EXPECT_NEAR(power[static_cast<std::size_t>(sample)], sine * sine / cosine * std::pow(cosine, exponent),
                0.01 * power[static_cast<std::size_t>(sample)]);
  }
}

TEST(SideScanSimulatorTest, WaterColumnEndsAtTheAltitudeAndTheSidesAreAlike) {
  SideScanSimulator simulator(Seabed(flat(20), {}, 1), fine(), 1);
  for (const double altitude_m : {3.0, 7.5, 12.0}) {
    const std::vector<double> port = simulator.mean_power(at(0, 20 - altitude_m), SonarSide::kPort);
    const std::vector<double> starboard = simulator.mean_power(at(0, 20 - altitude_m), SonarSide::kStarboard);
    const auto first = std::find_if(port.begin(), port.end(), [](double power) { return power > 0; }) - port.begin();
    EXPECT_NEAR(static_cast<double>(first) * simulator.sample_spacing_m(), altitude_m, simulator.sample_spacing_m());
    EXPECT_EQ(port, starboard);
  }
}

TEST(SideScanSimulatorTest, SS24_PitchMovesTheFanAheadAndRollTurnsThePattern) {
  const double altitude_m = 5.0;
  SeabedObject object = box(12, 0.6, 2, 0.8);
  object.position_m.x() = 2.0;
  const double pitch = std::atan(2.0 / altitude_m);  // nose up: 2 m ahead on the ground
  SideScanSimulator simulator(Seabed(flat(20), {object}, 1), fine(), 1);
  const auto shadow_of = [&](double tilt) {
    const auto [first, last] = longest_shadow(simulator.mean_power(at(0, 15, {0, tilt, 0}), SonarSide::kStarboard), 6, 0.03);
    return last - first;
  };
  EXPECT_GT(shadow_of(pitch), 20);
  EXPECT_LT(shadow_of(0), 5);
  // Starboard down by 0.2: the beam's axis points lower there, and the far end is weaker than at port.
  const std::vector<double> starboard = simulator.mean_power(at(-9, 15, {0.2, 0, 0}), SonarSide::kStarboard);
  const std::vector<double> port = simulator.mean_power(at(-9, 15, {0.2, 0, 0}), SonarSide::kPort);
  EXPECT_LT(starboard[900], port[900]);
}

TEST(SideScanSimulatorTest, SS24_SlopingSeabedIsMetWhereThePlaneSaysSo) {
  SeabedConfig config = flat(20);
  config.slope_east = 0.1;
  SeabedObject object = box(15, 2, 0.5, 1.0);
  SideScanSimulator simulator(Seabed(config, {object}, 1), fine(), 1);
  const double spacing = simulator.sample_spacing_m();
  const auto [first, last] = longest_shadow(simulator.mean_power(at(0, 15), SonarSide::kStarboard), 5, spacing);
  // Ray over the far edge at 15.25 m, 5 + 1.5 - 1 = 5.5 m below the sonar; seabed 5 + 0.1 y: y (5.5 / 15.25 - 0.1) = 5.
  const double tip = 5.0 / (5.5 / 15.25 - 0.1);
  EXPECT_NEAR((last + 0.5) * spacing, std::hypot(tip, 5.0 + 0.1 * tip), 1.5 * spacing);
  EXPECT_LT(first, last);
}

TEST(SideScanSimulatorTest, SS31_SpeckleIsRayleighOrKDistributed) {
  for (const double shape : {0.0, 2.0}) {
    SideScanSimulationConfig config = fine();
    config.noise_db = -200;
    config.texture_shape = shape;
    SideScanSimulator simulator(Seabed(flat(20), {}, 1), config, 7);
    const std::vector<double> power = simulator.mean_power(at(0, 15), SonarSide::kPort);
    double sum = 0;
    double square = 0;
    int count = 0;
    for (int n = 0; n < 100; ++n) {
      const SideScanPing ping = simulator.ping(at(0, 15));
      for (std::size_t i = 300; i < 1000; ++i) {
        const double level = ping.channels[0].samples[i] / config.echo_level;
        const double relative = level * level / power[i];
        sum += relative;
        square += relative * relative;
        ++count;
      }
    }
    // Power: exponential (mean 1, second moment 2), times a gamma texture of mean 1 and second moment 1 + 1 / shape.
    const double texture = shape > 0 ? 1.0 + 1.0 / shape : 1.0;
    EXPECT_NEAR(sum / count, 1.0, 0.03);
    EXPECT_NEAR(square / count, 2.0 * texture, 0.06 * 2.0 * texture);
  }
}

TEST(SideScanSimulatorTest, SameSeedSamePingsAndNoiseDoesNotMoveTheSeabed) {
  const SideScanSimulationConfig config;
  const Seabed seabed(SeabedConfig{}, scatter_objects(5, {-20, -20}, {20, 20}, 4, 3), 3);
  SideScanSimulator a(seabed, config, 5);
  SideScanSimulator b(seabed, config, 5);
  SideScanSimulator c(seabed, config, 6);
  const std::vector<float> first = a.ping(at(0, 14)).channels[1].samples;
  EXPECT_EQ(first, b.ping(at(0, 14)).channels[1].samples);
  EXPECT_NE(first, c.ping(at(0, 14)).channels[1].samples);
  EXPECT_EQ(a.mean_power(at(0, 14), SonarSide::kPort), c.mean_power(at(0, 14), SonarSide::kPort));
}

TEST(SideScanSimulatorTest, TruthIsTakenAtThePingAbeam) {
  SideScanSimulator simulator(Seabed(flat(20), {box(-12, 1, 1, 0.5)}, 1), fine(), 1);
  std::vector<ObjectSighting> seen;
  for (int n = 0; n < 20; ++n) {
    static_cast<void>(simulator.ping(at(-1.9 + 0.2 * n, 15)));
    seen.insert(seen.end(), simulator.sightings().begin(), simulator.sightings().end());
  }
  ASSERT_EQ(seen.size(), 1U);
  EXPECT_TRUE(seen[0].ping == 9 || seen[0].ping == 10) << seen[0].ping;  // 0.1 m short of it and 0.1 m beyond
  EXPECT_EQ(seen[0].side, SonarSide::kPort);
  EXPECT_NEAR(seen[0].slant_range_m, std::hypot(12, 4.5), 0.01);
  EXPECT_NEAR(seen[0].body_p_object.y(), -12, 1e-12);
  EXPECT_NEAR(seen[0].body_p_object.z(), 5, 1e-12);
}

TEST(SideScanSimulatorTest, ASonarInTheGroundIsRefused) {
  SideScanSimulator simulator(Seabed(flat(20), {}, 1), fine(), 1);
  EXPECT_THROW(static_cast<void>(simulator.ping(at(0, 21))), InvalidArgument);
}

TEST(SeabedTest, SS23_ALineIsTheSameAsItsPoints) {
  const Seabed seabed(SeabedConfig{}, {}, 11);
  const Eigen::Vector2d start(3, -40);
  const Eigen::Vector2d step(0.021, 0.043);
  SeabedProfile profile;
  seabed.sample(start, step, 2000, profile);
  for (const int i : {0, 1, 777, 1999}) {
    EXPECT_NEAR(profile.depth_m[static_cast<std::size_t>(i)], seabed.depth_m(start + i * step), 1e-9);
    EXPECT_NEAR(profile.reflectivity[static_cast<std::size_t>(i)], seabed.reflectivity(start + i * step), 1e-9);
  }
}

TEST(SeabedTest, SS22_HeightsOfTheShapes) {
  SeabedObject object = box(0, 2, 1, 0.6);
  EXPECT_EQ(object.height_at({0.99, 0.49}), 0.6);
  EXPECT_EQ(object.height_at({0.0, 0.51}), 0.0);
  object.heading_rad = kPi / 2;  // its length to the east now
  EXPECT_EQ(object.height_at({0.0, 0.99}), 0.6);
  object.shape = ObjectShape::kCylinder;
  EXPECT_EQ(object.height_at({0.0, 0.0}), 0.6);
  EXPECT_NEAR(object.height_at({0.3, 0.0}), 0.3 + 0.3 * 0.8, 1e-12);  // 3-4-5: 0.6 of the half width, 0.8 of the half height
  object.shape = ObjectShape::kDome;
  EXPECT_NEAR(object.height_at({0.3, 0.0}), 0.6 * 0.8, 1e-12);
  object.shape = ObjectShape::kCone;
  EXPECT_EQ(object.height_at({0.2, 0.0}), 0.6);
  EXPECT_NEAR(object.height_at({0.375, 0.0}), 0.3, 1e-12);
  EXPECT_THROW(static_cast<void>(scatter_objects(100, {0, 0}, {5, 5}, 3, 1)), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
