#include "ssjs/joining/chained_map.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <chrono>
#include <set>
#include <utility>

#include "ssjs/joining/duplicate_landmarks.hpp"
#include "ssjs/joining/map_placement.hpp"

namespace ssjs {
namespace {

constexpr int kDuplicateRounds = 3;

/// The borders of b in the frame of a. What left the state is taken for independent of a_T_b.
BorderEstimate moved(const GaussianSe2& a_T_b, const BorderEstimate& border) {
  Eigen::Matrix<double, 6, 3> J_tau;
  J_tau << compose_jacobian_left(a_T_b.mean, border.start), compose_jacobian_left(a_T_b.mean, border.end);
  Matrix6d J_border = Matrix6d::Zero();
  J_border.topLeftCorner<3, 3>() = J_border.bottomRightCorner<3, 3>() = compose_jacobian_right(a_T_b.mean);
  return {a_T_b.mean * border.start, a_T_b.mean * border.end,
          J_tau * a_T_b.covariance * J_tau.transpose() + J_border * border.covariance * J_border.transpose()};
}

/// The end is in the state and known better now; the start, which is not, follows it by regression.
BorderEstimate with_end(const BorderEstimate& border, const GaussianSe2& end) {
  const auto P_start = border.covariance.topLeftCorner<3, 3>();
  const auto P_cross = border.covariance.topRightCorner<3, 3>();
  const Eigen::Matrix3d P_end = border.covariance.bottomRightCorner<3, 3>();
  const Eigen::Matrix3d gain = P_end.llt().solve(P_cross.transpose()).transpose();
  BorderEstimate updated{additive_step(border.start, gain * additive_difference(end.mean, border.end)), end.mean, {}};
  updated.covariance.topLeftCorner<3, 3>() = P_start + gain * (end.covariance - P_end) * gain.transpose();
  updated.covariance.topRightCorner<3, 3>() = gain * end.covariance;
  updated.covariance.bottomLeftCorner<3, 3>() = updated.covariance.topRightCorner<3, 3>().transpose();
  updated.covariance.bottomRightCorner<3, 3>() = end.covariance;
  return updated;
}

BorderEstimate from_base(const GaussianSe2& end) {
  BorderEstimate border{{}, end.mean, Matrix6d::Zero()};
  border.covariance.bottomRightCorner<3, 3>() = end.covariance;
  return border;
}

GaussianSe2 pose_of(const LiveMap& map, Eigen::Index pose) {
  return {map.base_T_pose(pose), map.covariance(LiveMap::pose(pose), LiveMap::pose(pose))};
}

/// remove_poses() for the rows that a large map can drop without gathering the others one by one.
void forget_first_pose(LiveMap& map) {
  const Eigen::Index n = map.mean.size() - 3;
  map.poses.erase(map.poses.begin());
  map.mean = map.mean.tail(n).eval();
  map.covariance = map.covariance.bottomRightCorner(n, n).eval();
}

/// Pairs of landmarks of the maps; those whose relative position is too unsure are left out as ambiguous.
std::vector<Pair> associate(const LiveMap& a, const LiveMap& b, MapAssociator& associator, JoinReport& report) {
  if (associator.identities_are_known()) return pair_by_identity(a, b);
  const MapPlacement placement = placement_inside(a, b.base);
  const MapMeeting meeting = meet(a, b, placement);
  if (meeting.a_landmarks.empty() || meeting.b_landmarks.empty()) return {};
  const Hypothesis hypothesis = associator.associate(meeting.problem);
  report.budget_exhausted = report.budget_exhausted || hypothesis.budget_exhausted;
  std::vector<Pair> pairs = landmark_pairs(meeting, hypothesis.pairs);
  const auto gate = associator.ambiguity_gate();
  const auto ambiguous = [&](const Pair& pair) { return !(displacement_sigma(a, b, placement, pair) <= *gate); };
  if (gate) pairs.erase(std::remove_if(pairs.begin(), pairs.end(), ambiguous), pairs.end());
  return pairs;
}

/// Both seen by one submap, which told them apart.
bool seen_together(const MapLandmark& i, const MapLandmark& j, const std::map<std::int64_t, int>& submap_of_track) {
  std::set<int> submaps;
  for (const std::int64_t track : i.tracks) submaps.insert(submap_of_track.at(track));
  return std::any_of(j.tracks.begin(), j.tracks.end(), [&](std::int64_t track) { return submaps.count(submap_of_track.at(track)) > 0; });
}

/// (L-5) of the landmarks that have one of these tracks with all others. Repeated while it finds something: what is merged makes the rest
/// surer. Adds to the join.
void merge_duplicates_of(const std::set<std::int64_t>& tracks, const std::map<std::int64_t, int>& submap_of_track, LiveMap& map,
                         MapAssociator& associator, NeighbourJoin& join, JoinReport& report) {
  const auto distinct = [&](Eigen::Index i, Eigen::Index j) {
    return seen_together(map.landmarks[static_cast<std::size_t>(i)], map.landmarks[static_cast<std::size_t>(j)], submap_of_track);
  };
  for (int round = 0; round < kDuplicateRounds; ++round) {
    std::vector<Eigen::Index> recent;
    for (Eigen::Index i = 0; i < map.landmark_count(); ++i) {
      const std::vector<std::int64_t>& own = map.landmarks[static_cast<std::size_t>(i)].tracks;
      if (std::any_of(own.begin(), own.end(), [&](std::int64_t track) { return tracks.count(track) > 0; })) recent.push_back(i);
    }
    const Duplicates duplicates = find_duplicates(map, recent, distinct, associator);
    report.budget_exhausted = report.budget_exhausted || duplicates.budget_exhausted;
    if (duplicates.pairs.empty()) return;
    const auto wrong = count_wrong_pairs(duplicates.pairs, map, map);
    if (!wrong) join.wrong_pairs.reset();
    if (join.wrong_pairs) *join.wrong_pairs += *wrong;
    join.pairs += static_cast<int>(duplicates.pairs.size());
    join.chi_squared += merge_duplicates(map, duplicates.pairs);
    join.dof += static_cast<int>(2 * duplicates.pairs.size());
  }
}

}  // namespace

ChainedMap chained_map_of(const Submap& submap) {
  ChainedMap chained{live_map_of(submap), {}, {}};
  for (const MapLandmark& landmark : submap.landmarks) {
    for (const std::int64_t track : landmark.tracks) chained.submap_of_track[track] = submap.index;
  }
  chained.borders.push_back(from_base(pose_of(chained.map, 0)));
  return chained;
}

ChainedMap join_neighbours(const ChainedMap& a, const ChainedMap& b, MergeNeighbours merge, MapAssociator& associator, JoinReport& report) {
  const auto begin = std::chrono::steady_clock::now();
  const std::vector<Pair> pairs = associate(a.map, b.map, associator, report);
  report.association_time_s += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  Fusion fusion = merge(a.map, b.map, pairs);
  ++report.fusions;
  ChainedMap joined{{}, a.borders, a.submap_of_track};
  joined.submap_of_track.insert(b.submap_of_track.begin(), b.submap_of_track.end());
  NeighbourJoin join{a.map.base,         b.map.base, static_cast<int>(pairs.size()), count_wrong_pairs(pairs, a.map, b.map),
                     fusion.chi_squared, fusion.dof};
  if (!associator.identities_are_known()) {
    const auto begin_again = std::chrono::steady_clock::now();
    std::set<std::int64_t> tracks;
    for (const auto& [track, submap] : b.submap_of_track) tracks.insert(track);
    merge_duplicates_of(tracks, joined.submap_of_track, fusion.map, associator, join, report);
    report.association_time_s += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_again).count();
  }
  report.neighbours.push_back(join);

