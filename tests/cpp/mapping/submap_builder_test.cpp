#include "ssjs/mapping/submap_builder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "filter/dense_filter.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/sensors/range_bearing.hpp"

namespace ssjs {
namespace {

using testing::largest_difference;

constexpr double kRounding = 1e-12;
const Eigen::Matrix2d kNoise = Eigen::Vector2d(0.01, 0.0003).asDiagonal();  // 0.1 m, 1 deg

/// What a sensor without error sees from `frame_T_vehicle`.
Feature seen(const Se2& frame_T_vehicle, const Eigen::Vector2d& frame_p_landmark, std::optional<std::int64_t> id) {
  return {predict_range_bearing(frame_T_vehicle, frame_p_landmark).range_bearing, kNoise, id};
}

/// Straight ahead by `distance_m` with a little noise.
MotionPrediction ahead(const Se2& pose, double distance_m) {
  const Se2 old_T_new{distance_m, 0.0, 0.0};
  const Eigen::Matrix3d J2 = compose_jacobian_right(pose);
  return {pose * old_T_new, compose_jacobian_left(pose, old_T_new),
          J2 * Eigen::Vector3d(0.01, 0.002, 0.0004).asDiagonal() * J2.transpose()};
}

/// Six landmarks around the origin, not in the order of their bearings.
const std::vector<Eigen::Vector2d> kLandmarks{{5.0, 2.0}, {-3.0, 4.0}, {6.0, -3.0}, {2.0, 5.0}, {-4.0, -2.0}, {1.0, -6.0}};

Features scan_of(const Se2& frame_T_vehicle, const std::vector<std::int64_t>& ids) {
  Features scan;
  for (const std::int64_t id : ids) scan.push_back(seen(frame_T_vehicle, kLandmarks[static_cast<std::size_t>(id)], id));
  return scan;
}

struct Options {
  SubmapBuilderConfig config;
  ScanAssociationConfig association;

