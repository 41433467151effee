#include "ssjs/optical/matching.hpp"

#include <gtest/gtest.h>

#include "optical/seabed_picture.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/optical/frame_preprocess.hpp"

namespace ssjs {
namespace {

const cv::Size kFrame(320, 240);

Keypoints keypoints_of(const cv::Mat& view, KeypointKind kind = KeypointKind::kSurf) {
  KeypointConfig config;
  config.kind = kind;
  return find_keypoints(evenly_lit(view, {}), {}, config);
}

TEST(MatchingTest, V13_ASimilarityThroughItsPoints) {
  const Similarity motion{1.25, 2.8, {12.0, -7.0}};
  const std::vector<cv::Point2d> first{{0, 0}, {10, 0}, {3, 8}, {-4, 5}};
  std::vector<cv::Point2d> second;
  for (const cv::Point2d& p : first) second.push_back(motion * p);
  const Similarity found = fit_similarity(first, second);
  EXPECT_NEAR(found.scale, 1.25, 1e-12);
  EXPECT_NEAR(found.angle_rad, 2.8, 1e-12);
  EXPECT_LT(cv::norm(found.shift_px - motion.shift_px), 1e-10);
  EXPECT_THROW((void)fit_similarity({{1, 1}, {1, 1}}, {{1, 1}, {2, 2}}), InvalidArgument);
  EXPECT_THROW((void)fit_similarity({{1, 1}}, {{1, 1}}), InvalidArgument);
}

TEST(MatchingTest, V12_OnlyClearMutualMatches) {
  Keypoints a, b;
  a.points.resize(3);
  b.points.resize(3);
  // a0 = b0; a1 lies between b1 and b2; a2 wants b0, which is a0's
  a.descriptors = (cv::Mat_<float>(3, 2) << 0, 0, 5, 5, 0.4F, 0);
  b.descriptors = (cv::Mat_<float>(3, 2) << 0.1F, 0, 5.5F, 5, 4.5F, 5);
  const std::vector<KeypointMatch> matches = match_descriptors(a, b, 0.8);
  ASSERT_EQ(matches.size(), 1U);
  EXPECT_EQ(matches[0].first, 0);
  EXPECT_EQ(matches[0].second, 0);
  EXPECT_NEAR(matches[0].distance, 0.1, 1e-6);
  EXPECT_TRUE(match_descriptors(a, Keypoints{}, 0.8).empty());
  b.descriptors = cv::Mat(3, 3, CV_32F, cv::Scalar(0));
  EXPECT_THROW((void)match_descriptors(a, b, 0.8), InvalidArgument);
}

class RegistersTest : public testing::TestWithParam<KeypointKind> {};

TEST_P(RegistersTest, TurnedScaledAndNoisyViews) {
  if (!has_keypoints(GetParam())) GTEST_SKIP() << "built without OpenCV's features2d";
  const cv::Mat ground = seabed_picture({900, 700}, 2500, 7);
  const Similarity first_T_ground{1.0, 0.0, {-250.0, -200.0}};
  const Keypoints first = keypoints_of(view_of(ground, first_T_ground, kFrame, 4.0, 1));
  for (const double angle : {0.0, 0.5, 1.6, 3.0}) {
    // about the middle of the frame, 40 px aside
    const cv::Point2d middle(160, 120);
    Similarity turned{1.1, angle, {}};
    turned.shift_px = middle + cv::Point2d(30, 25) - turned * middle;
    const Similarity second_T_ground{1.1, angle, turned * first_T_ground.shift_px};
    const Keypoints second = keypoints_of(view_of(ground, second_T_ground, kFrame, 4.0, 2));
    const auto found = register_frames(first, second, match_descriptors(first, second, 0.85), {});
    ASSERT_TRUE(found) << angle;
    EXPECT_NEAR(found->second_T_first.scale, 1.1, 0.01);
    for (const cv::Point2d p : {cv::Point2d(80, 60), cv::Point2d(240, 180), middle}) {
      EXPECT_LT(cv::norm(found->second_T_first * p - turned * p), 1.0) << angle;
      const cv::Vec3d q = found->second_H_first * cv::Vec3d(p.x, p.y, 1.0);
      EXPECT_LT(cv::norm(cv::Point2d(q[0] / q[2], q[1] / q[2]) - turned * p), 1.5) << angle;
    }
    const auto again = register_frames(first, second, match_descriptors(first, second, 0.85), {});
    EXPECT_EQ(again->second_T_first.shift_px, found->second_T_first.shift_px);
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, RegistersTest, testing::Values(KeypointKind::kSurf, KeypointKind::kSift, KeypointKind::kOrb));

TEST(MatchingTest, TwoPlacesAreNotRegistered) {
  const Keypoints first = keypoints_of(seabed_picture(kFrame, 400, 7));
  for (std::uint64_t seed = 20; seed < 40; ++seed) {
    const Keypoints second = keypoints_of(seabed_picture(kFrame, 400, seed));
    EXPECT_FALSE(register_frames(first, second, match_descriptors(first, second, 0.85), {})) << seed;
  }
}

}  // namespace
}  // namespace ssjs