  // The merged state holds the border between the two (pose 0) and the new exit (pose 1) once more together: (L-4).
  joined.map = std::move(fusion.map);
  const LiveMap& map = joined.map;
  const GaussianSe2 border = pose_of(map, 0);
  const GaussianSe2 exit = pose_of(map, 1);
  if (a.borders.size() == 1) joined.borders.front() = from_base(border);
  if (b.borders.size() == 1) {
    joined.borders.push_back({border.mean, exit.mean, map.covariance.topLeftCorner<6, 6>()});
  } else {
    for (const BorderEstimate& of_b : b.borders) joined.borders.push_back(moved(border, of_b));
    joined.borders.back() = with_end(joined.borders.back(), exit);
  }
  forget_first_pose(joined.map);
  return joined;
}

void associate_with_itself(ChainedMap& chained, MapAssociator& associator, JoinReport& report) {
  if (associator.identities_are_known()) return;
  const auto begin = std::chrono::steady_clock::now();
  std::map<int, std::set<std::int64_t>> tracks_of;  // by submap
  for (const auto& [track, submap] : chained.submap_of_track) tracks_of[submap].insert(track);
  NeighbourJoin join{chained.map.base, chained.map.base, 0, 0, 0.0, 0};
  for (const auto& [submap, tracks] : tracks_of) {
    merge_duplicates_of(tracks, chained.submap_of_track, chained.map, associator, join, report);
  }
  report.association_time_s += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (join.pairs == 0) return;
  report.neighbours.push_back(join);
  chained.borders.back() =
      chained.borders.size() == 1 ? from_base(pose_of(chained.map, 0)) : with_end(chained.borders.back(), pose_of(chained.map, 0));
}

}  // namespace ssjs
