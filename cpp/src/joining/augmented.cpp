#include "ssjs/joining/augmented.hpp"

#include <algorithm>
#include <bitset>
#include <cmath>

namespace ssjs {
namespace {

constexpr double kViewSigmas = 3.0;
constexpr double kOnSensorMetres = 1e-6;  // no bearing there

}  // namespace

AugmentedEkfMapper::AugmentedEkfMapper(const AugmentedEkfConfig& config, const RangeBearingConfig& sensor,
                                       const SubmapBuilderConfig& submap, const ScanAssociationConfig& association, std::uint64_t seed)
    : FilterMapper(submap, association, seed), config_(config), sensor_(sensor) {}

MapperReport AugmentedEkfMapper::observe(double time_s, const Features& scan) {
  touch(time_s);
  for (const Feature& feature : scan) farthest_m_ = std::max(farthest_m_, feature.range());
  const int scans = local_map().scans();
  MapperReport report{local_map().observe(scan), {}, 0.0};  // (G-4)
  if (local_map().scans() != scans) manage(expected_in_view());
  return report;
}

std::vector<bool> AugmentedEkfMapper::expected_in_view() {
  Ekf& filter = local_map().filter();
  const double far_m = std::min(sensor_.max_range_m, farthest_m_);
  const double half_field = 0.5 * config_.field_of_view_rad;
  std::vector<bool> expected(static_cast<std::size_t>(local_map().size()), false);
  for (Eigen::Index i = 0; i < local_map().size(); ++i) {
    const double distance_m = (filter.landmark_position(i) - base_T_vehicle().translation()).norm();
    if (distance_m > far_m || distance_m < std::max(sensor_.min_range_m, kOnSensorMetres)) continue;
    filter.predict_observations({i}, problem_);
    const double margin_m = kViewSigmas * (std::sqrt(problem_.predicted_covariance(0, 0)) + sensor_.range_sigma_m);
    const double margin_rad = kViewSigmas * (std::sqrt(problem_.predicted_covariance(1, 1)) + sensor_.bearing_sigma_rad);
    const bool all_round = half_field >= kPi - 1e-9;
    expected[static_cast<std::size_t>(i)] = problem_.predicted(0) + margin_m < far_m &&  //
                                            problem_.predicted(0) - margin_m > sensor_.min_range_m &&
                                            (all_round || std::abs(problem_.predicted(1)) + margin_rad < half_field);
  }
  return expected;
}

void AugmentedEkfMapper::manage(const std::vector<bool>& expected) {
  std::map<int, Views> kept;
  for (Eigen::Index i = local_map().size() - 1; i >= 0; --i) {  // (G-5); backwards, as the last landmark takes the place of a removed one
    TrackedLandmark tracked = local_map().tracked(i);
    if (tracked.label < 0) {
      local_map().set_label(i, tracked.label = next_label_++);
      kept[tracked.label] = {tracked.landmark.times_seen, 0};
      continue;
    }
    Views views = views_[tracked.label];
    if (tracked.landmark.times_seen > views.times_seen) {
      views.times_seen = tracked.landmark.times_seen;
      views.missed <<= 1;
    } else if (expected[static_cast<std::size_t>(i)]) {
      views.missed = (views.missed << 1) | 1U;
    }
    const std::bitset<64> window(views.missed << (64 - config_.view_window));
    if (tracked.landmark.times_seen < config_.permanent_sightings && static_cast<int>(window.count()) >= config_.max_missed_views) {
      local_map().remove(i);
    } else {
      kept[tracked.label] = views;
    }
  }
  views_ = std::move(kept);
}

JoinReport AugmentedEkfMapper::finish() {
  local_map().drop_tentative();
  close_last(local_map().filter().state(), local_map().landmarks());
  return {};
}

WorldEstimate AugmentedEkfMapper::world(BaseCovariance covariance) const {
  Ekf filter = local_map().filter();  // reading a state settles it
  return single_map_estimate(filter.state(), local_map().landmarks(), covariance);
}

}  // namespace ssjs
