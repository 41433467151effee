#include "ssjs/mapping/submap_builder.hpp"

#include <algorithm>
#include <cmath>

namespace ssjs {
namespace {

constexpr Eigen::Index kInitialCapacity = 32;  // landmarks; grows when a submap does

std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

}  // namespace

SubmapBuilder::SubmapBuilder(const SubmapBuilderConfig& config, const ScanAssociationConfig& association, std::uint64_t seed)
    : config_(config),
      identities_known_(association.method == AssociationMethod::kKnown),
      associator_(association, seed),
      ekf_(kInitialCapacity, config.invariant_filter ? ErrorForm::kInvariant : ErrorForm::kAdditive) {
  ekf_.reset({});
  if (config_.condition_trajectory) ekf_.watch(&journal_);
}

void SubmapBuilder::start(double time_s) {
  ekf_.reset({});  // the vehicle is at the base, exactly
  landmarks_.clear();
  first_scan_.clear();
  journal_.clear();
  start_time_s_ = time_s;
  started_ = true;
  scans_ = 0;
  distance_m_ = moved_m_ = turned_rad_ = 0.0;
}

void SubmapBuilder::predict(double time_s, const MotionPrediction& motion) {
  if (!started_) start(time_s);
  const double moved = (motion.submap_T_vehicle.translation() - ekf_.vehicle_pose().translation()).norm();
  distance_m_ += moved;
  moved_m_ += moved;
  turned_rad_ += std::abs(angle_difference(motion.submap_T_vehicle.heading, ekf_.vehicle_pose().heading));
  ekf_.predict(motion);
  time_s_ = time_s;
}

void SubmapBuilder::record_step(double time_s) {
  if (!started_) start(time_s);
  journal_.step(time_s, ekf_);
}

ScanResult SubmapBuilder::observe(double time_s, const Features& scan) {
  if (!started_) start(time_s);
  time_s_ = time_s;
  ScanResult result;
  const bool moved_enough = moved_m_ >= config_.min_motion_m || (config_.min_rotation_rad > 0.0 && turned_rad_ >= config_.min_rotation_rad);
  if (!scan_due_ && !moved_enough) return result;
  scan_due_ = false;
  moved_m_ = turned_rad_ = 0.0;
  ++scans_;

  const ScanAssociation& association = associator_.associate(scan, ekf_, landmarks_);
  const std::vector<Pair>& pairs = association.hypothesis.pairs;
  result.association_time_s = association.time_s;
  result.budget_exhausted = association.hypothesis.budget_exhausted;
  result.wrong_pairs = association.wrong_pairs;

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
    update(scan, for_old, association.selected, result);
    result.closed = finish(*reason);
    start(time_s);
    scans_ = 1;
    for (const Feature& feature : for_new) add(feature, result);
    result.dropped = static_cast<int>(scan.size()) - result.paired - result.added;
    return result;
  }

  update(scan, pairs, association.selected, result);
  for (const Eigen::Index i : association.fresh) add(scan[at(i)], result);
  result.dropped = static_cast<int>(scan.size()) - result.paired - result.added;
  prune();
  return result;
}

SplitSituation SubmapBuilder::situation(double time_s, const ScanAssociation& association) const {
  SplitSituation now;
  for (const MapLandmark& landmark : landmarks_) now.landmarks += confirmed(landmark) ? 1 : 0;
  if (config_.min_sightings == 1) {
    now.new_landmarks = static_cast<int>(association.fresh.size());
  } else {
    for (const Pair& pair : association.hypothesis.pairs) {
      if (landmarks_[at(association.selected[at(pair.prediction)])].times_seen + 1 == config_.min_sightings) ++now.new_landmarks;
    }
  }
  now.submap_T_vehicle = base_T_vehicle();
  now.distance_m = distance_m_;
  now.duration_s = time_s - start_time_s_;
  return now;
}

void SubmapBuilder::update(const Features& scan, const std::vector<Pair>& pairs, const std::vector<Eigen::Index>& selected,
                           ScanResult& result) {
  result.paired = static_cast<int>(pairs.size());
  if (pairs.empty()) return;
  result.update = ekf_.update(scan, pairs, selected);
  for (const Pair& pair : pairs) {
    MapLandmark& landmark = landmarks_[at(selected[at(pair.prediction)])];
    ++landmark.times_seen;
    result.used.push_back({scan[at(pair.observation)], landmark.tracks.front()});
  }
}

void SubmapBuilder::add(const Feature& feature, ScanResult& result) {
  const auto tentative = [&](const MapLandmark& landmark) { return !confirmed(landmark); };
  if (std::count_if(landmarks_.begin(), landmarks_.end(), tentative) >= config_.max_tentative) return;
  ekf_.add_landmark(feature);
  landmarks_.push_back({1, feature.landmark_id, {tracks_}});
  first_scan_.push_back(scans_);
  result.used.push_back({feature, tracks_++});
  ++result.added;
}

void SubmapBuilder::remove(Eigen::Index landmark) {
  ekf_.remove_landmark(landmark);
  landmarks_[at(landmark)] = landmarks_.back();
  landmarks_.pop_back();
  first_scan_[at(landmark)] = first_scan_.back();
  first_scan_.pop_back();
}

void SubmapBuilder::prune() {
  if (!config_.prune_after_scans) return;
  for (Eigen::Index i = ekf_.landmarks() - 1; i >= 0; --i) {
    if (!confirmed(landmarks_[at(i)]) && scans_ - first_scan_[at(i)] >= *config_.prune_after_scans) remove(i);
  }
}

Submap SubmapBuilder::finish(const std::string& reason) {
  for (Eigen::Index i = ekf_.landmarks() - 1; i >= 0; --i) {
    if (!confirmed(landmarks_[at(i)])) remove(i);
  }
  Submap submap;
  submap.index = index_++;
  submap.start_time_s = start_time_s_;
  submap.end_time_s = time_s_;
  submap.closed_because = reason;
  submap.state = ekf_.state();
  submap.landmarks = landmarks_;
  submap.steps = config_.condition_trajectory ? journal_.steps(submap.state.vehicle()) : journal_.unconditioned_steps();
  return submap;
}

}  // namespace ssjs
