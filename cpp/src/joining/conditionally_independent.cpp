#include "ssjs/joining/conditionally_independent.hpp"

#include <algorithm>
#include <chrono>

namespace ssjs {
namespace {

constexpr double kGridCell_m = 10.0;

std::vector<MapLandmark> landmarks_of(const std::vector<TrackedLandmark>& tracked) {
  std::vector<MapLandmark> landmarks;
  for (const TrackedLandmark& one : tracked) landmarks.push_back(one.landmark);
  return landmarks;
}

}  // namespace

ConditionallyIndependentMapper::ConditionallyIndependentMapper(const ConditionallyIndependentConfig& config,
                                                               const SubmapBuilderConfig& submap, const ScanAssociationConfig& association,
                                                               std::uint64_t seed)
    : FilterMapper(submap, association, seed, StateLayout{true}),
      config_(config),
      split_(submap.split),
      identities_known_(association.method == AssociationMethod::kKnown) {}

void ConditionallyIndependentMapper::predict(double time_s, const MotionPrediction& motion) {
  distance_m_ += (motion.submap_T_vehicle.translation() - base_T_vehicle().translation()).norm();
  FilterMapper::predict(time_s, motion);
}

MapperReport ConditionallyIndependentMapper::observe(double time_s, const Features& scan) {
  touch(time_s);
  MapperReport report;
  if (!local_map().takes_scan()) return report;
  using Clock = std::chrono::steady_clock;
  const auto seconds_since = [](Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); };
  const auto begin = Clock::now();
  recall_seen(scan);
  report.join_time_s = seconds_since(begin);
  const ScanAssociation& association = local_map().associate(scan, report.scan);
  const auto reason = reason_to_close(situation(association), split_);
  local_map().update(scan, association.hypothesis.pairs, association.selected, report.scan);
  if (reason) {  // what is new in this scan belongs to the next map already
    const auto closing = Clock::now();
    report.join = close_map(*reason);
    report.join_time_s += seconds_since(closing);
  }
  for (const Eigen::Index i : association.fresh) local_map().add(scan[static_cast<std::size_t>(i)], report.scan);
  report.scan.dropped = static_cast<int>(scan.size()) - report.scan.paired - report.scan.added;
  local_map().prune();
  label_new_landmarks();
  return report;
}

void ConditionallyIndependentMapper::recall_seen(const Features& scan) {
  if (identities_known_) {
    for (const Feature& feature : scan) {
      if (!feature.landmark_id) continue;
      const auto past = past_identities_.find(*feature.landmark_id);
      if (past != past_identities_.end()) recall(past->second);
    }
    return;
  }
  if (!past_grid_) return;
  const ScanReach reach(scan, local_map().filter());
  const Eigen::Vector2d here = base_T_vehicle().translation();
  for (const Eigen::Index i : past_grid_->within(here, reach.radius_m(past_variance_))) {  // (I-7)
    const ConditionalChain::PastLandmark& past = past_[static_cast<std::size_t>(i)];
    if (chain_.is_past(past.label) && (past.position - here).norm() <= reach.radius_m(past.variance)) recall(past.label);
  }
}

void ConditionallyIndependentMapper::recall(int label) {
  recalled_[label] = chain_.holder(label);
  chain_.recall(label, local_map());
  const auto& identity = local_map().landmarks().back().source_id;
  if (identity) past_identities_.erase(*identity);
}

SplitSituation ConditionallyIndependentMapper::situation(const ScanAssociation& association) {
  SplitSituation now;
  for (Eigen::Index i = 0; i < local_map().size(); ++i) {  // a recalled landmark counts once it is seen
    const TrackedLandmark tracked = local_map().tracked(i);
    now.landmarks += local_map().confirmed(tracked.landmark) && tracked.last_scan >= first_scan_ ? 1 : 0;
  }
  now.new_landmarks = local_map().new_landmarks(association);
  for (const Pair& pair : association.hypothesis.pairs) {
    const TrackedLandmark tracked = local_map().tracked(association.selected[static_cast<std::size_t>(pair.prediction)]);
    now.new_landmarks += local_map().confirmed(tracked.landmark) && tracked.last_scan < first_scan_ ? 1 : 0;
  }
  now.submap_T_vehicle = local_map().filter().frozen_T_vehicle();
  now.distance_m = distance_m_;
  now.duration_s = duration_s();
  return now;
}

JoinReport ConditionallyIndependentMapper::close_map(const std::string& reason) {
  local_map().drop_tentative();
  label_new_landmarks();
  const std::vector<TrackedLandmark> landmarks = tracked_landmarks();
  std::vector<Eigen::Index> shared;
  std::vector<TrackedLandmark> next;
  std::map<int, int> pairs;  // by map: landmarks recalled from it and seen
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    const TrackedLandmark& landmark = landmarks[i];
    const auto origin = recalled_.find(landmark.label);
    if (origin != recalled_.end() && landmark.last_scan >= first_scan_) ++pairs[origin->second];
    if (landmark.last_scan > local_map().scans() - config_.shared_scans) {
      shared.push_back(static_cast<Eigen::Index>(i));
      next.push_back(landmark);
    } else if (landmark.landmark.source_id) {
      past_identities_.emplace(*landmark.landmark.source_id, landmark.label);
    }
  }
  JoinReport report;
  const int index = submap();
  for (const auto& [map, count] : pairs) {
    if (map + 1 >= index) continue;  // neighbours in time
    LoopAttempt loop;
    loop.time_s = time_s();
    loop.from = index;
    loop.to = map;
    loop.accepted = true;
    loop.pairs = count;
    report.loops.push_back(loop);
  }
  report.candidates = static_cast<int>(report.loops.size());

  const MapState state = local_map().filter().state();
  close(reason, in_base_frame(state), landmarks_of(landmarks));
  local_map().filter().restore(chain_.close(state, landmarks, shared));
  local_map().restore_books(next);
  first_scan_ = local_map().scans();
  distance_m_ = 0.0;
  recalled_.clear();
  if (!identities_known_) {
    past_ = chain_.past_landmarks(local_map());
    past_variance_ = 0.0;
    Eigen::Matrix2Xd positions(2, static_cast<Eigen::Index>(past_.size()));
    for (std::size_t i = 0; i < past_.size(); ++i) {
      positions.col(static_cast<Eigen::Index>(i)) = past_[i].position;
      past_variance_ = std::max(past_variance_, past_[i].variance);
    }
    past_grid_.emplace(positions, kGridCell_m);
  }
  return report;
}

void ConditionallyIndependentMapper::label_new_landmarks() {
  for (Eigen::Index i = 0; i < local_map().size(); ++i) {
    if (local_map().tracked(i).label < 0) local_map().set_label(i, next_label_++);
  }
}

std::vector<TrackedLandmark> ConditionallyIndependentMapper::tracked_landmarks() const {
  std::vector<TrackedLandmark> landmarks;
  for (Eigen::Index i = 0; i < local_map().size(); ++i) landmarks.push_back(local_map().tracked(i));
  return landmarks;
}

JoinReport ConditionallyIndependentMapper::finish() {
  local_map().drop_tentative();
  label_new_landmarks();
  close_last(in_base_frame(local_map().filter().state()), local_map().landmarks());
  final_ = world(BaseCovariance::kBorders);  // (I-6)
  return {};
}

WorldEstimate ConditionallyIndependentMapper::world(BaseCovariance covariance) const {
  if (final_ && covariance == BaseCovariance::kBorders) return *final_;
  Ekf filter = local_map().filter();  // reading a state settles it
  return chain_.estimate(filter.state(), tracked_landmarks(), covariance);
}

}  // namespace ssjs
