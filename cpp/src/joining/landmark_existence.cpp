#include "ssjs/joining/landmark_existence.hpp"

#include <algorithm>
#include <cmath>

#include "ssjs/base/angle.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/geometry/gaussian.hpp"

namespace ssjs {
namespace {

constexpr std::size_t kFewestSightings = 20;
constexpr double kInnerFraction = 0.96;  // of the sightings within the swath: a few lie beyond its edges by their errors
constexpr double kLongestStepS = 5.0;
constexpr double kMarginSigmas = 2.0;
constexpr int kLearningRounds = 30;
// What the settings weigh against the survey: so many landmarks, so many passes.
constexpr double kLandmarksOfPrior = 10.0;
constexpr double kPassesOfPrior = 20.0;

/// A point as the vehicle passes it between two steps.
struct Abeam {
  double time_s;
  double across_m;  ///< starboard positive
  double turn_rad_s;
};

Eigen::Vector2d in_body(const SurveyStep& step, const Eigen::Vector2d& point) {
  const double yaw = step.global_T_vehicle(5);
  const Eigen::Vector2d d = point - step.global_T_vehicle.head<2>();
  return {std::cos(yaw) * d.x() + std::sin(yaw) * d.y(), -std::sin(yaw) * d.x() + std::cos(yaw) * d.y()};
}

/// Between step i and the next; nothing where the point is not passed.
std::optional<Abeam> passed(const std::vector<SurveyStep>& way, std::size_t i, const Eigen::Vector2d& point) {
  const SurveyStep& from = way[i];
  const SurveyStep& to = way[i + 1];
  const double gap_s = to.time_s - from.time_s;
  if (!(gap_s > 0.0) || gap_s > kLongestStepS) return std::nullopt;
  const Eigen::Vector2d before = in_body(from, point);
  const Eigen::Vector2d after = in_body(to, point);
  if (!(before.x() > 0.0 && after.x() <= 0.0)) return std::nullopt;
  const double fraction = before.x() / (before.x() - after.x());
  const double turn = angle_difference(to.global_T_vehicle(5), from.global_T_vehicle(5)) / gap_s;
  return Abeam{from.time_s + fraction * gap_s, before.y() + fraction * (after.y() - before.y()), std::abs(turn)};
}

double quantile(std::vector<double> values, double fraction) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(std::lround(fraction * static_cast<double>(values.size() - 1)))];
}

/// Times of sightings that belong to one pass, and their passes. (P-21)
std::vector<double> passes_of(const std::vector<double>& seen_s, double window_s) {
  std::vector<double> passes;
  double last_s = 0.0;
  for (const double time_s : seen_s) {
    if (passes.empty() || time_s - last_s > window_s) passes.push_back(time_s);
    last_s = time_s;
  }
  return passes;
}

void count_passes(SurveyLandmark& landmark, const std::vector<SurveyStep>& way, const std::optional<CoveredSwath>& swath, double window_s) {
  if (landmark.seen_s.empty()) {  // nobody remembers when
    landmark.passes_seen = landmark.passes_expected = static_cast<int>(landmark.maps.size());
    return;
  }
  landmark.passes_seen = static_cast<int>(passes_of(landmark.seen_s, window_s).size());
  landmark.passes_expected = landmark.passes_seen;
  if (!swath || landmark.landmark.of_camera) return;
  const double margin_m = kMarginSigmas * largest_sigma(landmark.covariance.topLeftCorner<2, 2>());
  const Eigen::Vector2d point = landmark.position.head<2>();
  for (std::size_t i = 0; i + 1 < way.size(); ++i) {
    const std::optional<Abeam> abeam = passed(way, i, point);
    if (!abeam || abeam->turn_rad_s > swath->max_turn_rad_s) continue;
    const double across_m = std::abs(abeam->across_m);
    if (across_m < swath->min_across_m + margin_m || across_m > swath->max_across_m - margin_m) continue;
    const auto near = std::lower_bound(landmark.seen_s.begin(), landmark.seen_s.end(), abeam->time_s - window_s);
    if (near == landmark.seen_s.end() || *near > abeam->time_s + window_s) ++landmark.passes_expected;  // passed, and not seen
  }
}

}  // namespace

