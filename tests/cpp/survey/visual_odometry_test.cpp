#include "ssjs/survey/visual_odometry.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "ssjs/base/error.hpp"
#include "ssjs/base/random.hpp"

namespace ssjs {
namespace {

constexpr int kWidth = 576;

/// (u, v) from the middle of the frame, of points of the body frame: the inverse of body_points().
Eigen::Matrix2Xd pixels_of(const Eigen::Matrix2Xd& body, double pixel_length) {
  Eigen::Matrix2Xd pixels(2, body.cols());
  pixels.row(0) = -body.row(1) / pixel_length;
  pixels.row(1) = -body.row(0) / pixel_length;
  return pixels;
}

/// What both frames show of ground points, those of the first spread over +-0.3 widths.
MatchedFrames matched(int first, int second, const Se2& first_T_second, double first_length, double second_length, int count,
                      double noise_px, Rng& rng) {
  Eigen::Matrix2Xd in_first(2, count), in_second(2, count);
  const Se2 second_T_first = first_T_second.inverse();
  for (int i = 0; i < count; ++i) {
    in_first.col(i) << rng.uniform(-0.1, 0.3), rng.uniform(-0.3, 0.3);
    in_second.col(i) = second_T_first * Eigen::Vector2d(in_first.col(i));
  }
  MatchedFrames pair{first, second, pixels_of(in_first, first_length), pixels_of(in_second, second_length)};
  for (int i = 0; i < count; ++i) {
    pair.first_px.col(i) += Eigen::Vector2d(rng.normal(noise_px), rng.normal(noise_px));
    pair.second_px.col(i) += Eigen::Vector2d(rng.normal(noise_px), rng.normal(noise_px));
  }
  return pair;
}

TEST(VisualOdometryTest, V16_TheTopOfThePictureIsAheadItsLeftIsToTheLeft) {
  Eigen::Matrix2Xd pixels(2, 2);
  pixels << 0.0, -20.0, -10.0, 0.0;  // above the middle; left of it
  const Eigen::Matrix2Xd body = body_points(pixels, 0.01);
  EXPECT_NEAR(body(0, 0), 0.1, 1e-15);
  EXPECT_NEAR(body(1, 0), 0.0, 1e-15);
  EXPECT_NEAR(body(0, 1), 0.0, 1e-15);
  EXPECT_NEAR(body(1, 1), 0.2, 1e-15);
}

TEST(VisualOdometryTest, V17_AltitudesFollowTheScalesAndStayNearTheUsual) {
  Rng rng(1);
  const Eigen::VectorXd height = (Eigen::VectorXd(5) << 1.0, 1.1, 1.15, 1.0, 0.9).finished();  // times the usual altitude
  const double usual = 1.0 / kWidth;
  std::vector<MatchedFrames> pairs;
  for (int i = 0; i < 4; ++i) pairs.push_back(matched(i, i + 1, {0.2, 0.0, 0.05}, usual * height(i), usual * height(i + 1), 80, 0.2, rng));
  VisualOdometryConfig config;
  config.scale_sigma = 0.005;
  const Eigen::VectorXd length = pixel_lengths(5, pairs, kWidth, config);
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(length(i + 1) / length(i), height(i + 1) / height(i), 0.01) << i;
  EXPECT_NEAR(length.array().log().mean(), std::log(usual), 0.01);
  // a frame that was never registered flies at the usual altitude; known lengths are metres
  config.metres_per_px = 0.004;
  EXPECT_NEAR(pixel_lengths(6, pairs, kWidth, config)(5), 0.004, 1e-15);
  EXPECT_NEAR(pixel_lengths(5, pairs, kWidth, config)(2) / length(2), 0.004 * kWidth, 1e-9);
}

TEST(VisualOdometryTest, V18_TheMotionOfTheMatches) {
  Rng rng(2);
  const double length = 1.0 / kWidth;
  const Se2 truth{0.22, -0.03, 0.3};
  const auto found = frame_motion(matched(0, 1, truth, length, 1.1 * length, 30, 0.0, rng), Eigen::Vector2d(length, 1.1 * length), {});
  ASSERT_TRUE(found);
  EXPECT_LT(additive_difference(found->mean, truth).norm(), 1e-12);
  EXPECT_GT(found->covariance(0, 0), 0.0);  // keypoints are no better than a pixel, however well they agree
  MatchedFrames one = matched(0, 1, truth, length, length, 1, 0.0, rng);
  EXPECT_FALSE(frame_motion(one, Eigen::Vector2d(length, length), {}));
}

TEST(VisualOdometryTest, V18_CovariancesAreHonestWhereMatchesAreIndependent) {
  Rng rng(3);
  const double length = 1.0 / kWidth;
  VisualOdometryConfig config;
  config.independent_matches = 60;
  double nees = 0.0;
  constexpr int kRuns = 2000;
  for (int run = 0; run < kRuns; ++run) {
    const Se2 truth{rng.uniform(-0.3, 0.3), rng.uniform(-0.3, 0.3), rng.uniform(-3.0, 3.0)};
    const auto found = frame_motion(matched(0, 1, truth, length, length, 60, 2.0, rng), Eigen::Vector2d(length, length), config);
    const Eigen::Vector3d error = additive_difference(found->mean, truth);
    nees += error.dot(found->covariance.llt().solve(error)) / kRuns;
  }
  // 3 degrees of freedom; the misfit has 117 of 120, and the mean of so many runs a deviation of 0.055
  EXPECT_NEAR(nees, 3.0 * 120.0 / 117.0, 0.2);
}

TEST(VisualOdometryTest, V18_MatchesThatShareErrorsCountNoMoreThanTheSetting) {
  const double length = 1.0 / kWidth;
  VisualOdometryConfig config;
  config.independent_matches = 6;
  Rng rng(4);
  const auto few = frame_motion(matched(0, 1, {0.2, 0.0, 0.0}, length, length, 40, 2.0, rng), Eigen::Vector2d(length, length), config);
  const auto many = frame_motion(matched(0, 1, {0.2, 0.0, 0.0}, length, length, 4000, 2.0, rng), Eigen::Vector2d(length, length), config);
  EXPECT_NEAR(many->covariance(2, 2) / few->covariance(2, 2), 1.0, 0.5);
}

TEST(VisualOdometryTest, V19_GapsKeepTheVelocityAndAreUnsure) {
  const GaussianSe2 slow{{0.2, 0.0, 0.0}, Eigen::Matrix3d::Identity() * 1e-6}, fast{{0.3, 0.0, 0.1}, Eigen::Matrix3d::Identity() * 1e-6};
  const Eigen::VectorXd time_s = (Eigen::VectorXd(5) << 0.0, 1.0, 2.0, 4.0, 5.0).finished();
  VisualOdometryConfig config;
  config.unseen_factor = 2.0;
  const auto increments = bridged({slow, fast, std::nullopt, slow}, time_s, config);
  ASSERT_EQ(increments.size(), 4U);
  EXPECT_EQ(increments[1].mean.x, 0.3);
  EXPECT_NEAR(increments[2].mean.x, 0.6, 1e-12);  // two seconds at 0.3 a second
  EXPECT_NEAR(increments[2].mean.heading, 0.2, 1e-12);
  // it changes by 0.1 a second and 0.1 rad: twice that over two seconds
  EXPECT_NEAR(std::sqrt(increments[2].covariance(0, 0)), 0.4, 1e-12);
  EXPECT_NEAR(std::sqrt(increments[2].covariance(2, 2)), 0.4, 1e-12);
  EXPECT_GT(increments[2].covariance(1, 1), 0.0);
  // before anything registered: the velocity that comes
  EXPECT_NEAR(bridged({std::nullopt, slow, fast, slow}, time_s, config)[0].mean.x, 0.2, 1e-12);
  EXPECT_THROW((void)bridged({std::nullopt, std::nullopt}, Eigen::Vector3d(0, 1, 2), config), InvalidArgument);
  EXPECT_THROW((void)bridged({slow, slow}, Eigen::Vector3d(0, 1, 1), config), InvalidArgument);
  EXPECT_THROW((void)bridged({slow}, Eigen::Vector3d(0, 1, 2), config), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
