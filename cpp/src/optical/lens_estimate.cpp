#include "ssjs/optical/lens_estimate.hpp"

#include <algorithm>
#include <cmath>

#include "ssjs/base/error.hpp"
#include "ssjs/optical/matching.hpp"

namespace ssjs {
namespace {

constexpr std::size_t kLeastMatches = 25;
constexpr double kMaxRadial = 0.25;  // k1, at the left and right border: the lens of -1/3 folds there
constexpr int kCoarseSteps = 10;     // to either side of no lens, before the search closes in
constexpr double kGolden = 0.6180339887498949;
constexpr double kFinest = 1e-4;  // 0.03 px at the border of a frame of 576

CameraCalibration lens_of(cv::Size frame, double k1) {
  CameraCalibration calibration;
  const double focal = 0.5 * frame.width;
  calibration.camera = {frame.width, frame.height, focal, focal, 0.5 * (frame.width - 1), 0.5 * (frame.height - 1)};
  calibration.lens = LensModel::kBrown;
  calibration.distortion[0] = k1;
  return calibration;
}

std::vector<cv::Point2d> straightened(const CameraCalibration& lens, const std::vector<cv::Point2d>& seen) {
  std::vector<cv::Point2d> ideal;
  ideal.reserve(seen.size());
  for (const cv::Point2d& p : seen) ideal.push_back(undistorted(lens, p));
  return ideal;
}

/// Mean over all matches of the squared error as seen, none above the tolerance.
double cost_of(const std::vector<const MatchedPixels*>& pairs, const CameraCalibration& lens, double tolerance_px) {
  double sum = 0.0, count = 0.0;
  for (const MatchedPixels* pair : pairs) {
    const std::vector<cv::Point2d> first = straightened(lens, pair->first_px);
    const auto H = fit_homography(first, straightened(lens, pair->second_px));
    for (std::size_t i = 0; i < first.size(); ++i) {
      const double error = H ? cv::norm(distorted(lens, transformed(*H, first[i])) - pair->second_px[i]) : tolerance_px;
      sum += error < tolerance_px ? error * error : tolerance_px * tolerance_px;
      count += 1.0;
    }
  }
  return sum / count;
}

}  // namespace

std::optional<LensEstimate> estimate_lens(const std::vector<MatchedPixels>& pairs, cv::Size frame, double tolerance_px, int least_pairs) {
  if (frame.width < 2 || frame.height < 2) throw InvalidArgument("frame", frame.width, "must be a frame's size");
  std::vector<const MatchedPixels*> used;
  for (const MatchedPixels& pair : pairs) {
    if (pair.first_px.size() != pair.second_px.size()) {
      throw InvalidArgument("second_px", static_cast<int>(pair.second_px.size()), "must be as many as in the first");
    }
    if (pair.first_px.size() >= kLeastMatches) used.push_back(&pair);
  }
  if (static_cast<int>(used.size()) < std::max(least_pairs, 1)) return std::nullopt;

  const auto cost = [&](double k1) { return cost_of(used, lens_of(frame, k1), tolerance_px); };
  double best = 0.0;
  const double before = cost(0.0);
  double least = before;
  for (int step = -kCoarseSteps; step <= kCoarseSteps; ++step) {
    const double k1 = kMaxRadial * step / kCoarseSteps, here = cost(k1);
    if (here < least) {
      least = here;
      best = k1;
    }
  }
  double low = best - kMaxRadial / kCoarseSteps, high = best + kMaxRadial / kCoarseSteps;
  double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
  double cost_a = cost(a), cost_b = cost(b);
  while (high - low > kFinest) {  // golden section: (V-15)
    if (cost_a < cost_b) {
      high = b;
      b = a;
      cost_b = cost_a;
      a = high - kGolden * (high - low);
      cost_a = cost(a);
    } else {
      low = a;
      a = b;
      cost_a = cost_b;
      b = low + kGolden * (high - low);
      cost_b = cost(b);
    }
  }
  const double k1 = 0.5 * (low + high), after = cost(k1);
  if (!(after < before)) return std::nullopt;
  return LensEstimate{lens_of(frame, k1), std::sqrt(before), std::sqrt(after)};
}

}  // namespace ssjs
