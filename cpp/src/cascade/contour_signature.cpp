#include "ssjs/cascade/contour_signature.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "ssjs/base/error.hpp"
#include "ssjs/imaging/threshold.hpp"

namespace ssjs {
namespace {

constexpr int kMedian = 9;  // px of kEchoSide

void check_grey(const cv::Mat& picture, const char* name) {
  if (picture.empty() || picture.type() != CV_8UC1)
    throw InvalidArgument(name, cv::typeToString(picture.type()), "must be one 8-bit channel, not empty");
}

std::vector<cv::Point> largest_contour(const cv::Mat& mask) {
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(mask, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  const auto largest = std::max_element(contours.begin(), contours.end(),
                                        [](const auto& a, const auto& b) { return cv::contourArea(a) < cv::contourArea(b); });
  return largest == contours.end() ? std::vector<cv::Point>{} : *largest;
}

}  // namespace

std::optional<ContourSignature> contour_signature(const cv::Mat& mask) {
  check_grey(mask, "mask");
  const std::vector<cv::Point> contour = largest_contour(mask);
  if (contour.size() < 3) return std::nullopt;
  const cv::Moments moments = cv::moments(contour);
  if (!(moments.m00 > 0)) return std::nullopt;
  const cv::Point2d centroid(moments.m10 / moments.m00, moments.m01 / moments.m00);

  // (C-19): corners of the boundary, at their distance along it
  std::vector<double> along = {0};
  for (std::size_t i = 0; i < contour.size(); ++i)
    along.push_back(along.back() + cv::norm(cv::Point2d(contour[(i + 1) % contour.size()] - contour[i])));
  ContourSignature signature;
  std::size_t edge = 0;
  for (std::size_t k = 0; k < ContourSignature::kSamples; ++k) {
    const double at = along.back() * static_cast<double>(k) / ContourSignature::kSamples;
    while (along[edge + 1] <= at) ++edge;
    const double share = (at - along[edge]) / (along[edge + 1] - along[edge]);
    const cv::Point2d from = contour[edge];
    const cv::Point2d to = contour[(edge + 1) % contour.size()];
    signature.distance[k] = cv::norm(from + share * (to - from) - centroid);
  }
  const double mean = std::accumulate(signature.distance.begin(), signature.distance.end(), 0.0) / ContourSignature::kSamples;
  for (double& distance : signature.distance) distance /= mean;

  // (C-20)
  for (std::size_t h = 0; h < kContourHarmonics; ++h) {
    double cosine = 0;
    double sine = 0;
    for (std::size_t k = 0; k < ContourSignature::kSamples; ++k) {
      const double angle = 2 * CV_PI * static_cast<double>((h + 1) * k) / ContourSignature::kSamples;
      cosine += signature.distance[k] * std::cos(angle);
      sine += signature.distance[k] * std::sin(angle);
    }
    signature.spectrum[h] = std::hypot(cosine, sine) / ContourSignature::kSamples;
  }
  return signature;
}

std::optional<cv::Mat> echo_mask(const SonarImage& image, const cv::Rect& box) {
  check_sonar_image(image);
  check_grey(image.intensity, "image");
  if (box.area() <= 0 || (box & cv::Rect({0, 0}, image.intensity.size())) != box)
    throw InvalidArgument("box", std::to_string(box.width) + " x " + std::to_string(box.height), "must lie in the picture");
  // (C-21): the same size whatever the scale, so that filter and pixel grid do the same to all
  const double scale = static_cast<double>(kEchoSide) / std::max(box.width, box.height);
  const cv::Size size(std::max(1, cvRound(box.width * scale)), std::max(1, cvRound(box.height * scale)));
  SonarImage seen;
  cv::resize(image.intensity(box), seen.intensity, size, 0, 0, scale < 1 ? cv::INTER_AREA : cv::INTER_LINEAR_EXACT);
  if (!image.valid.empty()) cv::resize(image.valid(box), seen.valid, size, 0, 0, cv::INTER_NEAREST);
  cv::medianBlur(seen.intensity, seen.intensity, kMedian);
  const std::optional<int> threshold = otsu_threshold(histogram(seen));
  if (!threshold) return std::nullopt;
  return foreground(seen, *threshold);
}

std::optional<ContourSignature> echo_signature(const SonarImage& image, const cv::Rect& box) {
  const std::optional<cv::Mat> mask = echo_mask(image, box);
  return mask ? contour_signature(*mask) : std::nullopt;
}

}  // namespace ssjs
