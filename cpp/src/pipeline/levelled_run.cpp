#include "ssjs/pipeline/levelled_run.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

constexpr double kPatienceS = 0.1;
constexpr std::size_t kMaxJointBases = 400;

using Clock = std::chrono::steady_clock;

void put(RowMatrix& poses, RowMatrix& covariances, Eigen::Index row, const SurveyStep& step) {
  poses.row(row) = step.global_T_vehicle;
  Eigen::Index column = 0;
  for (Eigen::Index i = 0; i < 6; ++i) {
    for (Eigen::Index j = i; j < 6; ++j) covariances(row, column++) = step.covariance(i, j);
  }
}

/// A pairing of maps that was used.
template <class Pairing>
void count(LevelledResult& result, const Pairing& pairing, double chi_squared) {
  result.map_wrong_pairs += pairing.wrong_pairs.value_or(0);
  result.map_identities_known = result.map_identities_known || (pairing.pairs > 0 && pairing.wrong_pairs.has_value());
  result.fusion_chi_squared += chi_squared;
  result.fusion_dof += pairing.dof;
}

void take(LevelledResult& result, const JoinReport& join) {
  result.fixes.insert(result.fixes.end(), join.fixes.begin(), join.fixes.end());
  result.loop_candidates += join.candidates;
  result.fusions += join.fusions;
  result.unsound_maps += join.unsound;
  result.budget_exhausted += join.budget_exhausted ? 1 : 0;
  result.time_association_s += join.association_time_s;
  for (const NeighbourJoin& neighbours : join.neighbours) count(result, neighbours, neighbours.chi_squared);
  for (const LoopAttempt& loop : join.loops) {
    if (loop.accepted) {
      ++result.loop_closures;
      count(result, loop, loop.chi_squared.value_or(0.0));
    } else if (loop.revised) {
      --result.loop_closures;
    }
    result.loops.push_back(loop);
  }
}

/// What was so at a remembered tick; the final trajectory has a step for each.
struct Remembered {
  SurveyStep online;
  Vector6d dead_reckoning;
  int submap;
};

void put_trajectory(LevelledResult& result, const std::vector<SurveyStep>& trajectory, const std::vector<Remembered>& remembered) {
  const auto n = static_cast<Eigen::Index>(trajectory.size());
  result.time_s.resize(n);
  for (RowMatrix* const poses : {&result.pose, &result.online_pose, &result.dead_reckoning}) poses->resize(n, 6);
  for (RowMatrix* const covariances : {&result.covariance, &result.online_covariance}) covariances->resize(n, 21);
  for (Eigen::Index i = 0; i < n; ++i) {
    const SurveyStep& step = trajectory[static_cast<std::size_t>(i)];
    const Remembered& then = remembered[static_cast<std::size_t>(i)];
    result.time_s(i) = step.time_s;
    put(result.pose, result.covariance, i, step);
    put(result.online_pose, result.online_covariance, i, then.online);
    result.dead_reckoning.row(i) = then.dead_reckoning;
    result.submap.push_back(then.submap);
  }
}

}  // namespace

LevelledResult run_levelled_mission(const LevelledConfig& config, const std::vector<NavigationTick>& ticks, const ProgressSink& progress,
                                    std::uint64_t seed) {
  LevelledResult result;
  LevelledPipeline pipeline(config, seed);
  const std::size_t n = ticks.size();
  const std::size_t report_every = std::max<std::size_t>(1, n / 1000);
  std::vector<Remembered> remembered;
  for (Eigen::VectorXd* const of_tick : {&result.tick_time_s, &result.step_time_us}) of_tick->resize(static_cast<Eigen::Index>(n));
  const auto begin = Clock::now();
  auto asked = begin;
  const auto ask = [&](double fraction) {
    asked = Clock::now();
    if (progress && !progress(fraction)) throw Cancelled();
  };
  for (std::size_t i = 0; i < n; ++i) {
    if (i % report_every == 0 || std::chrono::duration<double>(Clock::now() - asked).count() > kPatienceS) {
      ask(static_cast<double>(i) / static_cast<double>(n));
    }
    const auto step_begin = Clock::now();
    const LevelledReport step = pipeline.feed(ticks[i]);
    result.step_time_us(static_cast<Eigen::Index>(i)) = 1e6 * std::chrono::duration<double>(Clock::now() - step_begin).count();
    result.tick_time_s(static_cast<Eigen::Index>(i)) = ticks[i].time_s;
    if (step.remembered) remembered.push_back({step.vehicle, pipeline.dead_reckoning().vector(), step.submap});
    if (step.update.dof > 0) result.updates.push_back({ticks[i].time_s, step.update.nis, step.update.dof});
    result.frame_sightings.insert(result.frame_sightings.end(), step.frame.begin(), step.frame.end());
    result.observations += step.observations;
    result.refused += step.refused;
    result.scan_wrong_pairs += step.wrong_pairs;
    result.time_global_s += step.global_time_s;
    if (step.join) take(result, *step.join);
  }
  ask(1.0);
  const auto finish_begin = Clock::now();
  const JoinReport last = pipeline.finish();
  take(result, last);
  result.time_global_s += std::chrono::duration<double>(Clock::now() - finish_begin).count() - last.association_time_s;
  result.time_total_s = std::chrono::duration<double>(Clock::now() - begin).count();
  result.ticks = static_cast<int>(n);
  ask(1.0);
  for (const PortMap& map : pipeline.maps()) {
    result.submaps.push_back(map.submap);
    result.submaps.back().steps.clear();
  }
  SurveyEstimate estimate = pipeline.estimate(kMaxJointBases);
  put_trajectory(result, estimate.steps, remembered);
  result.global_T_base = std::move(estimate.global_T_base);
  result.base_covariance = std::move(estimate.base_covariance);
  result.landmarks = std::move(estimate.landmarks);
  result.landmark_covariance = std::move(estimate.landmark_covariance);
  result.existence = judge_existence(result.landmarks, estimate.steps, config.existence);
  result.live_maps = std::move(estimate.live_maps);
  result.compass_jumps = pipeline.compass_jumps();
  result.merged = pipeline.merged();
  for (std::size_t sensor = 0; sensor < kNavigationSensors; ++sensor) {
    result.sensors[sensor] = pipeline.statistics(static_cast<NavigationSensor>(sensor));
  }
  SensorStatistics& fix_sensor = result.sensors[static_cast<std::size_t>(NavigationSensor::kFix)];
  for (const FixAttempt& fix : result.fixes) {
    (fix.accepted ? fix_sensor.used : fix_sensor.refused) += 1;
    if (!fix.accepted || !fix.chi_squared || fix.relocated) continue;
    fix_sensor.nis_sum += *fix.chi_squared;
    fix_sensor.dof += 2;
  }
  return result;
}

}  // namespace ssjs
