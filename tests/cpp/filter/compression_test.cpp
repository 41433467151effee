#include "ssjs/filter/compression.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "filter/dense_filter.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/filter/compressed_map.hpp"

namespace ssjs {
namespace {

using testing::largest_difference;
using testing::random_covariance;
using testing::random_matrix;
using testing::random_motion;
using testing::random_observation;

constexpr double kRounding = 1e-10;

/// One filter over everything beside one that works on regions. Both see the same operations.
struct Pair {
  Ekf all{4};
  Ekf region{4};
  Compression compression;
  CompressedMap map;
  std::vector<Eigen::Index> slots;  ///< by landmark of the region's filter, negative: new
  std::vector<int> names;           ///< by landmark of the region's filter
  std::vector<int> all_names;       ///< by landmark of the filter over everything
  std::vector<int> slot_names;      ///< by slot
  int next_name = 0;

  Pair() {
    all.reset({});
    map.enter({}, region, compression);
    region.watch(&compression);
  }
  [[nodiscard]] Eigen::Index in_all(int name) const { return std::find(all_names.begin(), all_names.end(), name) - all_names.begin(); }

  void predict(const MotionPrediction& motion) {
    all.predict(motion);
    region.predict(motion);
  }
  void add(Rng& rng) {
    const Eigen::Vector2d place = random_matrix(rng, 2, 1, 3.0);
    const Eigen::Matrix<double, 2, 3> J = random_matrix(rng, 2, 3);
    const Eigen::Matrix2d noise = random_covariance(rng, 2, 0.3);
    all.add_landmark(place, J, noise);
    region.add_landmark(place, J, noise);
    slots.push_back(-1);
    names.push_back(next_name);
    all_names.push_back(next_name++);
  }
  void update(Rng& rng) {
    std::vector<LinearObservation> of_region;
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (rng.below(2) == 0) of_region.push_back(random_observation(rng, static_cast<Eigen::Index>(i)));
    }
    std::vector<LinearObservation> of_all = of_region;
    for (LinearObservation& z : of_all) z.landmark = in_all(names[static_cast<std::size_t>(z.landmark)]);
    all.update(of_all);
    region.update(of_region);
  }
  void remove(Rng& rng) {
    if (names.empty()) return;
    const std::size_t gone = rng.below(names.size());
    const Eigen::Index of_all = in_all(names[gone]);
    all.remove_landmark(of_all);
    all_names[static_cast<std::size_t>(of_all)] = all_names.back();
    all_names.pop_back();
    region.remove_landmark(static_cast<Eigen::Index>(gone));
    names[gone] = names.back();
    names.pop_back();
    slots[gone] = slots.back();
    slots.pop_back();
  }
  /// Brings the map up to date, compares it, and goes on in another region.
  void change_region(Rng& rng) {
    map.update_from(region.state(), compression, slots);
    slot_names.resize(static_cast<std::size_t>(map.slots()), -1);
    for (std::size_t i = 0; i < slots.size(); ++i) slot_names[static_cast<std::size_t>(slots[i])] = names[i];
    std::vector<Eigen::Index> used, rows{0, 1, 2};
    for (Eigen::Index slot = 0; slot < map.slots(); ++slot) {
      if (map.is_free(slot)) continue;
      used.push_back(slot);
      const Eigen::Index row = StateLayout().offset(in_all(slot_names[static_cast<std::size_t>(slot)]));
      rows.insert(rows.end(), {row, row + 1});
    }
    ASSERT_EQ(used.size(), all_names.size());
    const MapState expected = all.state();
    const MapState state = map.state(used);
    ASSERT_LE(largest_difference(state.mean, expected.mean(rows)), kRounding);
    ASSERT_LE(largest_difference(state.covariance, expected.covariance(rows, rows)), kRounding);
    slots.clear();
    names.clear();
    for (const Eigen::Index slot : used) {
      if (rng.below(2) == 0) continue;
      slots.push_back(slot);
      names.push_back(slot_names[static_cast<std::size_t>(slot)]);
    }
    map.enter(slots, region, compression);
  }
};

TEST(Compression, G6_G10_EqualsOneFilterOverEverything) {
  Rng rng(701);
  Pair pair;
  std::size_t largest = 0;
  for (int region = 0; region < 25; ++region) {
    for (int step = 0; step < 12; ++step) {
      pair.predict(random_motion(rng, pair.all.vehicle_pose()));
      if (rng.below(4) == 0) pair.add(rng);
      if (rng.below(2) == 0) pair.update(rng);
      if (rng.below(12) == 0) pair.remove(rng);
    }
    pair.change_region(rng);
    largest = std::max(largest, pair.all_names.size());
  }
  EXPECT_GE(largest, 20U);
}

TEST(Compression, ARegionWithoutUpdatesOnlyMovesTheVehicle) {
  Rng rng(702);
  Pair pair;
  for (int i = 0; i < 5; ++i) pair.add(rng);
  pair.predict(random_motion(rng, pair.all.vehicle_pose()));
  pair.change_region(rng);
  for (int i = 0; i < 3; ++i) pair.predict(random_motion(rng, pair.all.vehicle_pose()));
  EXPECT_FALSE(pair.compression.has_updates());
  pair.change_region(rng);
}

TEST(Compression, RefusesTheInvariantForm) {
  Ekf filter(4, ErrorForm::kInvariant);
  filter.reset({{}, Eigen::Matrix3d::Identity()});
  Compression compression;
  compression.start(3);
  filter.watch(&compression);
  filter.add_landmark({{3.0, 0.4}, Eigen::Matrix2d::Identity(), {}});
  Rng rng(703);
  EXPECT_THROW(filter.update({random_observation(rng, 0)}), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
