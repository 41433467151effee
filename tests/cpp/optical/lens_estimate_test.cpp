#include "ssjs/optical/lens_estimate.hpp"

#include <gtest/gtest.h>

#include "ssjs/base/error.hpp"
#include "ssjs/base/random.hpp"
#include "ssjs/optical/matching.hpp"

namespace ssjs {
namespace {

const cv::Size kFrame(576, 384);

CameraCalibration lens_with(double k1) {
  CameraCalibration calibration;
  calibration.camera = {kFrame.width, kFrame.height, 288.0, 288.0, 287.5, 191.5};
  calibration.lens = LensModel::kBrown;
  calibration.distortion[0] = k1;
  return calibration;
}

/// Level ground under a camera that moves, turns and tilts a little; seen through the lens, with noise and a few wrong matches.
std::vector<MatchedPixels> seen_pairs(double k1, int count, double noise_px) {
  const CameraCalibration lens = lens_with(k1);
  Rng rng(5);
  std::vector<MatchedPixels> pairs;
  for (int i = 0; i < count; ++i) {
    const Similarity motion{rng.uniform(0.95, 1.05), rng.uniform(-0.2, 0.2), {rng.uniform(-150, 150), rng.uniform(-120, 120)}};
    cv::Matx33d H = matrix_of(motion);
    H(2, 0) = rng.uniform(-3e-5, 3e-5);
    H(2, 1) = rng.uniform(-3e-5, 3e-5);
    MatchedPixels pair;
    while (pair.first_px.size() < 60) {
      const cv::Point2d p(rng.uniform(0, 575), rng.uniform(0, 383)), q = transformed(H, p);
      if (q.x < 0 || q.y < 0 || q.x > 575 || q.y > 383) continue;
      const cv::Point2d noise_p(rng.normal(noise_px), rng.normal(noise_px)), noise_q(rng.normal(noise_px), rng.normal(noise_px));
      pair.first_px.push_back(distorted(lens, p) + noise_p);
      pair.second_px.push_back(distorted(lens, q) + noise_q);
    }
    pairs.push_back(pair);
  }
  return pairs;
}

TEST(LensEstimateTest, V15_FindsTheLensOfMovedAndTiltedFrames) {
  for (const double k1 : {-0.08, 0.0, 0.06}) {
    const auto found = estimate_lens(seen_pairs(k1, 40, 0.5), kFrame, 6.0);
    if (k1 == 0.0 && !found) continue;  // no lens makes it better: right as well
    ASSERT_TRUE(found) << k1;
    EXPECT_NEAR(found->calibration.distortion[0], k1, 0.004) << k1;
    // 0.5 px in either picture and along either axis
    EXPECT_NEAR(found->rms_after_px, 1.0, 0.1) << k1;
    EXPECT_GE(found->rms_before_px, found->rms_after_px);
    EXPECT_NO_THROW(check_calibration(found->calibration));
  }
}

TEST(LensEstimateTest, V15_TooLittleSaysNothing) {
  EXPECT_FALSE(estimate_lens({}, kFrame, 6.0));
  EXPECT_FALSE(estimate_lens(seen_pairs(-0.08, 4, 0.5), kFrame, 6.0, 5));
  std::vector<MatchedPixels> few = seen_pairs(-0.08, 10, 0.5);
  for (MatchedPixels& pair : few) {
    pair.first_px.resize(24);
    pair.second_px.resize(24);
  }
  EXPECT_FALSE(estimate_lens(few, kFrame, 6.0));
  few[0].second_px.resize(20);
  EXPECT_THROW((void)estimate_lens(few, kFrame, 6.0), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
