#include "ssjs/imaging/contours.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "ssjs/base/error.hpp"
#include "ssjs/base/random.hpp"

namespace ssjs {
namespace {

using Points = std::vector<cv::Point>;

cv::Mat random_mask(Rng& rng, int rows, int columns, double probability) {
  cv::Mat mask(rows, columns, CV_8U);
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) mask.at<unsigned char>(r, c) = rng.uniform() < probability ? 255 : 0;
  }
  return mask;
}

cv::Mat speckle(Rng& rng, int rows, int columns) {
  cv::Mat image(rows, columns, CV_8U);
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c)
      image.at<unsigned char>(r, c) = static_cast<unsigned char>(40 + 30 * rng.uniform() + (c > columns / 2 ? 90 : 0));
  }
  return image;
}

bool same(const cv::Mat& a, const cv::Mat& b) { return a.size() == b.size() && cv::countNonZero(a != b) == 0; }

TEST(ContoursTest, MooreTracingByHand) {
  cv::Mat mask = cv::Mat::zeros(6, 7, CV_8U);
  mask.at<unsigned char>(4, 5) = 255;
  EXPECT_EQ(trace_outer_border(mask, {5, 4}), (Points{{5, 4}}));
  mask(cv::Rect(1, 1, 2, 2)) = 255;
  EXPECT_EQ(trace_outer_border(mask, {1, 1}), (Points{{1, 1}, {2, 1}, {2, 2}, {1, 2}}));
  mask(cv::Rect(3, 1, 2, 1)) = 255;  // a tail, walked there and back
  EXPECT_EQ(trace_outer_border(mask, {1, 1}), (Points{{1, 1}, {2, 1}, {3, 1}, {4, 1}, {3, 1}, {2, 2}, {1, 2}}));
  EXPECT_THROW((void)trace_outer_border(mask, {0, 0}), InvalidArgument);
  EXPECT_THROW((void)trace_outer_border(mask, {-1, 0}), InvalidArgument);
}

TEST(ContoursTest, TheFirstPixelMayBePassedOnTheWay) {
  // Two arms from the first pixel: who stops at the first return to it loses the second one.
  const cv::Mat mask = (cv::Mat_<unsigned char>(3, 3) << 0, 1, 0,  //
                        1, 0, 1,                                   //
                        0, 0, 0);
  EXPECT_EQ(trace_outer_border(mask, {1, 0}), (Points{{1, 0}, {2, 1}, {1, 0}, {0, 1}}));
}

TEST(ContoursTest, ARingHasOneContourAndAllItsPixels) {
  cv::Mat mask = cv::Mat::zeros(9, 9, CV_8U);
  cv::rectangle(mask, {1, 1}, {7, 7}, 255);
  mask.at<unsigned char>(4, 4) = 255;
  const std::vector<Contour> contours = outer_contours(mask);
  ASSERT_EQ(contours.size(), 2U);
  EXPECT_EQ(contours[0].border.size(), 24U);
  EXPECT_EQ(contours[0].component_px, 24);
  EXPECT_EQ(contours[1].border, (Points{{4, 4}}));
  // O-9
  EXPECT_EQ(count_small_contours(mask, 1), 0);
  EXPECT_EQ(count_small_contours(mask, 24), 1);
  EXPECT_EQ(count_small_contours(mask, 25), 2);
}

bool earlier(const cv::Point& a, const cv::Point& b) { return a.y != b.y ? a.y < b.y : a.x < b.x; }

TEST(ContoursTest, BordersAreThoseOfOpenCv) {
  Rng rng(1);
  for (const double probability : {0.05, 0.2, 0.4, 0.6, 0.9}) {
    const cv::Mat mask = random_mask(rng, 47, 61, probability);
    std::vector<Points> reference;
    std::vector<cv::Vec4i> hierarchy;
    cv::findContours(mask, reference, hierarchy, cv::RETR_CCOMP, cv::CHAIN_APPROX_NONE);
    std::vector<Points> expected, found;
    for (std::size_t i = 0; i < reference.size(); ++i) {
      if (hierarchy[i][3] < 0) expected.push_back(reference[i]);  // without the holes'
    }
    for (const Contour& contour : outer_contours(mask)) {
      found.push_back(contour.border);
    }
    for (auto* contours : {&expected, &found}) {
      for (Points& points : *contours) std::sort(points.begin(), points.end(), earlier);
      std::sort(contours->begin(), contours->end(), [](const Points& a, const Points& b) { return earlier(a.front(), b.front()); });
    }
    EXPECT_EQ(found, expected) << probability;
  }
}

