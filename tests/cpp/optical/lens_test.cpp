#include "ssjs/optical/lens.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "ssjs/base/error.hpp"
#include "ssjs/base/random.hpp"

namespace ssjs {
namespace {

CameraCalibration calibration(LensModel lens, std::array<double, 5> distortion) {
  return {{320, 240, 400.0, 410.0, 165.0, 118.0}, 1.5, lens, distortion};
}

const CameraCalibration kBrownCamera = calibration(LensModel::kBrown, {-0.25, 0.08, 1e-3, -2e-3, 0.02});
const CameraCalibration kFisheyeCamera = calibration(LensModel::kEquidistant, {0.02, -0.01, 0.004, -0.002, 0.0});

TEST(LensTest, V2_BrownByHand) {
  // x = 0.5, y = 0.25: r2 = 0.3125; radial = 1 + 0.1 * 0.3125 + 0.01 * 0.09765625 = 1.0322265625
  CameraCalibration camera{{100, 100, 100.0, 200.0, 10.0, 20.0}, 0.0, LensModel::kBrown, {0.1, 0.01, 0.002, 0.003, 0.0}};
  const double x = 0.5 * 1.0322265625 + 2 * 0.002 * 0.125 + 0.003 * (0.3125 + 0.5);
  const double y = 0.25 * 1.0322265625 + 0.002 * (0.3125 + 0.125) + 2 * 0.003 * 0.125;
  const cv::Point2d seen = distorted(camera, {10.0 + 50.0, 20.0 + 50.0});
  EXPECT_NEAR(seen.x, 10.0 + 100.0 * x, 1e-12);
  EXPECT_NEAR(seen.y, 20.0 + 200.0 * y, 1e-12);
}

TEST(LensTest, V3_AnEquidistantLensWithoutCoefficientsShowsTheAngle) {
  CameraCalibration camera = calibration(LensModel::kEquidistant, {});
  camera.skew_px = 0.0;
  const cv::Point2d seen = distorted(camera, {165.0 + 400.0 * std::tan(0.7), 118.0});
  EXPECT_NEAR(seen.x, 165.0 + 400.0 * 0.7, 1e-10);
  EXPECT_NEAR(seen.y, 118.0, 1e-12);
}

TEST(LensTest, V4_UndistortedIsTheInverse) {
  Rng rng(4);
  for (const CameraCalibration& camera : {kBrownCamera, kFisheyeCamera}) {
    for (int i = 0; i < 200; ++i) {
      const cv::Point2d ideal(rng.uniform(0, 320), rng.uniform(0, 240));
      const cv::Point2d back = undistorted(camera, distorted(camera, ideal));
      EXPECT_LT(cv::norm(back - ideal), 1e-8);
    }
  }
}

TEST(LensTest, AFrameIsCorrectedPixelByPixel) {
  // A picture whose level is its column as the camera shows it: corrected, each pixel holds the column that its ray went to.
  cv::Mat frame(240, 320, CV_8U);
  for (int c = 0; c < frame.cols; ++c) frame.col(c).setTo(c / 2);
  const Undistortion undistortion(kBrownCamera);
  const cv::Mat corrected = undistortion.apply(frame);
  int compared = 0;
  for (int v = 0; v < 240; v += 7) {
    for (int u = 0; u < 320; u += 7) {
      if (undistortion.valid().at<unsigned char>(v, u) == 0) continue;
      const cv::Point2d from = distorted(kBrownCamera, {static_cast<double>(u), static_cast<double>(v)});
      EXPECT_NEAR(corrected.at<unsigned char>(v, u), from.x / 2, 1.1);
      ++compared;
    }
  }
  EXPECT_GT(compared, 1000);
}

TEST(LensTest, WithoutALensTheFrameStaysAsItIs) {
  const cv::Mat frame(240, 320, CV_8UC3, cv::Scalar(1, 2, 3));
  CameraCalibration camera = calibration(LensModel::kPinhole, {});
  camera.skew_px = 0.0;
  EXPECT_EQ(Undistortion(camera).apply(frame).data, frame.data);
}

TEST(LensTest, WhatCannotBeIsRefused) {
  EXPECT_THROW(check_calibration(calibration(LensModel::kBrown, {-2.0, 0.0, 0.0, 0.0, 0.0})), InvalidArgument);  // folds
  EXPECT_THROW(check_calibration(calibration(LensModel::kBrown, {NAN, 0.0, 0.0, 0.0, 0.0})), InvalidArgument);
  CameraCalibration camera = kBrownCamera;
  camera.camera.focal_x_px = 0.0;
  EXPECT_THROW(check_calibration(camera), InvalidArgument);
  camera = kBrownCamera;
  camera.camera.centre_x_px = -20.0;  // of a part cut out of a larger frame
  EXPECT_NO_THROW(check_calibration(camera));
  camera.camera.centre_x_px = 16000.0;
  EXPECT_THROW(check_calibration(camera), InvalidArgument);
  try {
    (void)Undistortion(kBrownCamera).apply(cv::Mat(480, 640, CV_8U, cv::Scalar(0)));
    FAIL() << "a frame of another size was taken";
  } catch (const InvalidArgument& error) {
    EXPECT_NE(std::string(error.what()).find("640 x 480"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("320 x 240"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace ssjs