  Options() {
    config.split = {std::nullopt, std::nullopt, std::nullopt, std::nullopt, std::nullopt, 0};
    association.method = AssociationMethod::kKnown;
  }
};

ErrorForm form_of(const SubmapBuilderConfig& config) { return config.invariant_filter ? ErrorForm::kInvariant : ErrorForm::kAdditive; }

MapState state_of(const SubmapBuilder& builder) {
  Ekf copy = builder.filter();
  copy.watch(nullptr);
  return copy.state();
}

TEST(SubmapBuilder, C2_BoundaryScanUsesEachObservationOnce) {
  Options options;
  options.config.split.max_landmarks = 6;
  SubmapBuilder builder(options.config, options.association, 1);
  const Features first = scan_of({}, {0, 1, 2, 3, 4, 5});
  const ScanResult opening = builder.observe(10.0, first);
  EXPECT_EQ(opening.added, 6);
  EXPECT_EQ(opening.paired, 0);
  EXPECT_FALSE(opening.update);
  const MotionPrediction motion = ahead({}, 0.8);
  builder.predict(11.0, motion);

  // The closing scan: all six again, and two new ones. 6 + 2 > 6.
  Features second = scan_of({0.75, 0.05, 0.02}, {3, 0, 5, 1, 4, 2});
  second.push_back(seen({0.75, 0.05, 0.02}, {7.0, 1.0}, 6));
  second.push_back(seen({0.75, 0.05, 0.02}, {0.0, -3.0}, 7));
  const ScanResult closing = builder.observe(12.0, second);
  ASSERT_TRUE(closing.closed);
  const Submap& submap = *closing.closed;
  EXPECT_EQ(submap.closed_because, "landmarks");
  EXPECT_EQ(submap.index, 0);
  EXPECT_EQ(submap.start_time_s, 10.0);
  EXPECT_EQ(submap.end_time_s, 12.0);
  EXPECT_EQ(builder.index(), 1);

  // Bearings from (0.75, 0.05): 4 (-157 deg), 5 (-88), 2 (-30), 0 (24), 3 (75), 1 (134). The old map gets 4, 2, 3, the new one 5, 0, 1.
  Ekf old_map(8, form_of(options.config));
  old_map.reset({});
  for (const Feature& feature : first) old_map.add_landmark(feature);
  old_map.predict(motion);
  (void)old_map.update({second[4], second[5], second[0]}, {{0, 0}, {1, 1}, {2, 2}}, {4, 2, 3});
  const MapState expected = old_map.state();
  EXPECT_LE(largest_difference(submap.state.mean, expected.mean), kRounding);
  EXPECT_LE(largest_difference(submap.state.covariance, expected.covariance), kRounding);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(submap.landmarks[i].times_seen, i == 4 || i == 2 || i == 3 ? 2 : 1) << i;

  // The new map: the vehicle exactly at its base, and the other half with the new ones.
  const MapState started = state_of(builder);
  EXPECT_EQ(started.mean.head<3>(), Eigen::Vector3d::Zero());
  EXPECT_EQ(started.covariance.topRows<3>().cwiseAbs().maxCoeff(), 0.0);
  Ekf new_map(8, form_of(options.config));
  new_map.reset({});
  for (const std::size_t i : {2U, 1U, 3U, 6U, 7U}) new_map.add_landmark(second[i]);
  EXPECT_LE(largest_difference(started.mean, new_map.state().mean), kRounding);
  EXPECT_LE(largest_difference(started.covariance, new_map.state().covariance), kRounding);

  // Three paired with the old map, five added to the new one: eight observations, eight uses.
  ASSERT_TRUE(closing.update);
  EXPECT_EQ(closing.update->dof, 6);
  EXPECT_EQ(closing.paired, 3);
  EXPECT_EQ(closing.added, 5);
  EXPECT_EQ(closing.dropped, 0);
}

TEST(SubmapBuilder, C2_WithFewerThanFourPairsTheOldMapGetsThemAll) {
  Options options;
  options.config.split.max_landmarks = 3;
  SubmapBuilder builder(options.config, options.association, 1);
  (void)builder.observe(0.0, scan_of({}, {0, 1, 2}));
  builder.predict(1.0, ahead({}, 0.5));
  const ScanResult closing = builder.observe(1.0, scan_of({0.5, 0.0, 0.0}, {0, 1, 2, 3, 4}));
  ASSERT_TRUE(closing.closed);
  EXPECT_EQ(closing.update->dof, 6);
  EXPECT_EQ(builder.filter().landmarks(), 2);
}

TEST(SubmapBuilder, C2_SharingCanBeSwitchedOff) {
  Options options;
  options.config.split.max_landmarks = 5;
  options.config.split_boundary_scan = false;
  SubmapBuilder builder(options.config, options.association, 1);
  (void)builder.observe(0.0, scan_of({}, {0, 1, 2, 3, 4}));
  builder.predict(1.0, ahead({}, 0.5));
  const ScanResult closing = builder.observe(1.0, scan_of({0.5, 0.0, 0.0}, {0, 1, 2, 3, 4, 5}));
  ASSERT_TRUE(closing.closed);
  EXPECT_EQ(closing.update->dof, 10);
  EXPECT_EQ(builder.filter().landmarks(), 1);
}

TEST(SubmapBuilder, C3_ClosingWithoutAnUpdateKeepsTheLastMotion) {
  // A step, then motion, then a closing scan of new landmarks only. With F = J1 and P_exit = J1 P J1' + Q the gain of the step before is
  // P J1' P_exit^-1.
  Options options;
  options.config.split.max_landmarks = 3;
  SubmapBuilder builder(options.config, options.association, 1);
  (void)builder.observe(0.0, scan_of({}, {0, 1, 2}));
  builder.record_step(0.0);
  builder.predict(1.0, ahead({}, 2.0));
  builder.record_step(1.0);
  const Eigen::Matrix3d P = builder.base_T_vehicle().covariance;
  const MotionPrediction last = ahead(builder.base_T_vehicle().mean, 3.0);
  builder.predict(2.0, last);
  const ScanResult closing = builder.observe(2.0, scan_of({5.0, 0.0, 0.0}, {3, 4, 5}));
  ASSERT_TRUE(closing.closed);
  ASSERT_EQ(closing.closed->steps.size(), 2U);
  const Eigen::Matrix3d P_exit = last.F * P * last.F.transpose() + last.Q;
  EXPECT_LE(largest_difference(closing.closed->state.vehicle().covariance, P_exit), kRounding);
  EXPECT_LE(largest_difference(closing.closed->steps[1].exit_gain, P * last.F.transpose() * P_exit.inverse()), 1e-6);
}

TEST(SubmapBuilder, StepsAreRecordedFromTheFirstEventOn) {
  Options options;
  SubmapBuilder builder(options.config, options.association, 1);
  builder.record_step(5.0);
  builder.predict(6.0, ahead({}, 1.0));
  builder.record_step(6.0);
  const Submap submap = builder.finish("end of the mission");
  EXPECT_EQ(submap.closed_because, "end of the mission");
  ASSERT_EQ(submap.steps.size(), 2U);
  EXPECT_EQ(submap.start_time_s, 5.0);
  EXPECT_EQ(submap.steps[0].time_s, 5.0);
  EXPECT_EQ(submap.steps[0].base_T_vehicle.vector(), Eigen::Vector3d::Zero());
  EXPECT_LE(largest_difference(submap.steps[1].exit_gain, Eigen::Matrix3d::Identity()), 1e-8);  // (1e-12 of regularisation) / 4e-4
}

TEST(SubmapBuilder, ASubmapEndsAtItsLastScanEvenWithoutMotionAfterIt) {
  Options options;
  SubmapBuilder builder(options.config, options.association, 1);
  builder.predict(3.0, ahead({}, 1.0));
  (void)builder.observe(4.0, scan_of({1.0, 0.0, 0.0}, {0, 1}));
  EXPECT_EQ(builder.finish("end").end_time_s, 4.0);
}

TEST(SubmapBuilder, TentativeLandmarksAreDroppedAtClosing) {
  Options options;
  options.config.min_sightings = 2;
  SubmapBuilder builder(options.config, options.association, 1);
  (void)builder.observe(0.0, scan_of({}, {0, 1, 2, 3}));
  builder.predict(1.0, ahead({}, 0.5));
  (void)builder.observe(1.0, scan_of({0.5, 0.0, 0.0}, {3, 1, 5}));
  EXPECT_EQ(builder.filter().landmarks(), 5);
  Ekf marginal = builder.filter();
  marginal.watch(nullptr);
  for (const Eigen::Index gone : {4, 2, 0}) marginal.remove_landmark(gone);  // 5, 2 and 0 were seen once
  const Submap submap = builder.finish("end");
  ASSERT_EQ(submap.landmarks.size(), 2U);
  EXPECT_EQ(submap.landmarks[0].source_id, 3);  // the last one took the place of the removed
  EXPECT_EQ(submap.landmarks[1].source_id, 1);
  EXPECT_EQ(submap.state.landmarks(), 2);
  EXPECT_LE(largest_difference(submap.state.mean, marginal.state().mean), kRounding);
  EXPECT_LE(largest_difference(submap.state.covariance, marginal.state().covariance), kRounding);
}

TEST(SubmapBuilder, TentativeLandmarksArePrunedAfterSomeScans) {
  Options options;
  options.config.min_sightings = 2;
  options.config.prune_after_scans = 3;
  SubmapBuilder builder(options.config, options.association, 1);
  (void)builder.observe(0.0, scan_of({}, {0, 1, 2}));  // scan 1
  (void)builder.observe(1.0, scan_of({}, {1}));        // 1 is confirmed
  (void)builder.observe(2.0, scan_of({}, {1, 4}));
  EXPECT_EQ(builder.filter().landmarks(), 4);
  (void)builder.observe(3.0, scan_of({}, {1}));  // scan 4 = 1 + 3: 0 and 2 go, 4 may still come back
  EXPECT_EQ(builder.filter().landmarks(), 2);
  (void)builder.observe(4.0, scan_of({}, {4, 1}));
  (void)builder.observe(5.0, scan_of({}, {1}));
  (void)builder.observe(6.0, scan_of({}, {1}));
  EXPECT_EQ(builder.filter().landmarks(), 2);
}

TEST(SubmapBuilder, C1_TentativeLandmarksDoNotFillTheSubmap) {
  Options options;
  options.config.min_sightings = 2;
  options.config.split.max_landmarks = 3;
  SubmapBuilder builder(options.config, options.association, 1);
  (void)builder.observe(0.0, scan_of({}, {0, 1, 2, 3, 4, 5}));
  builder.predict(1.0, ahead({}, 0.5));
  EXPECT_FALSE(builder.observe(1.0, scan_of({0.5, 0.0, 0.0}, {0, 1, 2})).closed);  // three are confirmed: the map is full
  const ScanResult fourth = builder.observe(2.0, scan_of({0.5, 0.0, 0.0}, {3}));
  ASSERT_TRUE(fourth.closed);  // this sighting would confirm one more
  EXPECT_EQ(fourth.closed->closed_because, "landmarks");
}

TEST(SubmapBuilder, AFloodOfSpuriousObservationsStaysBounded) {
  Options options;
  options.config.min_sightings = 2;
  options.config.max_tentative = 10;
  SubmapBuilder builder(options.config, options.association, 1);
  Rng rng(341);
  for (int scan = 0; scan < 5; ++scan) {
    Features flood;
    for (int i = 0; i < 300; ++i) {
      flood.push_back({Eigen::Vector2d(rng.uniform(1.0, 50.0), rng.uniform(-kPi, kPi)), kNoise, 1000 * (scan + 1) + i});
    }
    const ScanResult result = builder.observe(scan, flood);
    EXPECT_EQ(result.added, scan == 0 ? 10 : 0);
    EXPECT_EQ(result.dropped, scan == 0 ? 290 : 300);
    EXPECT_EQ(builder.filter().landmarks(), 10);
  }
}

TEST(SubmapBuilder, DeadBandKeepsDoubtfulObservationsFromBecomingLandmarks) {
  // One landmark, seen at 5 m; the vehicle knows where it is, so a second sighting differs by a variance of 0.01 + 0.01 in range.
  // Range errors of 0.3, 0.5 and 0.8 m have squared distances 4.5 (paired, gate 9.2), 12.5 (neither) and 32 (new).
  for (const AssociationMethod method :
       {AssociationMethod::kJointCompatibility, AssociationMethod::kNearestNeighbour, AssociationMethod::kRandomizedJointCompatibility}) {
    for (const auto& [error_m, paired, dropped, added] : {std::tuple{0.3, 1, 0, 0}, {0.5, 0, 1, 0}, {0.8, 0, 0, 1}}) {
      Options options;
      options.association.method = method;
      SubmapBuilder builder(options.config, options.association, 1);
      (void)builder.observe(0.0, {seen({}, {4.0, 3.0}, std::nullopt)});
      Feature again = seen({}, {4.0, 3.0}, std::nullopt);
      again.range_bearing.x() += error_m;
      const ScanResult result = builder.observe(1.0, {again});
      EXPECT_EQ(result.paired, paired) << error_m;
      EXPECT_EQ(result.dropped, dropped) << error_m;
      EXPECT_EQ(result.added, added) << error_m;
    }
  }
}

TEST(SubmapBuilder, PreselectionNeverHidesALandmarkFromTheDeadBand) {
  // The landmark lies 4.9 sigma beyond the observation: inside the dead band, and it must be found there.
  Options options;
  options.association.method = AssociationMethod::kJointCompatibility;
  SubmapBuilder builder(options.config, options.association, 1);
  Feature far = seen({}, {20.0, 0.0}, std::nullopt);
  far.covariance(0, 0) = 1.0;
  (void)builder.observe(0.0, {far});
  Feature near = seen({}, {20.0 - 4.9 * std::sqrt(1.01), 0.0}, std::nullopt);
  const ScanResult result = builder.observe(1.0, {near});
  EXPECT_EQ(result.dropped, 1);
  EXPECT_EQ(result.added, 0);
}

TEST(SubmapBuilder, ScansAreSkippedUntilTheVehicleHasMoved) {
  Options options;
  options.config.min_motion_m = 1.0;
  options.config.min_rotation_rad = 0.5;
  SubmapBuilder builder(options.config, options.association, 1);
  EXPECT_EQ(builder.observe(0.0, scan_of({}, {0, 1})).added, 2);  // the first one is always used
  builder.predict(1.0, ahead({}, 0.6));
  EXPECT_EQ(builder.observe(1.0, scan_of({0.6, 0.0, 0.0}, {0, 1})).paired, 0);
  builder.predict(2.0, ahead({0.6, 0.0, 0.0}, 0.6));
  EXPECT_EQ(builder.observe(2.0, scan_of({1.2, 0.0, 0.0}, {0, 1})).paired, 2);  // 1.2 m since the last used one
  MotionPrediction turn = ahead(builder.base_T_vehicle().mean, 0.0);
  turn.submap_T_vehicle.heading = wrap_angle(turn.submap_T_vehicle.heading + 0.6);
  builder.predict(3.0, turn);
  EXPECT_EQ(builder.observe(3.0, scan_of({1.2, 0.0, 0.6}, {0, 1})).paired, 2);
}

TEST(SubmapBuilder, WrongPairsAreCountedWhereIdentitiesAreKnown) {
  Options options;
  options.association.method = AssociationMethod::kNearestNeighbour;
  SubmapBuilder builder(options.config, options.association, 1);
  (void)builder.observe(0.0, scan_of({}, {0, 1, 2}));
  Features scan = scan_of({}, {0, 1, 2});
  scan[1].landmark_id = 77;            // stands where 1 was seen
  scan[2].landmark_id = std::nullopt;  // nothing is known about this one
  const ScanResult result = builder.observe(1.0, scan);
  EXPECT_EQ(result.paired, 3);
  EXPECT_EQ(result.wrong_pairs, 1);
}

TEST(SubmapBuilder, KnownIdentitiesArePairedHoweverFarTheyAre) {
  Options options;
  SubmapBuilder builder(options.config, options.association, 1);
  (void)builder.observe(0.0, scan_of({}, {0, 1}));
  Features scan = scan_of({}, {1, 0});
  scan[0].range_bearing.x() += 3.0;
  scan.push_back(scan[1]);  // the same identity twice in one scan: one of them is used
  const ScanResult result = builder.observe(1.0, scan);
  EXPECT_EQ(result.paired, 2);
  EXPECT_EQ(result.added, 0);
  EXPECT_EQ(result.dropped, 1);
}

TEST(SubmapBuilder, IdentityGateDropsMisreadObservations) {
  Options options;
  options.association.identity_gate_probability = 0.99;
  SubmapBuilder builder(options.config, options.association, 1);
  (void)builder.observe(0.0, scan_of({}, {0, 1, 2}));
  Features scan = scan_of({}, {0, 1, 2});
  std::swap(scan[0].landmark_id, scan[1].landmark_id);
  const ScanResult result = builder.observe(1.0, scan);
  EXPECT_EQ(result.paired, 1);
  EXPECT_EQ(result.added, 0);
  EXPECT_EQ(result.dropped, 2);
}

TEST(SubmapBuilder, C2_WhatWasMisreadStartsNoLandmarkInTheNextSubmapEither) {
  Options options;
  options.config.split.max_landmarks = 5;
  options.association.identity_gate_probability = 0.99;
  SubmapBuilder builder(options.config, options.association, 1);
  (void)builder.observe(0.0, scan_of({}, {0, 1, 2, 3, 4}));
  builder.predict(1.0, ahead({}, 0.5));
  Features scan = scan_of({0.5, 0.0, 0.0}, {0, 1, 2, 3, 4, 5});
  scan.push_back(seen({0.5, 0.0, 0.0}, {9.0, 9.0}, 2));     // not where landmark 2 is
  scan.push_back(seen({0.5, 0.0, 0.0}, kLandmarks[5], 5));  // 5 twice: one landmark
  const ScanResult closing = builder.observe(1.0, scan);
  ASSERT_TRUE(closing.closed);
  EXPECT_EQ(closing.paired, 3);                // of five pairs, by bearing: first, third and fifth
  EXPECT_EQ(builder.filter().landmarks(), 3);  // two of the pairs, and 5
  EXPECT_EQ(closing.added, 3);
  EXPECT_EQ(closing.dropped, 2);
}

}  // namespace
}  // namespace ssjs
