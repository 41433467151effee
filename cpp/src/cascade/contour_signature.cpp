#include "ssjs/cascade/contour_signature.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

constexpr double kLeastDeviation = 0.002;  // of a harmonic, part of the mean distance: what the pixel grid alone does to it

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
  for (std::size_t h = 0; h < ContourSignature::kHarmonics; ++h) {
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

cv::Mat highlight_mask(const cv::Mat& picture) {
  check_grey(picture, "picture");
  cv::Mat smooth;
  cv::medianBlur(picture, smooth, 3);
  cv::Mat mask;
  cv::threshold(smooth, mask, 0, 255, cv::THRESH_BINARY | cv::THRESH_OTSU);
  return mask;
}

SignatureModel learn_signature(const std::vector<ContourSignature>& objects) {
  if (objects.size() < 2) throw InvalidArgument("signatures", static_cast<double>(objects.size()), "at least two are needed");
  SignatureModel model;
  const auto count = static_cast<double>(objects.size());
  for (std::size_t h = 0; h < ContourSignature::kHarmonics; ++h) {
    for (const ContourSignature& object : objects) model.mean[h] += object.spectrum[h] / count;
    double squares = 0;
    for (const ContourSignature& object : objects) squares += std::pow(object.spectrum[h] - model.mean[h], 2);
    model.deviation[h] = std::max(kLeastDeviation, std::sqrt(squares / (count - 1)));
  }
  return model;
}

double unlikeness(const ContourSignature& signature, const SignatureModel& model) {
  double squares = 0;
  for (std::size_t h = 0; h < ContourSignature::kHarmonics; ++h)
    squares += std::pow((signature.spectrum[h] - model.mean[h]) / model.deviation[h], 2);
  return std::sqrt(squares / ContourSignature::kHarmonics);
}

}  // namespace ssjs
