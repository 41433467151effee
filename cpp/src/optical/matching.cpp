#include "ssjs/optical/matching.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core/hal/hal.hpp>
#include <opencv2/imgproc.hpp>

#include "ssjs/base/error.hpp"
#include "ssjs/base/random.hpp"

namespace ssjs {
namespace {

constexpr std::size_t kAffineInliers = 10;      // below, six numbers are more than the matches carry
constexpr std::size_t kHomographyInliers = 25;  // ... and eight
constexpr int kRefinements = 5;

struct Nearest {
  int index = -1;
  double distance = std::numeric_limits<double>::infinity();
  double next = std::numeric_limits<double>::infinity();

  void offer(int candidate, double distance_to_it) {
    if (distance_to_it < distance) {
      next = distance;
      distance = distance_to_it;
      index = candidate;
    } else if (distance_to_it < next) {
      next = distance_to_it;
    }
  }
};

/// Squared for floats; as bits differ it is the square of a distance too.
double squared_distance(const cv::Mat& a, int row_a, const cv::Mat& b, int row_b) {
  if (a.depth() == CV_8U) return cv::hal::normHamming(a.ptr(row_a), b.ptr(row_b), a.cols);
  return cv::hal::normL2Sqr_(a.ptr<float>(row_a), b.ptr<float>(row_b), a.cols);
}

struct Pairs {
  std::vector<cv::Point2d> first, second;
};

Pairs pairs_of(const Keypoints& first, const Keypoints& second, const std::vector<KeypointMatch>& matches) {
  Pairs pairs;
  for (const KeypointMatch& match : matches) {
    pairs.first.push_back(first.points[static_cast<std::size_t>(match.first)].position_px);
    pairs.second.push_back(second.points[static_cast<std::size_t>(match.second)].position_px);
  }
  return pairs;
}

template <class Motion>
std::vector<std::size_t> agreeing(const Pairs& pairs, const Motion& motion, double tolerance_px) {
  std::vector<std::size_t> inliers;
  for (std::size_t i = 0; i < pairs.first.size(); ++i) {
    if (cv::norm(motion * pairs.first[i] - pairs.second[i]) <= tolerance_px) inliers.push_back(i);
  }
  return inliers;
}

Pairs chosen(const Pairs& pairs, const std::vector<std::size_t>& indices) {
  Pairs some;
  for (const std::size_t i : indices) {
    some.first.push_back(pairs.first[i]);
    some.second.push_back(pairs.second[i]);
  }
  return some;
}

/// What an operator* takes a point through.
struct Mapping {
  cv::Matx33d H;
};
cv::Point2d operator*(const Mapping& mapping, cv::Point2d p) { return transformed(mapping.H, p); }

/// The richest map that so many matches carry; none where they do not determine it.
std::optional<cv::Matx33d> fit_mapping(const Pairs& pairs) {
  if (pairs.first.size() >= kHomographyInliers) return fit_homography(pairs.first, pairs.second);
  if (pairs.first.size() >= kAffineInliers) return fit_affine(pairs.first, pairs.second);
  return std::nullopt;
}

/// Matches that agree once the tilt of the camera is taken up: fitted and gathered in turn, as long as they become more. (V-14)
std::optional<cv::Matx33d> grow(const Pairs& pairs, std::vector<std::size_t>& inliers, double tolerance_px) {
  std::optional<cv::Matx33d> best = fit_mapping(chosen(pairs, inliers));
  for (int step = 0; best && step < kRefinements; ++step) {
    std::vector<std::size_t> now = agreeing(pairs, Mapping{*best}, tolerance_px);
    if (now.size() <= inliers.size()) break;
    const std::optional<cv::Matx33d> next = fit_mapping(chosen(pairs, now));
    if (!next) break;
    inliers = std::move(now);
    best = next;
  }
  return best;
}

}  // namespace

cv::Point2d transformed(const cv::Matx33d& second_H_first, cv::Point2d first_px) {
  const cv::Vec3d q = second_H_first * cv::Vec3d(first_px.x, first_px.y, 1.0);
  return {q[0] / q[2], q[1] / q[2]};
}

cv::Matx33d matrix_of(const Similarity& motion) {
  const double c = motion.scale * std::cos(motion.angle_rad), s = motion.scale * std::sin(motion.angle_rad);
  return {c, -s, motion.shift_px.x, s, c, motion.shift_px.y, 0, 0, 1};
}

std::optional<cv::Matx33d> fit_affine(const std::vector<cv::Point2d>& first_px, const std::vector<cv::Point2d>& second_px) {
  cv::Point2d middle;  // of the first: keeps the normal equations well conditioned
  for (const cv::Point2d& p : first_px) middle += p / static_cast<double>(first_px.size());
  cv::Matx33d N = cv::Matx33d::zeros();
  cv::Matx32d b = cv::Matx32d::zeros();
  for (std::size_t i = 0; i < first_px.size(); ++i) {
    const cv::Vec3d p(first_px[i].x - middle.x, first_px[i].y - middle.y, 1.0);
    N += p * p.t();
    b += p * cv::Matx12d(second_px[i].x, second_px[i].y);
  }
  bool solved = false;
  const cv::Matx33d inverse = N.inv(cv::DECOMP_CHOLESKY, &solved);
  if (!solved) return std::nullopt;
  const cv::Matx32d A = inverse * b;
  const cv::Matx33d centring(1, 0, -middle.x, 0, 1, -middle.y, 0, 0, 1);
  return cv::Matx33d(A(0, 0), A(1, 0), A(2, 0), A(0, 1), A(1, 1), A(2, 1), 0, 0, 1) * centring;
}

std::optional<cv::Matx33d> fit_homography(const std::vector<cv::Point2d>& first_px, const std::vector<cv::Point2d>& second_px) {
  if (first_px.size() < 4 || second_px.size() != first_px.size()) return std::nullopt;
  const auto normalising = [](const std::vector<cv::Point2d>& points) {
    cv::Point2d mean;
    for (const cv::Point2d& p : points) mean += p / static_cast<double>(points.size());
    double length = 0.0;
    for (const cv::Point2d& p : points) length += cv::norm(p - mean) / static_cast<double>(points.size());
    const double s = length > 0.0 ? std::sqrt(2.0) / length : 1.0;
    return cv::Matx33d(s, 0, -s * mean.x, 0, s, -s * mean.y, 0, 0, 1);
  };
  const cv::Matx33d T = normalising(first_px), U = normalising(second_px);
  cv::Mat A(static_cast<int>(2 * first_px.size()), 9, CV_64F, cv::Scalar(0));
  for (std::size_t i = 0; i < first_px.size(); ++i) {
    const cv::Point2d p(T(0, 0) * first_px[i].x + T(0, 2), T(1, 1) * first_px[i].y + T(1, 2));
    const cv::Point2d q(U(0, 0) * second_px[i].x + U(0, 2), U(1, 1) * second_px[i].y + U(1, 2));
    const double rows[2][9] = {{p.x, p.y, 1, 0, 0, 0, -q.x * p.x, -q.x * p.y, -q.x}, {0, 0, 0, p.x, p.y, 1, -q.y * p.x, -q.y * p.y, -q.y}};
    for (int r = 0; r < 2; ++r) std::copy_n(rows[r], 9, A.ptr<double>(static_cast<int>(2 * i) + r));
  }
  cv::Mat values, vectors;
  if (!cv::eigen(A.t() * A, values, vectors)) return std::nullopt;
  cv::Matx33d H;
  std::copy_n(vectors.ptr<double>(8), 9, H.val);
  H = U.inv() * H * T;
  if (!(std::abs(H(2, 2)) > 1e-12)) return std::nullopt;
  return H * (1.0 / H(2, 2));
}

std::vector<KeypointMatch> match_descriptors(const Keypoints& first, const Keypoints& second, double ratio) {
  const cv::Mat& a = first.descriptors;
  const cv::Mat& b = second.descriptors;
  if (a.empty() || b.empty()) return {};
  if (a.type() != b.type() || a.cols != b.cols) throw InvalidArgument("second", b.cols, "must be keypoints of the same kind as the first");
  std::vector<Nearest> of_first(static_cast<std::size_t>(a.rows)), of_second(static_cast<std::size_t>(b.rows));
  for (int i = 0; i < a.rows; ++i) {
    for (int j = 0; j < b.rows; ++j) {
      const double distance = squared_distance(a, i, b, j);
      of_first[static_cast<std::size_t>(i)].offer(j, distance);
      of_second[static_cast<std::size_t>(j)].offer(i, distance);
    }
  }
  std::vector<KeypointMatch> matches;
  const auto is_clear = [ratio](const Nearest& nearest) { return nearest.distance < ratio * ratio * nearest.next; };
  for (int i = 0; i < a.rows; ++i) {
    const Nearest& there = of_first[static_cast<std::size_t>(i)];
    if (there.index < 0) continue;  // a description of nothing, of numbers that are none
    const Nearest& back = of_second[static_cast<std::size_t>(there.index)];
    if (back.index == i && is_clear(there) && is_clear(back)) matches.push_back({i, there.index, std::sqrt(there.distance)});  // (V-12)
  }
  return matches;
}

cv::Point2d operator*(const Similarity& second_T_first, cv::Point2d first_px) {
  const double c = second_T_first.scale * std::cos(second_T_first.angle_rad), s = second_T_first.scale * std::sin(second_T_first.angle_rad);
  return cv::Point2d(c * first_px.x - s * first_px.y, s * first_px.x + c * first_px.y) + second_T_first.shift_px;
}

Similarity fit_similarity(const std::vector<cv::Point2d>& first_px, const std::vector<cv::Point2d>& second_px) {
  const std::size_t n = first_px.size();
  if (n < 2 || second_px.size() != n)
    throw InvalidArgument("first_px", static_cast<int>(n), "needs two points or more, and as many in the second");
  cv::Point2d mean_a, mean_b;
  for (std::size_t i = 0; i < n; ++i) {
    mean_a += first_px[i] / static_cast<double>(n);
    mean_b += second_px[i] / static_cast<double>(n);
  }
  double dot = 0.0, cross = 0.0, length = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const cv::Point2d a = first_px[i] - mean_a, b = second_px[i] - mean_b;
    dot += a.ddot(b);
    cross += a.cross(b);
    length += a.ddot(a);
  }
  if (!(length > 0.0)) throw InvalidArgument("first_px", static_cast<int>(n), "all points are in one place");
  Similarity motion;
  motion.scale = std::hypot(dot, cross) / length;
  motion.angle_rad = std::atan2(cross, dot);
  motion.shift_px = mean_b - motion * mean_a;
  return motion;
}

