#include "ssjs/imaging/ground_truth.hpp"

#include <gtest/gtest.h>

#include "imaging/drawn_mask.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

TEST(GroundTruthTest, ComponentsOfAMaskAreObjects) {
  const GroundTruth truth = truth_of_mask(drawn({"##...",  //
                                                 "##...",  //
                                                 "...##"}));
  ASSERT_EQ(truth.objects.size(), 2u);
  EXPECT_FALSE(truth.is_boxes);
  EXPECT_EQ(truth.size, cv::Size(5, 3));
  EXPECT_EQ(truth.objects[0].area_px, 4);
  EXPECT_EQ(truth.objects[0].centroid_px, cv::Point2d(0.5, 0.5));
  EXPECT_EQ(truth.objects[1].centroid_px, cv::Point2d(3.5, 2));
  EXPECT_EQ(truth.objects[1].bounding_box, cv::Rect(3, 2, 2, 1));
}

TEST(GroundTruthTest, LabelsAreObjectsEvenInPieces) {
  const cv::Mat labels = (cv::Mat_<int>(2, 5) << 7, 7, 0, 0, 7, 2, 7, 0, 0, 0);
  for (const int type : {CV_8U, CV_16U, CV_32S}) {
    cv::Mat typed;
    labels.convertTo(typed, type);
    const GroundTruth truth = truth_of_labels(typed);
    ASSERT_EQ(truth.objects.size(), 2u);
    EXPECT_EQ(truth.objects[0].area_px, 1);  // label 2
    EXPECT_EQ(truth.objects[0].centroid_px, cv::Point2d(0, 1));
    EXPECT_EQ(truth.objects[1].area_px, 4);  // label 7: (0,0) (1,0) (4,0) (1,1)
    EXPECT_EQ(truth.objects[1].centroid_px, cv::Point2d(1.5, 0.25));
    EXPECT_EQ(truth.objects[1].bounding_box, cv::Rect(0, 0, 5, 2));
  }
}

TEST(GroundTruthTest, BoxesAreClipped) {
  const GroundTruth truth = truth_of_boxes({10, 5}, {{-3, -3, 5, 5}, {8, 1, 100, 2}});
  EXPECT_TRUE(truth.is_boxes);
  ASSERT_EQ(truth.objects.size(), 2u);
  EXPECT_EQ(truth.objects[0].bounding_box, cv::Rect(0, 0, 2, 2));
  EXPECT_EQ(truth.objects[1].bounding_box, cv::Rect(8, 1, 2, 2));
  EXPECT_EQ(truth.objects[1].area_px, 4);
  EXPECT_EQ(truth.objects[1].centroid_px, cv::Point2d(8.5, 1.5));
}

TEST(GroundTruthTest, NoObjectsIsATruthToo) {
  EXPECT_TRUE(truth_of_mask(cv::Mat::zeros(3, 3, CV_8U)).objects.empty());
  EXPECT_TRUE(truth_of_labels(cv::Mat::zeros(3, 3, CV_32S)).objects.empty());
  EXPECT_TRUE(truth_of_labels(cv::Mat()).objects.empty());
  EXPECT_TRUE(truth_of_boxes({3, 3}, {}).objects.empty());
}

TEST(GroundTruthTest, WhatIsNoTruthIsRefused) {
  EXPECT_THROW(static_cast<void>(truth_of_labels(cv::Mat(2, 2, CV_32S, cv::Scalar(-1)))), InvalidArgument);
  EXPECT_THROW(static_cast<void>(truth_of_labels(cv::Mat(2, 2, CV_32F, cv::Scalar(1)))), InvalidArgument);
  EXPECT_THROW(static_cast<void>(truth_of_labels(cv::Mat(2, 2, CV_8UC3, cv::Scalar(1)))), InvalidArgument);
  EXPECT_THROW(static_cast<void>(truth_of_boxes({3, 3}, {{3, 0, 2, 2}})), InvalidArgument);
  EXPECT_THROW(static_cast<void>(truth_of_boxes({3, 3}, {{1, 1, 0, 2}})), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
