#include "ssjs/mapping/submap_builder.hpp"

#include <algorithm>

namespace ssjs {
namespace {

std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

}  // namespace

SubmapBuilder::SubmapBuilder(const SubmapBuilderConfig& config, const ScanAssociationConfig& association, std::uint64_t seed)
    : config_(config),
      identities_known_(association.method == AssociationMethod::kKnown),
      map_(config, association, seed, config.invariant_filter ? ErrorForm::kInvariant : ErrorForm::kAdditive) {
  if (config_.condition_trajectory) map_.filter().watch(&journal_);
}

void SubmapBuilder::start(double time_s) {
  map_.clear();  // the vehicle is at the base, exactly
  journal_.clear();
  start_time_s_ = time_s;
  started_ = true;
  distance_m_ = 0.0;
}

void SubmapBuilder::predict(double time_s, const MotionPrediction& motion) {
  if (!started_) start(time_s);
  distance_m_ += (motion.submap_T_vehicle.translation() - filter().vehicle_pose().translation()).norm();
  map_.predict(motion);
  time_s_ = time_s;
}

void SubmapBuilder::record_step(double time_s) {
  if (!started_) start(time_s);
  journal_.step(time_s, map_.filter());
}

ScanResult SubmapBuilder::observe(double time_s, const Features& scan) {
  if (!started_) start(time_s);
  time_s_ = time_s;
  ScanResult result;
  if (!map_.takes_scan()) return result;
  const ScanAssociation& association = map_.associate(scan, result);
  const std::vector<Pair>& pairs = association.hypothesis.pairs;

  if (const auto reason = reason_to_close(situation(time_s, association), config_.split)) {
    // (C-2): matched observations alternate by bearing between the two submaps; the new one takes everything unpaired, as its dead band
    // is empty, but for misread identities.
    std::vector<Pair> by_bearing = pairs;
    std::sort(by_bearing.begin(), by_bearing.end(),
              [&](const Pair& a, const Pair& b) { return scan[at(a.observation)].bearing() < scan[at(b.observation)].bearing(); });
    const bool share = config_.split_boundary_scan && by_bearing.size() >= 4;
    std::vector<Pair> for_old;
    Features for_new;
    for (std::size_t i = 0; i < by_bearing.size(); ++i) {
      if (share && i % 2 == 1) {
        for_new.push_back(scan[at(by_bearing[i].observation)]);
      } else {
        for_old.push_back(by_bearing[i]);
      }
    }
    for (std::size_t i = 0; i < scan.size(); ++i) {
      const bool misread = identities_known_ && association.hypothesis.nearest_squared_distance[i].has_value();
      if (!association.is_paired[i] && !misread) for_new.push_back(scan[i]);
    }
    map_.update(scan, for_old, association.selected, result);
    result.closed = finish(*reason);
    start(time_s);
    for (const Feature& feature : for_new) map_.add(feature, result);
    result.dropped = static_cast<int>(scan.size()) - result.paired - result.added;
    return result;
  }

  map_.update(scan, pairs, association.selected, result);
  for (const Eigen::Index i : association.fresh) map_.add(scan[at(i)], result);
  result.dropped = static_cast<int>(scan.size()) - result.paired - result.added;
  map_.prune();
  return result;
}

SplitSituation SubmapBuilder::situation(double time_s, const ScanAssociation& association) const {
  SplitSituation now;
  for (const MapLandmark& landmark : map_.landmarks()) now.landmarks += map_.confirmed(landmark) ? 1 : 0;
  now.new_landmarks = map_.new_landmarks(association);
  now.submap_T_vehicle = base_T_vehicle();
  now.distance_m = distance_m_;
  now.duration_s = time_s - start_time_s_;
  return now;
}

Submap SubmapBuilder::finish(const std::string& reason) {
  map_.drop_tentative();
  Submap submap;
  submap.index = index_++;
  submap.start_time_s = start_time_s_;
  submap.end_time_s = time_s_;
  submap.closed_because = reason;
  submap.state = map_.filter().state();
  submap.landmarks = map_.landmarks();
  submap.steps = config_.condition_trajectory ? journal_.take_steps(submap.state.vehicle()) : journal_.take_unconditioned_steps();
  return submap;
}

}  // namespace ssjs
