#include "ssjs/optical/mosaic.hpp"

#include <gtest/gtest.h>

#include "optical/seabed_picture.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

const cv::Size kFrame(160, 120);

/// The map is the ground's picture turned upright: x = column, y = 300 - row, both of the ground.
cv::Matx33d map_H_ground() { return {1, 0, 0, 0, -1, 300, 0, 0, 1}; }

struct Views {
  cv::Mat ground = seabed_picture({400, 300}, 900, 3);
  std::vector<cv::Mat> frames;
  std::vector<cv::Matx33d> placed;

  Views() {
    for (int i = 0; i < 12; ++i) {
      const double angle = 0.1 * (i % 3 - 1), scale = 1.0 + 0.05 * (i % 2);
      const cv::Point2d middle(90.0 + 70.0 * (i % 4), 80.0 + 65.0 * (i / 4));
      Similarity view_T_ground{scale, angle, {}};
      view_T_ground.shift_px = cv::Point2d(79.5, 59.5) - view_T_ground * middle;
      frames.push_back(view_of(ground, view_T_ground, kFrame, 0.0, 1));
      placed.push_back(map_H_ground() * matrix_of(view_T_ground).inv());
    }
  }
};

TEST(MosaicTest, V22_TheWindowHoldsEveryFrameAndKeepsToItsLimits) {
  const std::vector<cv::Matx33d> placed{cv::Matx33d::eye(), cv::Matx33d(1, 0, 1000, 0, 1, 500, 0, 0, 1)};
  const MosaicWindow window = mosaic_window(placed, kFrame, {});
  EXPECT_NEAR(window.left, -0.5, 1e-9);
  EXPECT_NEAR(window.bottom, -0.5, 1e-9);
  EXPECT_NEAR(window.pixel_length, 1.0, 1e-9);
  EXPECT_EQ(window.size_px, cv::Size(1160, 620));
  MosaicConfig small;
  small.max_megapixels = 0.1;
  const MosaicWindow reduced = mosaic_window(placed, kFrame, small);
  EXPECT_LE(reduced.size_px.area(), 100000);
  EXPECT_GT(reduced.size_px.area(), 90000);
  small.max_megapixels = 6.0;
  small.max_side_px = 100;
  EXPECT_LE(mosaic_window(placed, kFrame, small).size_px.width, 100);
  EXPECT_THROW((void)mosaic_window({}, kFrame, {}), InvalidArgument);
  EXPECT_THROW((void)mosaic_window({cv::Matx33d(1, 0, 0, 0, 1, 0, -0.01, 0, 1)}, kFrame, {}), InvalidArgument);  // horizon at u = 100
}

TEST(MosaicTest, V24_FramesPutBackGiveTheGround) {
  const Views views;
  const MosaicWindow window = mosaic_window(views.placed, kFrame, {});
  MosaicCanvas canvas(window, 1, {});
  for (std::size_t i = 0; i < views.frames.size(); ++i) canvas.add(views.frames[i], views.placed[i]);
  const cv::Mat picture = canvas.picture(), seen = canvas.seen();
  double error = 0.0, count = 0.0;
  for (int row = 0; row < picture.rows; ++row) {
    for (int column = 0; column < picture.cols; ++column) {
      const double x = window.left + (column + 0.5) * window.pixel_length;
      const double y = window.bottom + (picture.rows - row - 0.5) * window.pixel_length;
      const cv::Point at(cvRound(x), cvRound(300.0 - y));
      if (seen.at<unsigned char>(row, column) == 0 || !cv::Rect(2, 2, 396, 296).contains(at)) continue;
      error += std::abs(picture.at<unsigned char>(row, column) - views.ground.at<unsigned char>(at));
      count += 1.0;
    }
  }
  EXPECT_GT(count, 0.6 * 400 * 300);
  EXPECT_LT(error / count, 6.0);  // of 255: half-pixel resampling of pebbles whose levels differ by 30 and more
  cv::Mat flipped;
  cv::flip(picture, flipped, 0);
  EXPECT_GT(cv::norm(picture, flipped, cv::NORM_L1) / static_cast<double>(picture.total()), 15.0);  // upside down it would not fit
}

