#include "ssjs/mapping/landmark_map.hpp"

#include <algorithm>
#include <cmath>

namespace ssjs {
namespace {

constexpr Eigen::Index kInitialCapacity = 32;  // landmarks; grows when a map does

std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

/// The last entry takes the place of the removed one, as in the filter.
template <class T>
void remove_entry(std::vector<T>& entries, Eigen::Index removed) {
  entries[at(removed)] = entries.back();
  entries.pop_back();
}

}  // namespace

LandmarkMap::LandmarkMap(const SubmapBuilderConfig& config, const ScanAssociationConfig& association, std::uint64_t seed,
                         ErrorForm error_form, StateLayout layout)
    : config_(config), associator_(association, seed), ekf_(kInitialCapacity, error_form, layout) {
  ekf_.reset({});
}

void LandmarkMap::clear(const GaussianSe2& frame_T_vehicle) {
  ekf_.reset(frame_T_vehicle);
  landmarks_.clear();
  first_scan_.clear();
  last_scan_.clear();
  labels_.clear();
  scans_ = 0;
  moved_m_ = turned_rad_ = 0.0;
}

void LandmarkMap::predict(const MotionPrediction& motion) {
  moved_m_ += (motion.submap_T_vehicle.translation() - ekf_.vehicle_pose().translation()).norm();
  turned_rad_ += std::abs(angle_difference(motion.submap_T_vehicle.heading, ekf_.vehicle_pose().heading));
  ekf_.predict(motion);
}

bool LandmarkMap::takes_scan() {
  const bool moved_enough = moved_m_ >= config_.min_motion_m || (config_.min_rotation_rad > 0.0 && turned_rad_ >= config_.min_rotation_rad);
  if (!scan_due_ && !moved_enough) return false;
  scan_due_ = false;
  moved_m_ = turned_rad_ = 0.0;
  ++scans_;
  return true;
}

const ScanAssociation& LandmarkMap::associate(const Features& scan, ScanResult& result) {
  const ScanAssociation& association = associator_.associate(scan, ekf_, landmarks_);
  result.association_time_s = association.time_s;
  result.budget_exhausted = association.hypothesis.budget_exhausted;
  result.wrong_pairs = association.wrong_pairs;
  return association;
}

ScanResult LandmarkMap::observe(const Features& scan) {
  ScanResult result;
  if (!takes_scan()) return result;
  const ScanAssociation& association = associate(scan, result);
  update(scan, association.hypothesis.pairs, association.selected, result);
  for (const Eigen::Index i : association.fresh) add(scan[at(i)], result);
  result.dropped = static_cast<int>(scan.size()) - result.paired - result.added;
  prune();
  return result;
}

int LandmarkMap::new_landmarks(const ScanAssociation& association) const {
  if (config_.min_sightings == 1) return static_cast<int>(association.fresh.size());
  return static_cast<int>(std::count_if(association.hypothesis.pairs.begin(), association.hypothesis.pairs.end(), [&](const Pair& pair) {
    return landmarks_[at(association.selected[at(pair.prediction)])].times_seen + 1 == config_.min_sightings;
  }));
}

void LandmarkMap::update(const Features& scan, const std::vector<Pair>& pairs, const std::vector<Eigen::Index>& selected,
                         ScanResult& result) {
  result.paired = static_cast<int>(pairs.size());
  if (pairs.empty()) return;
  result.update = ekf_.update(scan, pairs, selected);
  for (const Pair& pair : pairs) {
    const std::size_t landmark = at(selected[at(pair.prediction)]);
    ++landmarks_[landmark].times_seen;
    last_scan_[landmark] = scans_;
    result.used.push_back({scan[at(pair.observation)], landmarks_[landmark].tracks.front()});
  }
}

void LandmarkMap::add(const Feature& feature, ScanResult& result) {
  const auto tentative = [&](const MapLandmark& landmark) { return !confirmed(landmark); };
  if (std::count_if(landmarks_.begin(), landmarks_.end(), tentative) >= config_.max_tentative) return;
  ekf_.add_landmark(feature);
  landmarks_.push_back({1, feature.landmark_id, {tracks_}});
  first_scan_.push_back(scans_);
  last_scan_.push_back(scans_);
  labels_.push_back(-1);
  result.used.push_back({feature, tracks_++});
  ++result.added;
}

void LandmarkMap::remove(Eigen::Index landmark) {
  ekf_.remove_landmark(landmark);
  remove_entry(landmarks_, landmark);
  remove_entry(first_scan_, landmark);
  remove_entry(last_scan_, landmark);
  remove_entry(labels_, landmark);
}

void LandmarkMap::prune() {
  if (!config_.prune_after_scans) return;
  for (Eigen::Index i = ekf_.landmarks() - 1; i >= 0; --i) {
    if (!confirmed(landmarks_[at(i)]) && scans_ - first_scan_[at(i)] >= *config_.prune_after_scans) remove(i);
  }
}

void LandmarkMap::drop_tentative() {
  for (Eigen::Index i = ekf_.landmarks() - 1; i >= 0; --i) {
    if (!confirmed(landmarks_[at(i)])) remove(i);
  }
}

void LandmarkMap::add_known(const TrackedLandmark& landmark, const Eigen::Vector2d& position,
                            const Eigen::Ref<const Eigen::Matrix<double, 2, Eigen::Dynamic>>& J_state, const Eigen::Matrix2d& noise) {
  ekf_.add_dependent_landmark(position, J_state, noise);
  landmarks_.push_back(landmark.landmark);
  first_scan_.push_back(landmark.first_scan);
  last_scan_.push_back(landmark.last_scan);
  labels_.push_back(landmark.label);
}

void LandmarkMap::restore_books(const std::vector<TrackedLandmark>& landmarks) {
  landmarks_.clear();
  first_scan_.clear();
  last_scan_.clear();
  labels_.clear();
  for (const TrackedLandmark& tracked : landmarks) {
    landmarks_.push_back(tracked.landmark);
    first_scan_.push_back(tracked.first_scan);
    last_scan_.push_back(tracked.last_scan);
    labels_.push_back(tracked.label);
  }
}

TrackedLandmark LandmarkMap::tracked(Eigen::Index landmark) const {
  return {landmarks_[at(landmark)], first_scan_[at(landmark)], last_scan_[at(landmark)], labels_[at(landmark)]};
}

}  // namespace ssjs
