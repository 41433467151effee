#include "ssjs/optical/matching.hpp"

#include <gtest/gtest.h>

#include "optical/seabed_picture.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/base/random.hpp"
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

TEST(MatchingTest, V14_TheTiltOfACameraIsTakenUp) {
  cv::Matx33d H = matrix_of({1.02, 0.1, {60.0, -40.0}});
  H(2, 0) = 1.5e-4;  // moves the border of the frame by about 10 px
  H(2, 1) = -1e-4;
  Keypoints first, second;
  std::vector<KeypointMatch> matches;
  Rng rng(6);
  for (int i = 0; i < 160; ++i) {
    const cv::Point2d p(rng.uniform(0, 320), rng.uniform(0, 240));
    const cv::Point2d wrong(rng.uniform(0, 320), rng.uniform(0, 240));
    first.points.push_back({p, 1.0, 0.0, 1.0});
    second.points.push_back({i % 4 == 0 ? wrong : transformed(H, p) + cv::Point2d(rng.normal(0.3), rng.normal(0.3)), 1.0, 0.0, 1.0});
    matches.push_back({i, i, 0.1});
  }
  MatchingConfig config;
  config.tolerance_px = 3.0;
  const auto found = register_frames(first, second, matches, config);
  ASSERT_TRUE(found);
  int true_ones = 0;
  for (const KeypointMatch& match : found->inliers) true_ones += match.first % 4 != 0 ? 1 : 0;
  EXPECT_EQ(true_ones, 120);
  EXPECT_LE(found->inliers.size(), 124U);  // a wrong one lies within 3 px by chance at times
  int of_similarity = 0;
  for (int i = 0; i < 160; ++i) {
    const auto row = static_cast<std::size_t>(i);
    if (cv::norm(found->second_T_first * first.points[row].position_px - second.points[row].position_px) <= 3.0) ++of_similarity;
  }
  EXPECT_LT(of_similarity, 110);
  for (const cv::Point2d p : {cv::Point2d(5, 5), cv::Point2d(315, 10), cv::Point2d(160, 235)}) {
    EXPECT_LT(cv::norm(transformed(found->second_H_first, p) - transformed(H, p)), 0.5);
  }
}

TEST(MatchingTest, V14_AnAffineMapAndAHomographyThroughTheirPoints) {
  const cv::Matx33d A(1.1, 0.2, 5.0, -0.1, 0.9, -3.0, 0.0, 0.0, 1.0), H(1.1, 0.2, 5.0, -0.1, 0.9, -3.0, 1e-3, -5e-4, 1.0);
  const std::vector<cv::Point2d> first{{0, 0}, {100, 0}, {30, 80}, {-40, 50}, {90, 95}};
  std::vector<cv::Point2d> by_affine, by_homography;
  for (const cv::Point2d& p : first) {
    by_affine.push_back(transformed(A, p));
    by_homography.push_back(transformed(H, p));
  }
  EXPECT_LT(cv::norm(*fit_affine(first, by_affine), A), 1e-9);
  EXPECT_LT(cv::norm(*fit_homography(first, by_homography), H), 1e-7);
  EXPECT_FALSE(fit_affine({{0, 0}, {1, 1}, {2, 2}}, {{0, 0}, {1, 1}, {2, 2}}));
  EXPECT_FALSE(fit_homography({{0, 0}, {1, 0}, {0, 1}}, {{0, 0}, {1, 0}, {0, 1}}));
}

TEST(MatchingTest, TwoPlacesAreNotRegistered) {
  const Keypoints first = keypoints_of(seabed_picture(kFrame, 400, 7));
  for (std::uint64_t seed = 20; seed < 40; ++seed) {
    const Keypoints second = keypoints_of(seabed_picture(kFrame, 400, seed));
    EXPECT_FALSE(register_frames(first, second, match_descriptors(first, second, 0.85), {})) << seed;
  }
}

}  // namespace
}  // namespace ssjs