std::optional<Registration> register_frames(const Keypoints& first, const Keypoints& second, const std::vector<KeypointMatch>& matches,
                                            const MatchingConfig& config, std::uint64_t seed) {
  const auto least = static_cast<std::size_t>(config.least_inliers);
  if (matches.size() < least) return std::nullopt;
  const Pairs pairs = pairs_of(first, second, matches);
  const std::size_t n = matches.size();
  Rng rng = Rng(seed).stream("register_frames");
  const auto is_possible = [&](double scale) { return scale <= config.max_scale_change && scale * config.max_scale_change >= 1.0; };

  std::vector<std::size_t> best;
  double trials = config.max_trials;
  for (int trial = 0; trial < trials; ++trial) {  // (V-13)
    const auto i = static_cast<std::size_t>(rng.below(n));
    auto j = static_cast<std::size_t>(rng.below(n - 1));
    if (j >= i) ++j;
    if (pairs.first[i] == pairs.first[j]) continue;
    const Similarity motion = fit_similarity({pairs.first[i], pairs.first[j]}, {pairs.second[i], pairs.second[j]});
    if (!is_possible(motion.scale)) continue;
    std::vector<std::size_t> inliers = agreeing(pairs, motion, config.tolerance_px);
    if (inliers.size() <= best.size()) continue;
    best = std::move(inliers);
    const double part = static_cast<double>(best.size()) / static_cast<double>(n);
    if (part >= 1.0) break;
    trials = std::min<double>(config.max_trials, std::log(1.0 - config.confidence) / std::log1p(-part * part));
  }
  if (best.size() < least) return std::nullopt;

  Registration registration;
  for (int step = 0; step < kRefinements; ++step) {
    const Pairs inliers = chosen(pairs, best);
    registration.second_T_first = fit_similarity(inliers.first, inliers.second);
    std::vector<std::size_t> now = agreeing(pairs, registration.second_T_first, config.tolerance_px);
    if (now == best || now.size() < best.size()) break;
    best = std::move(now);
  }
  const std::optional<cv::Matx33d> mapping = grow(pairs, best, config.tolerance_px);
  const Pairs inliers = chosen(pairs, best);
  registration.second_T_first = fit_similarity(inliers.first, inliers.second);
  if (!is_possible(registration.second_T_first.scale)) return std::nullopt;
  double squares = 0.0;
  for (std::size_t k = 0; k < best.size(); ++k) {
    registration.inliers.push_back(matches[best[k]]);
    const cv::Point2d error = registration.second_T_first * inliers.first[k] - inliers.second[k];
    squares += error.ddot(error);
  }
  registration.rms_px = std::sqrt(squares / static_cast<double>(best.size()));
  registration.second_H_first = mapping.value_or(matrix_of(registration.second_T_first));
  return registration;
}

}  // namespace ssjs
