#include "ssjs/imaging/regions.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "imaging/drawn_mask.hpp"
#include "ssjs/base/angle.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/base/random.hpp"

namespace ssjs {
namespace {

constexpr double kRounding = 1e-12;

LabelledRegions found(const std::vector<std::string>& rows) {
  const cv::Mat mask = drawn(rows);
  return find_regions(mask, mask);
}

TEST(RegionsTest, R6_AreaCentroidAndBoxByHand) {
  const LabelledRegions regions = found({"..#..",  //
                                         ".##..",  //
                                         "....#",  //
                                         "#....",  //
                                         "#...."});
  ASSERT_EQ(regions.regions.size(), 3u);
  const Region& bent = regions.regions[0];  // (2,0) (1,1) (2,1)
  EXPECT_EQ(bent.area_px, 3);
  EXPECT_NEAR(bent.centroid_px.x, 5.0 / 3.0, kRounding);
  EXPECT_NEAR(bent.centroid_px.y, 2.0 / 3.0, kRounding);
  EXPECT_EQ(bent.bounding_box, cv::Rect(1, 0, 2, 2));
  EXPECT_EQ(regions.regions[1].centroid_px, cv::Point2d(4, 2));
  EXPECT_EQ(regions.regions[2].centroid_px, cv::Point2d(0, 3.5));
  EXPECT_EQ(regions.regions[2].bounding_box, cv::Rect(0, 3, 1, 2));
  const cv::Mat labels = (cv::Mat_<int>(5, 5) << 0, 0, 1, 0, 0,  //
                          0, 1, 1, 0, 0,                         //
                          0, 0, 0, 0, 2,                         //
                          3, 0, 0, 0, 0,                         //
                          3, 0, 0, 0, 0);
  EXPECT_EQ(cv::countNonZero(regions.labels != labels), 0);
}

TEST(RegionsTest, R6_IntensityOfTheRegionAlone) {
  const cv::Mat mask = drawn({"##..", "...#"});
  const cv::Mat narrow = (cv::Mat_<unsigned char>(2, 4) << 10, 21, 255, 255, 255, 255, 255, 7);
  const cv::Mat wide = (cv::Mat_<unsigned short>(2, 4) << 1000, 60000, 1, 1, 1, 1, 1, 65535);
  const LabelledRegions in_8_bits = find_regions(mask, narrow);
  EXPECT_EQ(in_8_bits.regions[0].mean_intensity, 15.5);
  EXPECT_EQ(in_8_bits.regions[0].max_intensity, 21);
  EXPECT_EQ(in_8_bits.regions[1].mean_intensity, 7);
  const LabelledRegions in_16_bits = find_regions(mask, wide);
  EXPECT_EQ(in_16_bits.regions[0].mean_intensity, 30500);
  EXPECT_EQ(in_16_bits.regions[0].max_intensity, 60000);
  EXPECT_EQ(in_16_bits.regions[1].max_intensity, 65535);
}

TEST(RegionsTest, R7_AxesOfARectangleOfSquares) {
  // A rectangle of w x h has variances w^2/12 and h^2/12, so that its axes are 4 w / sqrt(12) and 4 h / sqrt(12).
  cv::Mat mask = cv::Mat::zeros(40, 60, CV_8U);
  mask(cv::Rect(11, 5, 30, 8)) = 1;
  const Region wide = find_regions(mask, mask).regions.at(0);
  EXPECT_NEAR(wide.major_axis_px, 4.0 * 30.0 / std::sqrt(12.0), 1e-10);
  EXPECT_NEAR(wide.minor_axis_px, 4.0 * 8.0 / std::sqrt(12.0), 1e-10);
  EXPECT_EQ(wide.orientation_rad, 0.0);
  const cv::Mat turned = mask.t();
  const Region tall = find_regions(turned, turned).regions.at(0);
  EXPECT_NEAR(tall.major_axis_px, wide.major_axis_px, 1e-10);
  EXPECT_EQ(tall.orientation_rad, 0.5 * kPi);
}

TEST(RegionsTest, R8_OrientationTurnsFromXTowardsY) {
  // three pixels on a diagonal: var x = var y = 2/3 + 1/12, cov = +-2/3, so the axes are 4 sqrt(4/3 + 1/12) and 4 sqrt(1/12)
  const Region falling = found({"#..", ".#.", "..#"}).regions.at(0);
  EXPECT_NEAR(falling.orientation_rad, 0.25 * kPi, kRounding);  // to the right and down
  EXPECT_NEAR(falling.major_axis_px, 4.0 * std::sqrt(17.0 / 12.0), kRounding);
  EXPECT_NEAR(falling.minor_axis_px, 4.0 * std::sqrt(1.0 / 12.0), kRounding);
  const Region rising = found({"..#", ".#.", "#.."}).regions.at(0);
  EXPECT_NEAR(rising.orientation_rad, -0.25 * kPi, kRounding);
}

TEST(RegionsTest, R8_DrawnEllipsesHaveTheirOwnAxesAndOrientation) {
  for (const double angle : {-1.4, -0.6, 0.3, 1.1}) {
    cv::Mat mask = cv::Mat::zeros(300, 300, CV_8U);
    for (int y = 0; y < mask.rows; ++y) {
      for (int x = 0; x < mask.cols; ++x) {
        const double along = (x - 140.3) * std::cos(angle) + (y - 155.8) * std::sin(angle);
        const double across = (y - 155.8) * std::cos(angle) - (x - 140.3) * std::sin(angle);
        if (std::pow(along / 100.0, 2) + std::pow(across / 40.0, 2) <= 1.0) mask.at<unsigned char>(y, x) = 255;
      }
    }
    const Region ellipse = find_regions(mask, mask).regions.at(0);
    // Drawing rounds the outline to pixels, which moves it by less than one; averaged over the outline far less.
    EXPECT_NEAR(ellipse.orientation_rad, angle, 2e-3);
    EXPECT_NEAR(ellipse.major_axis_px, 200.0, 0.5);
    EXPECT_NEAR(ellipse.minor_axis_px, 80.0, 0.5);
    EXPECT_NEAR(ellipse.centroid_px.x, 140.3, 0.1);
    EXPECT_NEAR(ellipse.centroid_px.y, 155.8, 0.1);
    EXPECT_NEAR(static_cast<double>(ellipse.area_px), kPi * 100.0 * 40.0, 60.0);
  }
}

TEST(RegionsTest, AFullImageIsOneRegion) {
  const cv::Mat mask(7, 12, CV_8U, cv::Scalar(1));
  const LabelledRegions regions = find_regions(mask, mask);
  ASSERT_EQ(regions.regions.size(), 1u);
  EXPECT_EQ(regions.regions[0].area_px, 84);
  EXPECT_EQ(regions.regions[0].bounding_box, cv::Rect(0, 0, 12, 7));
  EXPECT_EQ(regions.regions[0].centroid_px, cv::Point2d(5.5, 3));
}

TEST(RegionsTest, OnePixelIsASquare) {
  const Region pixel = found({"#"}).regions.at(0);
  EXPECT_EQ(pixel.area_px, 1);
  EXPECT_EQ(pixel.centroid_px, cv::Point2d(0, 0));
  EXPECT_NEAR(pixel.major_axis_px, 2.0 / std::sqrt(3.0), kRounding);
  EXPECT_EQ(pixel.major_axis_px, pixel.minor_axis_px);
  EXPECT_EQ(pixel.orientation_rad, 0);
}

TEST(RegionsTest, NothingSetGivesNoRegions) {
  EXPECT_TRUE(found({"..", ".."}).regions.empty());
  EXPECT_TRUE(find_regions(cv::Mat(), cv::Mat()).regions.empty());
  EXPECT_TRUE(group_regions(find_regions(cv::Mat(), cv::Mat()), 5, CentroidWeighting::kRegions).empty());
  EXPECT_TRUE(group_regions(found({"..", ".."}), 5, CentroidWeighting::kRegions).empty());
}

TEST(RegionsTest, R10_ThePapersShipwreckAndMannequin) {
  // [yuan2016] sections 3.4.1 and 3.5: the mean of two centroids is (538.7, 628.5), that of five (1005.5, 690.7).
  const auto mean_of = [](const std::vector<cv::Point2d>& centroids) {
    LabelledRegions labelled{cv::Mat::zeros(1, 2 * static_cast<int>(centroids.size()), CV_32S), {}};
    for (std::size_t i = 0; i < centroids.size(); ++i) {
      labelled.labels.at<int>(0, 2 * static_cast<int>(i)) = static_cast<int>(i) + 1;
      Region region;
      region.label = static_cast<int>(i) + 1;
      region.area_px = 1;
      region.centroid_px = centroids[i];
      labelled.regions.push_back(region);
    }
    const std::vector<RegionObject> objects = group_regions(labelled, 3, CentroidWeighting::kRegions);
    EXPECT_EQ(objects.size(), 1u);
    return objects.at(0).centroid_px;
  };
  const double half_a_digit = 0.05 + 1e-9;
  const cv::Point2d ship = mean_of({{535, 603}, {542.3, 653.9}});
  EXPECT_NEAR(ship.x, 538.7, half_a_digit);
  EXPECT_NEAR(ship.y, 628.5, half_a_digit);
  const cv::Point2d body = mean_of({{949.8, 662.9}, {966.9, 660.6}, {1021.2, 615.7}, {1024.1, 703}, {1065.5, 811.3}});
  EXPECT_NEAR(body.x, 1005.5, half_a_digit);
  EXPECT_NEAR(body.y, 690.7, half_a_digit);
}

TEST(RegionsTest, R10_WeightedWithAreasTheCentroidIsThatOfAllPixels) {
  const LabelledRegions regions = found({"###..#"});
  const std::vector<RegionObject> plain = group_regions(regions, 4, CentroidWeighting::kRegions);
  const std::vector<RegionObject> weighted = group_regions(regions, 4, CentroidWeighting::kArea);
  ASSERT_EQ(plain.size(), 1u);
  EXPECT_EQ(plain[0].centroid_px.x, 3.0);     // (1 + 5) / 2
  EXPECT_EQ(weighted[0].centroid_px.x, 2.0);  // (0 + 1 + 2 + 5) / 4
  EXPECT_EQ(weighted[0].area_px, 4);
  EXPECT_EQ(weighted[0].bounding_box, cv::Rect(0, 0, 6, 1));
  EXPECT_EQ(weighted[0].labels, (std::vector<int>{1, 2}));
}

TEST(RegionsTest, R9_NearerThanTheGap) {
  // nearest pixels (2, 0) and (5, 4): a distance of 5
  const LabelledRegions regions = found({"###...",  //
                                         "......",  //
                                         "......",  //
                                         "......",  //
                                         ".....#"});
  EXPECT_EQ(group_regions(regions, 5.0, CentroidWeighting::kRegions).size(), 2u);
  EXPECT_EQ(group_regions(regions, 5.001, CentroidWeighting::kRegions).size(), 1u);
  EXPECT_EQ(group_regions(regions, 0, CentroidWeighting::kRegions).size(), 2u);
  EXPECT_EQ(group_regions(regions, std::numeric_limits<double>::infinity(), CentroidWeighting::kRegions).size(), 1u);
}

TEST(RegionsTest, R9_ARegionInsideAnotherIsJudgedByPixelsNotByBoxes) {
  const LabelledRegions regions = found({"#########",  //
                                         "#.......#",  //
                                         "#.......#",  //
                                         "#...#...#",  //
                                         "#.......#",  //
                                         "#.......#",  //
                                         "#########"});
  EXPECT_EQ(group_regions(regions, 3.0, CentroidWeighting::kRegions).size(), 2u);
  EXPECT_EQ(group_regions(regions, 3.1, CentroidWeighting::kRegions).size(), 1u);
}

TEST(RegionsTest, R9_SpeckleAgreesWithAllPairsOfPixels) {
  Rng rng(29);
  for (int trial = 0; trial < 60; ++trial) {
    cv::Mat mask = cv::Mat::zeros(23, 31, CV_8U);
    const double density = rng.uniform(0.01, 0.25);
    std::vector<cv::Point> pixels;
    for (int y = 0; y < mask.rows; ++y) {
      for (int x = 0; x < mask.cols; ++x) {
        if (rng.uniform(0, 1) >= density) continue;
        mask.at<unsigned char>(y, x) = 1;
        pixels.emplace_back(x, y);
      }
    }
    const LabelledRegions regions = find_regions(mask, mask);
    for (const double gap_px : {2.0, 2.3, 3.0, 4.5, 7.0, 100.0}) {
      std::vector<int> object(regions.regions.size() + 1);
      for (std::size_t i = 0; i < object.size(); ++i) object[i] = static_cast<int>(i);
      for (const cv::Point& a : pixels) {
        for (const cv::Point& b : pixels) {
          if (!(std::hypot(a.x - b.x, a.y - b.y) < gap_px)) continue;
          const int kept = object[static_cast<std::size_t>(regions.labels.at<int>(a))];
          const int lost = object[static_cast<std::size_t>(regions.labels.at<int>(b))];
          if (kept != lost) std::replace(object.begin(), object.end(), std::max(kept, lost), std::min(kept, lost));
        }
      }
      for (const RegionObject& grouped : group_regions(regions, gap_px, CentroidWeighting::kArea)) {
        for (const int label : grouped.labels) EXPECT_EQ(object[static_cast<std::size_t>(label)], grouped.labels[0]);
        EXPECT_EQ(static_cast<long>(grouped.labels.size()), std::count(object.begin() + 1, object.end(), grouped.labels[0])) << gap_px;
      }
    }
  }
}

TEST(RegionsTest, WhatDoesNotFitIsRefused) {
  const cv::Mat mask = cv::Mat::zeros(3, 4, CV_8U);
  EXPECT_THROW(static_cast<void>(find_regions(cv::Mat::zeros(3, 4, CV_32F), mask)), InvalidArgument);
  EXPECT_THROW(static_cast<void>(find_regions(mask, cv::Mat::zeros(4, 3, CV_8U))), InvalidArgument);
  EXPECT_THROW(static_cast<void>(find_regions(mask, cv::Mat::zeros(3, 4, CV_32F))), InvalidArgument);
  const LabelledRegions none{cv::Mat::zeros(3, 4, CV_32S), {}};
  EXPECT_THROW(static_cast<void>(group_regions(none, -1, CentroidWeighting::kArea)), InvalidArgument);
  EXPECT_THROW(static_cast<void>(group_regions(none, std::nan(""), CentroidWeighting::kArea)), InvalidArgument);
  EXPECT_THROW(static_cast<void>(group_regions({cv::Mat(3, 4, CV_32S, cv::Scalar(1)), {}}, 1, CentroidWeighting::kArea)), InvalidArgument);
  EXPECT_THROW(static_cast<void>(group_regions({mask, {}}, 1, CentroidWeighting::kArea)), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
