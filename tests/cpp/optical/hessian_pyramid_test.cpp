#include "ssjs/optical/hessian_pyramid.hpp"

#include <dlib/image_keypoint.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "optical/seabed_picture.hpp"

namespace ssjs {
namespace {

std::vector<dlib::interest_point> dlibs(const cv::Mat& picture, double threshold) {
  dlib::array2d<unsigned char> image(picture.rows, picture.cols);
  for (int r = 0; r < picture.rows; ++r) std::copy_n(picture.ptr(r), picture.cols, &image[r][0]);
  dlib::integral_image integral;
  integral.load(image);
  dlib::hessian_pyramid pyramid;
  pyramid.build_pyramid(integral, HessianPyramid::kOctaves, HessianPyramid::kIntervals, HessianPyramid::kFirstStep_px);
  std::vector<dlib::interest_point> found;
  dlib::get_interest_points(pyramid, threshold, found);
  return found;
}

struct Found {
  Blob blob;
  double determinant;
};

std::vector<Found> ours(const cv::Mat& picture, const cv::Rect2d& window, double threshold) {
  IntegralImage integral;
  integral.load(picture);
  HessianPyramid pyramid;
  pyramid.build(integral, window);
  std::vector<Found> found;
  for (const HessianMaximum& maximum : pyramid.maxima(threshold)) {
    if (const std::optional<Blob> blob = pyramid.interpolated(maximum)) found.push_back({*blob, maximum.determinant});
  }
  return found;
}

void expect_same(const dlib::interest_point& expected, const Found& found) {
  EXPECT_EQ(found.blob.position_px.x, expected.center.x());
  EXPECT_EQ(found.blob.position_px.y, expected.center.y());
  EXPECT_EQ(found.blob.scale_px, expected.scale);
  EXPECT_EQ(found.determinant, expected.score);
}

TEST(HessianPyramidTest, V11_TheSameBitsAsDlibs) {
  for (const cv::Size size : {cv::Size(320, 240), cv::Size(333, 217), cv::Size(97, 401)}) {
    const cv::Mat picture = seabed_picture(size, 300, 3);
    const std::vector<dlib::interest_point> expected = dlibs(picture, 3.0);
    const std::vector<Found> found = ours(picture, {0.0, 0.0, size.width * 1.0, size.height * 1.0}, 3.0);
    ASSERT_EQ(found.size(), expected.size());
    ASSERT_GT(found.size(), 30U);
    for (std::size_t i = 0; i < found.size(); ++i) expect_same(expected[i], found[i]);
  }
}

TEST(HessianPyramidTest, V11_AWindowLosesNothingThatLiesInIt) {
  const cv::Mat picture = seabed_picture({320, 240}, 400, 4);
  const std::vector<dlib::interest_point> all = dlibs(picture, 3.0);
  for (const cv::Rect2d& window :
       {cv::Rect2d(60.3, 50.9, 90.0, 70.0), cv::Rect2d(0.0, 0.0, 320.0, 30.0), cv::Rect2d(150.0, 110.0, 1.0, 1.0)}) {
    const auto is_inside = [&](double x, double y) { return window.contains({x, y}); };
    std::vector<dlib::interest_point> expected;
    std::copy_if(all.begin(), all.end(), std::back_inserter(expected),
                 [&](const auto& p) { return is_inside(p.center.x(), p.center.y()); });
    std::vector<Found> found = ours(picture, window, 3.0);
    EXPECT_LT(found.size(), all.size());
    found.erase(
        std::remove_if(found.begin(), found.end(), [&](const Found& f) { return !is_inside(f.blob.position_px.x, f.blob.position_px.y); }),
        found.end());
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) expect_same(expected[i], found[i]);
  }
}

TEST(HessianPyramidTest, FramesSmallerThanEveryFilterHaveNoMaximum) {
  for (int side = 1; side < 40; side += 3)
    EXPECT_TRUE(ours(seabed_picture({side, side}, 3, 1), {0.0, 0.0, side * 1.0, side * 1.0}, 0.0).empty());
}

TEST(IntegralImageTest, SumsOfRectangles) {
  const cv::Mat picture = seabed_picture({31, 22}, 10, 2);
  IntegralImage integral;
  integral.load(picture);
  for (const cv::Rect& r : {cv::Rect(0, 0, 31, 22), cv::Rect(0, 5, 3, 1), cv::Rect(30, 21, 1, 1), cv::Rect(7, 0, 11, 13)}) {
    EXPECT_EQ(integral.get_sum_of_area(dlib::rectangle(r.x, r.y, r.x + r.width - 1, r.y + r.height - 1)),
              std::lround(cv::sum(picture(r))[0]));
  }
}

}  // namespace
}  // namespace ssjs
