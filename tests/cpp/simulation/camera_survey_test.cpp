#include "ssjs/simulation/camera_survey.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "ssjs/base/error.hpp"
#include "ssjs/simulation/truth_track.hpp"

namespace ssjs {
namespace {

/// Rays of a camera without a lens.
CameraRays plain_rays(const PinholeCamera& camera) {
  CameraRays rays{camera.width_px, camera.height_px, {}};
  for (int v = 0; v < camera.height_px; ++v) {
    for (int u = 0; u < camera.width_px; ++u) {
      rays.slopes.emplace_back(static_cast<float>((u - camera.centre_x_px) / camera.focal_x_px),
                               static_cast<float>((v - camera.centre_y_px) / camera.focal_y_px));
    }
  }
  return rays;
}

CameraSurveyConfig small_survey() {
  CameraSurveyConfig config;
  config.lines.lines = 1;
  config.lines.cross_lines = 0;
  config.lines.line_length_m = 3.0;
  config.camera.width_px = 64;
  config.camera.height_px = 48;
  config.camera.focal_px = 64.0;
  return config;
}

/// Sand alone, level, evenly coloured.
SeabedTextureConfig bare_sand(double depth_m) {
  SeabedTextureConfig config;
  config.depth_m = depth_m;
  config.slope_north = config.slope_east = config.undulation_m = config.grain = 0.0;
  config.stones_per_m2 = config.shells_per_m2 = config.growth_per_m2 = 0.0;
  return config;
}

FrameLightConfig without_blur_and_noise() {
  FrameLightConfig light;
  light.blur_px = light.scatter_px_per_m = light.shot_noise = light.read_noise = light.backscatter = 0.0;
  light.lamp_forward_m = light.lamp_starboard_m = 0.0;
  return light;
}

const Eigen::Vector2d kCorner(-5.0, -5.0);

TEST(SeabedTexture, CS2_SlopesAreThoseOfItsDepths) {
  const SeabedTexture seabed(SeabedTextureConfig{}, kCorner, -kCorner, 3);
  const double h = seabed.relief().cell_m();
  for (int i = 0; i < 50; ++i) {  // at points of the grid, where the slope is the central difference of its neighbours
    const Eigen::Vector2d at = seabed.relief().point(20 + 9 * i, 470 - 8 * i);
    const SurfacePatch patch = seabed.surface(at.x(), at.y());
    const double north =
        (static_cast<double>(seabed.surface(at.x() + h, at.y()).depth_m) - seabed.surface(at.x() - h, at.y()).depth_m) / (2 * h);
    const double east =
        (static_cast<double>(seabed.surface(at.x(), at.y() + h).depth_m) - seabed.surface(at.x(), at.y() - h).depth_m) / (2 * h);
    EXPECT_NEAR(static_cast<double>(patch.slope_north), north, 2e-3);
    EXPECT_NEAR(static_cast<double>(patch.slope_east), east, 2e-3);
  }
}

TEST(SeabedTexture, StonesRiseFromTheGroundAndNothingElseDoes) {
  SeabedTextureConfig config;
  config.stones_per_m2 = 0.0;
  const SeabedTexture bare(config, kCorner, -kCorner, 3);
  config.stones_per_m2 = 0.25;
  const SeabedTexture strewn(config, kCorner, -kCorner, 3);
  double highest_m = 0.0;
  for (int row = 0; row < bare.relief().rows(); ++row) {
    for (int column = 0; column < bare.relief().columns(); ++column) {
      const Eigen::Vector2d at = bare.relief().point(row, column);
      EXPECT_NEAR(static_cast<double>(bare.relief().at(row, column).depth_m), bare.ground_depth_m(at), 1e-5);
      const double height_m = bare.ground_depth_m(at) - static_cast<double>(strewn.relief().at(row, column).depth_m);
      ASSERT_GE(height_m, -1e-5);
      highest_m = std::max(highest_m, height_m);
    }
  }
  EXPECT_GT(highest_m, 0.03);  // half of 0.45 of the widest
  EXPECT_LT(highest_m, 0.14);  // two of the highest, 0.0675 m, one on the other
}

TEST(FrameRenderer, CS4_ARayMeetsTheSurface) {
  const SeabedTexture seabed(SeabedTextureConfig{}, kCorner, -kCorner, 5);
  const Eigen::Vector3d camera(0.3, -0.2, 17.0);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d direction(0.5 * std::cos(0.7 * i), 0.5 * std::sin(0.7 * i), 0.8);
    const auto seen = FrameRenderer::seen_point(seabed, camera, direction);
    ASSERT_TRUE(seen);
    EXPECT_NEAR(seen->z(), static_cast<double>(seabed.surface(seen->x(), seen->y()).depth_m), 1e-6);
    EXPECT_NEAR((*seen - camera).normalized().dot(direction.normalized()), 1.0, 1e-12);
  }
  EXPECT_FALSE(FrameRenderer::seen_point(seabed, camera, Eigen::Vector3d(1.0, 0.0, 0.0)));
}

/// Lamp and camera in one place, 2.5 m above bare sand. Straight down the level is the exposure (CS-7). A ray at the angle a to it goes
/// d = 2.5 m / cos a: level cos a (exp(-(tan a / beam)^2 / 2)) (2.5 / d)^2 exp(-2 c (d - 2.5 m)) of that (CS-5), (CS-6).
TEST(FrameRenderer, CS5_CS6_CS7_LightFallsOffFromTheMiddleAsWorkedOutByHand) {
  const double above_m = 2.5;
  const SeabedTexture seabed(bare_sand(20.0), kCorner, -kCorner, 1);
  const PinholeCamera camera{65, 49, 60.0, 60.0, 32.0, 24.0};
  FrameLightConfig light = without_blur_and_noise();
  light.exposed_at_m = above_m;
  light.white_balance = 1.0;
  const FrameRenderer renderer(seabed, plain_rays(camera), light, 1);
  Se3 world_T_vehicle;
  world_T_vehicle.translation << 0.0, 0.0, 20.0 - above_m;
  const std::vector<std::uint8_t> frame = renderer.render(world_T_vehicle, vehicle_T_camera(CameraConfig{}), 0);
  const auto green = [&](int u, int v) { return static_cast<double>(frame[static_cast<std::size_t>(3 * (65 * v + u) + 1)]); };
  const double sand = std::lround(255 * 0.42) / 255.0 / 0.42;  // colours are kept in 8 bits
  for (const int u : {32, 44, 62}) {
    const double slope = (u - 32.0) / 60.0;
    const double a = std::atan(slope);
    const double d_m = above_m / std::cos(a);
    const double expected = light.exposure * sand * std::cos(a) * std::exp(-0.5 * std::pow(slope / light.beam_rad, 2)) *
                            std::pow(above_m / d_m, 2) * std::exp(-2.0 * light.green_per_m * (d_m - above_m));
    EXPECT_NEAR(green(u, 24), expected, 0.51 + 0.002 * expected);  // rounding, and the table of exponentials
    EXPECT_NEAR(green(64 - u, 24), expected, 0.51 + 0.002 * expected);
  }
}

/// The vehicle heads east at 90 degrees: a shell north of the camera is on its port side, in the left half of the picture.
TEST(FrameRenderer, ThePictureIsAheadAtTheTopAndPortOnTheLeft) {
  SeabedTextureConfig config = bare_sand(20.0);
  config.shells_per_m2 = 0.01;  // one on 100 m2
  const SeabedTexture seabed(config, kCorner, -kCorner, 4);
  Eigen::Vector2d shell = Eigen::Vector2d::Zero();
  int texels = 0;
  for (double x = -5.0; x < 5.0; x += 0.006) {
    for (double y = -5.0; y < 5.0; y += 0.006) {
      if (seabed.albedo(x, y).y() < 0.7F) continue;
      shell += Eigen::Vector2d(x, y);
      ++texels;
    }
  }
  ASSERT_GT(texels, 0);
  shell /= texels;
  const PinholeCamera camera{161, 121, 160.0, 160.0, 80.0, 60.0};
  const FrameRenderer renderer(seabed, plain_rays(camera), without_blur_and_noise(), 1);
  Se3 world_T_vehicle;
  world_T_vehicle.translation << shell.x() - 0.25, shell.y() - 0.125, 18.0;  // 0.25 m to the north of it, 0.125 m to the east: ahead
  world_T_vehicle.rpy.z() = kPi / 2;
  const std::vector<std::uint8_t> frame = renderer.render(world_T_vehicle, vehicle_T_camera(CameraConfig{}), 0);
  const auto brightest = std::max_element(frame.begin(), frame.end()) - frame.begin();
  const auto pixel = static_cast<int>(brightest / 3);
  EXPECT_NEAR(pixel % 161, 80 - 160 * 0.25 / 2.0, 2.0);   // 20 px to the left
  EXPECT_NEAR(pixel / 161, 60 - 160 * 0.125 / 2.0, 2.0);  // 10 px upwards
}

TEST(CameraSurvey, FramesAreTheSameInAnyOrderAndDifferFromSeedToSeed) {
  const CameraSurveyConfig config = small_survey();
  const CameraSurvey first(config, plain_rays(config.camera.pinhole()), 7);
  const CameraSurvey second(config, plain_rays(config.camera.pinhole()), 7);
  const CameraSurvey other(config, plain_rays(config.camera.pinhole()), 8);
  ASSERT_GT(first.frames(), 30);  // 3 m at 0.23 m/s and 3 frames/s
  const std::vector<std::uint8_t> third = first.frame(3);
  static_cast<void>(second.frame(20));
  EXPECT_EQ(second.frame(3), third);
  EXPECT_NE(other.frame(3), third);
  EXPECT_NE(first.frame(4), third);
  EXPECT_THROW(static_cast<void>(first.frame(first.frames())), InvalidArgument);
  EXPECT_THROW(CameraSurvey(config, CameraRays{64, 48, {}}, 1), InvalidArgument);
}

TEST(CameraSurvey, TheAltimeterMeasuresTheSeabedThatTheCameraSees) {
  const CameraSurveyConfig config = small_survey();
  const CameraSurvey survey(config, plain_rays(config.camera.pinhole()), 2);
  double sum_m = 0.0;
  int samples = 0;
  for (std::size_t i = 0; i < survey.survey().ticks.size(); ++i) {
    const NavigationTick& tick = survey.survey().ticks[i];
    if (!tick.altitude_m) continue;
    const Eigen::Vector3d& at = survey.survey().truth[i].world_T_vehicle.translation;
    sum_m += *tick.altitude_m - (survey.seabed().ground_depth_m(at.head<2>()) - at.z());
    ++samples;
  }
  EXPECT_NEAR(sum_m / samples, 0.0, 4.0 * config.vehicle.altitude.sigma_m / std::sqrt(samples));
}

TEST(TruthTrack, PosesBetweenStepsLieOnTheLineBetweenThem) {
  std::vector<AuvTruth> truth(3);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    truth[i].time_s = static_cast<double>(i);
    truth[i].world_T_vehicle.translation.x() = 10.0 * static_cast<double>(i);
    truth[i].world_T_vehicle.rpy.z() = wrap_angle(3.0 + 0.2 * static_cast<double>(i));
  }
  const TruthAt at = truth_at(truth, 1.25);
  EXPECT_EQ(&at.step, &truth[1]);
  EXPECT_NEAR(at.world_T_vehicle.translation.x(), 12.5, 1e-12);
  EXPECT_NEAR(angle_difference(at.world_T_vehicle.rpy.z(), 3.25), 0.0, 1e-12);  // across pi
  EXPECT_NEAR(truth_at(truth, 2.0).world_T_vehicle.translation.x(), 20.0, 1e-12);
}

}  // namespace
}  // namespace ssjs