std::optional<CoveredSwath> covered_swath(const std::vector<SurveyLandmark>& landmarks, const std::vector<SurveyStep>& way) {
  std::vector<double> across_m;
  std::vector<double> turns_rad_s;
  for (const SurveyLandmark& landmark : landmarks) {
    if (landmark.landmark.of_camera) continue;
    for (const double time_s : landmark.seen_s) {
      const auto after = std::lower_bound(way.begin(), way.end(), time_s, [](const SurveyStep& step, double t) { return step.time_s < t; });
      if (after == way.begin() || after == way.end()) continue;
      const SurveyStep& from = *std::prev(after);
      const double gap_s = after->time_s - from.time_s;
      if (!(gap_s > 0.0) || gap_s > kLongestStepS) continue;
      across_m.push_back(std::abs(in_body(from, landmark.position.head<2>()).y()));
      turns_rad_s.push_back(std::abs(angle_difference(after->global_T_vehicle(5), from.global_T_vehicle(5))) / gap_s);
    }
  }
  if (across_m.size() < kFewestSightings) return std::nullopt;
  const double outside = 0.5 * (1.0 - kInnerFraction);
  return CoveredSwath{quantile(across_m, outside), quantile(across_m, 1.0 - outside), quantile(turns_rad_s, 1.0 - outside)};
}

double existence_probability(int seen, int expected, const ExistenceModel& model, double chance_probability) {
  const double detection = model.detection_probability;
  const double misses = expected - seen;
  double log_odds = std::log(model.real_probability / (1.0 - model.real_probability));
  log_odds += std::log(static_cast<double>(expected) / seen);  // C(n, k) against C(n - 1, k - 1)
  log_odds += seen * std::log(detection) + misses * std::log(1.0 - detection) - std::log(1.0 - std::pow(1.0 - detection, expected));
  log_odds -= (seen - 1) * std::log(chance_probability) + misses * std::log(1.0 - chance_probability);
  return 1.0 / (1.0 + std::exp(-log_odds));
}

ExistenceModel judge_existence(std::vector<SurveyLandmark>& landmarks, const std::vector<SurveyStep>& way, const ExistenceConfig& config) {
  throw_if_any(violations(config));
  const std::optional<CoveredSwath> swath = covered_swath(landmarks, way);
  for (SurveyLandmark& landmark : landmarks) count_passes(landmark, way, swath, config.pass_window_s);
  ExistenceModel model{config.real_probability, config.detection_probability};
  const auto existence_of = [&](const SurveyLandmark& landmark) {
    return existence_probability(landmark.passes_seen, landmark.passes_expected, model, config.chance_probability);
  };
  for (int round = 0; round < kLearningRounds; ++round) {  // (P-23)
    double landmarks_sum = kLandmarksOfPrior;
    double real = kLandmarksOfPrior * config.real_probability;
    double passes = kPassesOfPrior;
    double seen = kPassesOfPrior * config.detection_probability;
    for (const SurveyLandmark& landmark : landmarks) {
      if (landmark.landmark.of_camera) continue;
      const double existence = existence_of(landmark);
      const double n = landmark.passes_expected;
      landmarks_sum += 1.0;
      real += existence;
      if (landmark.passes_expected < 2) continue;  // its one pass is the reason that it is known
      const double never = std::pow(1.0 - model.detection_probability, n);
      passes += existence * n * (1.0 + never / (1.0 - never));  // and those objects that no pass showed
      seen += existence * landmark.passes_seen;
    }
    model = {real / landmarks_sum, seen / passes};
  }
  for (SurveyLandmark& landmark : landmarks) {
    // a camera's is known for its many frames; which later frames should have shown it nobody asks
    landmark.existence = landmark.landmark.of_camera ? 1.0 : existence_of(landmark);
    landmark.confirmed = landmark.existence >= config.min_existence;
  }
  return model;
}

}  // namespace ssjs
