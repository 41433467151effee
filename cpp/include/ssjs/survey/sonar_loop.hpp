/// The sonar loop with pictures: what `aekf-loop` says of points, found in a simulated sonar picture of every scan. docs/paper_chain.md
/// points heard with the sensor's noise -> picture, (Q-2) -> segmentation -> centroids of regions -> observations to
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/imaging/segmentation.hpp"
#include "ssjs/simulation/scenario.hpp"
#include "ssjs/survey/scan_picture.hpp"

namespace ssjs {

/// A picture has as many pixels as the paper's low-resolution one: its settings are the segmentation's, and the spots are those of
/// branch_scene() in metres. (O-14)
struct SonarLoopConfig {
  ScanPictureConfig picture;
  SegmentationConfig segmentation = segmentation_preset(SegmentationPreset::kSideScanLow);
  double landmark_level = 235.0;
  double spots_per_100_m2 = 9.2;
  double spot_m2 = 0.6;
  double dimmest_spot_level = 100.0;
  double brightest_spot_level = 220.0;
  template <class Visitor>
  void visit(Visitor& v) {
    v.section("picture", picture, "the picture of a scan");
    v.section("segmentation", segmentation, "what finds regions in it");
    v.field("landmark_level", landmark_level, Rule::positive(), "brightest landmarks; none is below 0.9 of it");
    v.field("spots_per_100_m2", spots_per_100_m2, Rule::not_negative(), "bright spots on the seabed that are no landmarks");
    v.field("spot_m2", spot_m2, Rule::positive(), "spots have up to 0.9 times this area, three in a hundred 1.2 to 3 times");
    v.field("dimmest_spot_level", dimmest_spot_level, Rule::positive(), "levels of spots are uniform from here");
    v.field("brightest_spot_level", brightest_spot_level, Rule::positive(), "to here");
  }

  /// Every violation, rules beyond single fields included; empty when valid.
  [[nodiscard]] std::vector<std::string> violations() const;
};

/// What the pictures came to, summed over all of them.
struct SonarLoopCounts {
  std::int64_t pictures = 0;
  std::int64_t regions = 0;
  std::int64_t of_landmarks = 0;  ///< regions in which the middle of a landmark lies
  std::int64_t of_spots = 0;      ///< of a spot and of no landmark
  std::int64_t of_nothing = 0;    ///< speckle
  std::int64_t merged = 0;        ///< regions in which several landmarks or spots lie
  std::int64_t second_passes = 0;
  double threshold_sum = 0.0;  ///< of the pictures that have one threshold
};

/// The mission, its scans those of the regions: identities are of the landmark or spot whose middle lies nearest to the centroid inside the
/// region, none where none does. The world holds the landmarks, and the spots that were a region at least once.
struct SonarLoopMission {
  SimulatedMission mission;
  SonarLoopCounts counts;
};

/// `scenario`: its landmarks (streams "echoes" and "spots" of the seed give them extents and strew the seabed with spots), its sensor's
/// noise, which every echo of every picture has, and its least and greatest range. Stream "pictures" gives the speckle.
[[nodiscard]] SonarLoopMission simulate_sonar_loop(const Scenario& scenario, const SonarLoopConfig& config, std::uint64_t seed);

}  // namespace ssjs
