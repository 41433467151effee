#include "ssjs/pipeline/mission_run.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

constexpr double kPatienceS = 0.1;           // the sink is asked that often at least, if no single step takes longer
constexpr std::size_t kMaxJointBases = 400;  // beyond, the joint covariance of the bases is left out: 12 MB and growing with the square

using Clock = std::chrono::steady_clock;

void put(RowMatrix& poses, RowMatrix& covariances, Eigen::Index row, const GaussianSe2& value) {
  const Eigen::Matrix3d& P = value.covariance;
  poses.row(row) = value.mean.vector();
  covariances.row(row) << P(0, 0), P(0, 1), P(0, 2), P(1, 1), P(1, 2), P(2, 2);
}

/// A pairing of maps that was used.
template <class Pairing>
void count(MissionResult& result, const Pairing& pairing, double chi_squared) {
  result.map_wrong_pairs += pairing.wrong_pairs.value_or(0);
  result.map_identities_known = result.map_identities_known || (pairing.pairs > 0 && pairing.wrong_pairs.has_value());
  result.fusion_chi_squared += chi_squared;
  result.fusion_dof += pairing.dof;
}

void take(MissionResult& result, const JoinReport& join) {
  result.fusions += join.fusions;
  for (const NeighbourJoin& neighbours : join.neighbours) count(result, neighbours, neighbours.chi_squared);
  result.loop_candidates += join.candidates;
  result.budget_exhausted += join.budget_exhausted ? 1 : 0;
  for (const LoopAttempt& loop : join.loops) {
    if (loop.accepted) {
      ++result.loop_closures;
      count(result, loop, loop.chi_squared.value_or(0.0));
    }
    result.loops.push_back(loop);
  }
}

}  // namespace

MissionResult run_mission(const SlamConfig& config, const std::vector<Event>& events, std::uint64_t seed, const ProgressSink& progress) {
  MissionResult result;
  SlamPipeline pipeline(config, seed);
  std::optional<MissionSmoothing> smoothing;
  if (config.smoothing.enabled) smoothing.emplace(config);
  const auto n = static_cast<Eigen::Index>(events.size());
  result.time_s.resize(n);
  result.step_time_us.resize(n);
  for (RowMatrix* const poses : {&result.pose, &result.online_pose, &result.dead_reckoning}) poses->resize(n, 3);
  for (RowMatrix* const covariances : {&result.covariance, &result.online_covariance}) covariances->resize(n, 6);
  result.submap.reserve(events.size());

  const Eigen::Index report_every = std::max<Eigen::Index>(1, n / 1000);
  const auto begin = Clock::now();
  auto asked = begin;
  const auto ask = [&](double fraction) {
    asked = Clock::now();
    if (progress && !progress(fraction)) throw Cancelled();
  };
  for (Eigen::Index i = 0; i < n; ++i) {
    if (i % report_every == 0 || std::chrono::duration<double>(Clock::now() - asked).count() > kPatienceS) {
      ask(static_cast<double>(i) / static_cast<double>(n));
    }
    const auto step_begin = Clock::now();
    const StepReport step = pipeline.feed(events[static_cast<std::size_t>(i)]);
    const double step_s = std::chrono::duration<double>(Clock::now() - step_begin).count();
    result.step_time_us(i) = 1e6 * step_s;
    if (smoothing) smoothing->feed(events[static_cast<std::size_t>(i)], step.scan);
    result.time_s(i) = step.time_s;
    put(result.online_pose, result.online_covariance, i, step.global_T_vehicle);
    result.dead_reckoning.row(i) = pipeline.dead_reckoning().vector();
    result.submap.push_back(step.submap);
    result.time_local_s += step_s - step.global_time_s - step.association_time_s;
    result.time_global_s += step.global_time_s;
    result.time_association_s += step.association_time_s;
    if (step.scan) {
      result.observations += step.scan->paired + step.scan->added + step.scan->dropped;
      result.scan_wrong_pairs += step.scan->wrong_pairs;
      result.budget_exhausted += step.scan->budget_exhausted ? 1 : 0;
      if (step.scan->update) result.updates.push_back({step.time_s, step.scan->update->nis, step.scan->update->dof});
    }
    if (step.join) take(result, *step.join);
  }
  ask(1.0);
  const auto finish_begin = Clock::now();
  const JoinReport last = pipeline.finish();
  take(result, last);
  result.time_association_s += last.association_time_s;
  result.time_global_s += std::chrono::duration<double>(Clock::now() - finish_begin).count() - last.association_time_s;
  result.time_total_s = std::chrono::duration<double>(Clock::now() - begin).count();

  ask(1.0);
  if (n > 0) {
    const bool joint = pipeline.submaps().size() <= kMaxJointBases;
    result.world = pipeline.world(joint ? BaseCovariance::kJoint : BaseCovariance::kBorders);
    std::vector<TrajectoryPoint> trajectory = final_trajectory(pipeline.submaps(), result.world);
    if (smoothing) {
      ask(1.0);
      const auto smoothing_begin = Clock::now();
      SmoothedMission smoothed = smoothing->smooth(trajectory, std::move(result.world.landmarks));
      result.smoothing = smoothed.report;
      trajectory = std::move(smoothed.trajectory);
      result.world.landmarks = std::move(smoothed.landmarks);
      result.time_smoothing_s = std::chrono::duration<double>(Clock::now() - smoothing_begin).count();
      result.time_total_s += result.time_smoothing_s;
    }
    for (Eigen::Index i = 0; i < n; ++i)
      put(result.pose, result.covariance, i, trajectory.at(static_cast<std::size_t>(i)).global_T_vehicle);
    result.submaps = pipeline.submaps();
    for (Submap& submap : result.submaps) submap.steps.clear();
  }
  if (progress) progress(1.0);
  return result;
}

}  // namespace ssjs