TEST(MosaicTest, V24_TheFrameSeenFromNearerItsMiddleCounts) {
  const cv::Mat dark(kFrame, CV_8U, cv::Scalar(40)), bright(kFrame, CV_8U, cv::Scalar(200));
  const std::vector<cv::Matx33d> placed{cv::Matx33d::eye(), cv::Matx33d(1, 0, 80, 0, 1, 0, 0, 0, 1)};
  MosaicCanvas canvas(mosaic_window(placed, kFrame, {}), 1, {});
  canvas.add(dark, placed[0]);
  canvas.add(bright, placed[1]);
  const cv::Mat picture = canvas.picture();
  EXPECT_EQ(picture.at<unsigned char>(60, 40), 40);
  EXPECT_EQ(picture.at<unsigned char>(60, 200), 200);
  EXPECT_NEAR(0.5 * (picture.at<unsigned char>(60, 119) + picture.at<unsigned char>(60, 120)), 120.0, 1.0);  // between their middles
  EXPECT_LT(picture.at<unsigned char>(60, 105), 80);
  EXPECT_GT(picture.at<unsigned char>(60, 135), 160);
}

TEST(MosaicTest, WhatIsNotValidIsNotDrawn) {
  cv::Mat valid(kFrame, CV_8U, cv::Scalar(255));
  valid(cv::Rect(0, 0, 80, 120)).setTo(0);
  MosaicCanvas canvas({-0.5, -0.5, 1.0, kFrame}, 3, {});
  canvas.add(cv::Mat(kFrame, CV_8UC3, cv::Scalar(10, 20, 30)), cv::Matx33d::eye(), valid);
  EXPECT_EQ(canvas.seen().at<unsigned char>(60, 40), 0);
  EXPECT_EQ(canvas.seen().at<unsigned char>(60, 120), 255);
  EXPECT_EQ(canvas.picture().at<cv::Vec3b>(60, 120), cv::Vec3b(10, 20, 30));
  EXPECT_THROW(canvas.add(cv::Mat(kFrame, CV_8U, cv::Scalar(1)), cv::Matx33d::eye()), InvalidArgument);
  canvas.add(cv::Mat(kFrame, CV_8UC3, cv::Scalar(10, 20, 30)), cv::Matx33d(1, 0, 5000, 0, 1, 0, 0, 0, 1));  // beside the canvas
}

TEST(MosaicTest, V23_LampsAreTakenOutGroundStays) {
  const cv::Mat ground = seabed_picture({900, 700}, 3000, 9);
  LampLight light{MosaicConfig{}};
  std::vector<cv::Mat> frames;
  for (int i = 0; i < 30; ++i) {
    cv::Mat frame = ground(cv::Rect(20 * i, 15 * (i % 7), 160, 120)).clone();
    for (int r = 0; r < frame.rows; ++r) {
      for (int c = 0; c < frame.cols; ++c) {  // a lamp at the left: down to 0.4 at the right
        frame.at<unsigned char>(r, c) = cv::saturate_cast<unsigned char>(frame.at<unsigned char>(r, c) * (1.0 - 0.6 * c / 160.0));
      }
    }
    light.learn(frame);
    frames.push_back(frame);
  }
  double left = 0.0, right = 0.0;
  for (const cv::Mat& frame : frames) {
    const cv::Mat evened = light.evened(frame);
    left += cv::mean(evened(cv::Rect(0, 0, 50, 120)))[0] / 30.0;
    right += cv::mean(evened(cv::Rect(110, 0, 50, 120)))[0] / 30.0;
  }
  EXPECT_NEAR(right / left, 1.0, 0.1);  // as taken it is 0.58
  EXPECT_THROW(light.learn(cv::Mat(10, 10, CV_8U, cv::Scalar(1))), InvalidArgument);
  EXPECT_THROW((void)LampLight(MosaicConfig{}).evened(frames[0]), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
