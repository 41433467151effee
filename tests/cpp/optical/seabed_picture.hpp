/// A patch of textured seabed, and what a camera above it would show.
#pragma once

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "ssjs/base/random.hpp"
#include "ssjs/optical/matching.hpp"

namespace ssjs {

/// Pebbles of all sizes on smooth ground, CV_8U.
inline cv::Mat seabed_picture(cv::Size size, int pebbles, std::uint64_t seed) {
  Rng rng(seed);
  cv::Mat picture(size, CV_8U, cv::Scalar(110));
  for (int i = 0; i < pebbles; ++i) {
    const cv::Point centre(static_cast<int>(rng.uniform(0, size.width)), static_cast<int>(rng.uniform(0, size.height)));
    const cv::Size axes(2 + static_cast<int>(rng.uniform(0, 9)), 2 + static_cast<int>(rng.uniform(0, 6)));
    cv::ellipse(picture, centre, axes, rng.uniform(0, 180), 0, 360, cv::Scalar(rng.uniform(40, 220)), cv::FILLED, cv::LINE_AA);
  }
  cv::GaussianBlur(picture, picture, cv::Size(), 0.8);
  return picture;
}

/// The view whose pixels are view_T_ground of the ground's, with noise.
inline cv::Mat view_of(const cv::Mat& ground, const Similarity& view_T_ground, cv::Size size, double noise, std::uint64_t seed) {
  const double c = view_T_ground.scale * std::cos(view_T_ground.angle_rad), s = view_T_ground.scale * std::sin(view_T_ground.angle_rad);
  const cv::Matx23d matrix(c, -s, view_T_ground.shift_px.x, s, c, view_T_ground.shift_px.y);
  cv::Mat view;
  cv::warpAffine(ground, view, matrix, size, cv::INTER_LINEAR, cv::BORDER_REFLECT);
  Rng rng(seed);
  for (int r = 0; r < view.rows; ++r) {
    for (int col = 0; col < view.cols; ++col) {
      view.at<unsigned char>(r, col) = cv::saturate_cast<unsigned char>(view.at<unsigned char>(r, col) + rng.normal(noise));
    }
  }
  return view;
}

}  // namespace ssjs
