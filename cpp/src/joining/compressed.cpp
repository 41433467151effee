#include "ssjs/joining/compressed.hpp"

#include <algorithm>

namespace ssjs {
namespace {

std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

}  // namespace

CompressedEkfMapper::CompressedEkfMapper(const CompressedEkfConfig& config, double max_range_m, const SubmapBuilderConfig& submap,
                                         const ScanAssociationConfig& association, std::uint64_t seed)
    : FilterMapper(submap, association, seed),
      config_(config),
      max_range_m_(max_range_m),
      identities_known_(association.method == AssociationMethod::kKnown) {
  whole_.enter({}, local_map().filter(), compression_);
  local_map().filter().watch(&compression_);
}

bool CompressedEkfMapper::shows_passive(const Features& scan) const {
  return identities_known_ && std::any_of(scan.begin(), scan.end(), [&](const Feature& feature) {
           return feature.landmark_id && passive_identities_.count(*feature.landmark_id) != 0;
         });
}

double CompressedEkfMapper::needed_m(const Features& scan) const {
  return identities_known_ ? 0.0 : ScanReach(scan, local_map().filter()).radius_m(passive_variance_);
}

MapperReport CompressedEkfMapper::observe(double time_s, const Features& scan) {
  touch(time_s);
  for (const Feature& feature : scan) farthest_m_ = std::max(farthest_m_, feature.range());
  const double sight_m = config_.sight_m.value_or(std::min(farthest_m_, max_range_m_));
  const double region_m = config_.region_m.value_or(sight_m);
  const double driven_m = (base_T_vehicle().translation() - centre_).norm();
  const double needed_m = this->needed_m(scan);
  const bool out_of_reach = region_changes_ > 0 && driven_m + needed_m > radius_m_;  // before the first change everything is active
  if (driven_m > region_m || out_of_reach || shows_passive(scan)) change_region(region_m + std::max(sight_m, needed_m), scan);  // (G-11)
  return {local_map().observe(scan), {}, 0.0};
}

std::vector<Eigen::Index> CompressedEkfMapper::active_slots() const {
  std::vector<Eigen::Index> slots;
  for (Eigen::Index i = 0; i < local_map().size(); ++i) slots.push_back(local_map().tracked(i).label);
  return slots;
}

void CompressedEkfMapper::settle() {
  std::vector<Eigen::Index> slots = active_slots();
  whole_.update_from(local_map().filter().state(), compression_, slots);
  books_.resize(at(whole_.slots()));
  for (Eigen::Index i = 0; i < local_map().size(); ++i) {
    local_map().set_label(i, static_cast<int>(slots[at(i)]));
    books_[at(slots[at(i)])] = local_map().tracked(i);
  }
}

void CompressedEkfMapper::change_region(double radius_m, const Features& scan) {
  settle();
  ++region_changes_;
  centre_ = base_T_vehicle().translation();
  radius_m_ = radius_m;
  std::set<std::int64_t> shown;
  for (const Feature& feature : scan) {
    if (identities_known_ && feature.landmark_id) shown.insert(*feature.landmark_id);
  }
  std::vector<Eigen::Index> slots;
  std::vector<TrackedLandmark> tracked;
  passive_identities_.clear();
  passive_variance_ = 0.0;
  for (Eigen::Index slot = 0; slot < whole_.slots(); ++slot) {
    if (whole_.is_free(slot)) continue;
    const auto& identity = books_[at(slot)].landmark.source_id;
    if ((whole_.landmark_position(slot) - centre_).norm() <= radius_m || (identity && shown.count(*identity) != 0)) {
      slots.push_back(slot);
      tracked.push_back(books_[at(slot)]);
    } else {
      passive_variance_ = std::max(passive_variance_, whole_.landmark_covariance(slot).trace());
      if (identity) passive_identities_.insert(*identity);
    }
  }
  whole_.enter(slots, local_map().filter(), compression_);
  local_map().restore_books(tracked);
}

MapState CompressedEkfMapper::whole(std::vector<MapLandmark>& landmarks) const {
  CompressedMap settled = whole_;
  Ekf filter = local_map().filter();
  std::vector<Eigen::Index> active = active_slots();
  settled.update_from(filter.state(), compression_, active);
  std::vector<TrackedLandmark> books = books_;
  books.resize(at(settled.slots()));
  for (Eigen::Index i = 0; i < local_map().size(); ++i) books[at(active[at(i)])] = local_map().tracked(i);
  std::vector<Eigen::Index> slots;
  landmarks.clear();
  for (Eigen::Index slot = 0; slot < settled.slots(); ++slot) {
    if (settled.is_free(slot)) continue;
    slots.push_back(slot);
    landmarks.push_back(books[at(slot)].landmark);
  }
  return settled.state(slots);
}

JoinReport CompressedEkfMapper::finish() {
  std::vector<MapLandmark> landmarks;
  local_map().drop_tentative();
  const MapState state = whole(landmarks);
  close_last(state, landmarks);
  return {};
}

WorldEstimate CompressedEkfMapper::world(BaseCovariance covariance) const {
  std::vector<MapLandmark> landmarks;
  const MapState state = whole(landmarks);
  return single_map_estimate(state, landmarks, covariance);
}

}  // namespace ssjs