TEST(ContoursTest, SmallContoursAreCountedAsTheyAreTraced) {
  Rng rng(2);
  for (const double probability : {0.01, 0.1, 0.3, 0.5}) {
    const cv::Mat mask = random_mask(rng, 64, 80, probability);
    for (const int area_px : {1, 2, 5, 30}) {
      std::int64_t small = 0;
      for (const Contour& contour : outer_contours(mask)) small += contour.component_px < area_px ? 1 : 0;
      EXPECT_EQ(count_small_contours(mask, area_px), small);
      EXPECT_EQ(count_small_contours(mask.t(), area_px), small);
    }
  }
  EXPECT_EQ(count_small_contours(cv::Mat::zeros(5, 5, CV_8U), 30), 0);
}

TEST(ContoursTest, O8_AStepIsALineAndWeakStepsNeedAStrongOne) {
  cv::Mat image = cv::Mat::zeros(12, 40, CV_8U);
  image.colRange(10, 40) = 100;
  image.colRange(30, 40) = 130;  // 30 levels against 100
  const cv::Mat strong = canny_edges({image, {}}, 0.33);
  EXPECT_EQ(cv::countNonZero(strong), 12);
  EXPECT_EQ(cv::countNonZero(strong.colRange(9, 11)), 12);
  const cv::Mat both = canny_edges({image, {}}, 0.25);
  EXPECT_EQ(cv::countNonZero(both), 24);
  EXPECT_EQ(cv::countNonZero(both.colRange(29, 31)), 12);
}

TEST(ContoursTest, O8_EdgesAreThoseOfCannyOnTheSmoothedImage) {
  Rng rng(5);
  const cv::Mat image = speckle(rng, 70, 90);
  cv::Mat smoothed, dx, dy, magnitude, expected;
  cv::GaussianBlur(image, smoothed, {3, 3}, 0.5, 0.5, cv::BORDER_REPLICATE);
  cv::Sobel(smoothed, dx, CV_32F, 1, 0, 3, 1, 0, cv::BORDER_REPLICATE);
  cv::Sobel(smoothed, dy, CV_32F, 0, 1, 3, 1, 0, cv::BORDER_REPLICATE);
  cv::magnitude(dx, dy, magnitude);
  double largest = 0;
  cv::minMaxLoc(magnitude, nullptr, &largest);
  for (const double high : {0.1, 0.33, 0.8}) {
    cv::Canny(smoothed, expected, 0.4 * high * largest, high * largest, 3, true);
    EXPECT_GT(cv::countNonZero(expected), 0);
    EXPECT_TRUE(same(canny_edges({image, {}}, high), expected)) << high;
  }
}

TEST(ContoursTest, InvalidPixelsMakeNoEdges) {
  Rng rng(6);
  cv::Mat image = speckle(rng, 60, 80);
  cv::Mat valid = cv::Mat::zeros(60, 80, CV_8U);
  cv::circle(valid, {40, 30}, 25, 1, cv::FILLED);
  const cv::Mat edges = canny_edges({image, valid}, 0.3);
  EXPECT_GT(cv::countNonZero(edges), 0);
  EXPECT_EQ(cv::countNonZero(edges & (valid == 0)), 0);
  for (const int level : {0, 255}) {
    image.setTo(level, valid == 0);
    EXPECT_TRUE(same(canny_edges({image, valid}, 0.3), edges)) << level;
  }
}

TEST(ContoursTest, ThreadsChangeNothing) {
  Rng rng(7);
  const cv::Mat image = speckle(rng, 500, 300);
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const cv::Mat alone = canny_edges({image, {}}, 0.3);
  cv::setNumThreads(4);
  EXPECT_TRUE(same(canny_edges({image, {}}, 0.3), alone));
  cv::setNumThreads(threads);
}

TEST(ContoursTest, ImagesWithoutGradientHaveNoEdges) {
  EXPECT_EQ(cv::countNonZero(canny_edges({cv::Mat(1, 1, CV_8U, cv::Scalar(9)), {}}, 0.3)), 0);
  EXPECT_EQ(cv::countNonZero(canny_edges({cv::Mat(1, 7, CV_8U, cv::Scalar(9)), {}}, 0.0)), 0);
  EXPECT_EQ(cv::countNonZero(canny_edges({cv::Mat(20, 20, CV_16U, cv::Scalar(900)), {}}, 0.3)), 0);
  EXPECT_THROW((void)canny_edges({cv::Mat(5, 5, CV_8U, cv::Scalar(9)), {}}, 1.5), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
