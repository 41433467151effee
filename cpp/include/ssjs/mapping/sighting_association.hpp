/// Which sighting of one ping is of which landmark of a levelled map. docs/math/association.md, auv.md.
#pragma once

#include <vector>

#include "ssjs/filter/levelled_filter.hpp"
#include "ssjs/mapping/scan_association.hpp"
#include "ssjs/mapping/submap.hpp"

namespace ssjs {

struct SightingAssociation {
  std::vector<Pair> pairs;          ///< observation = index of the sighting, prediction = index of the landmark in the filter
  std::vector<Eigen::Index> fresh;  ///< sightings outside the dead band of every landmark: new ones
  int wrong_pairs = 0;              ///< pairs whose source identities differ, where both are known
};

/// Pairs along and across track (or along the slant range), the two components that side-scan sees; the height does not decide.
/// kKnown pairs by identity; a pair outside the gate of the sonar is misread, and neither used nor new.
/// The answer's memory is used again. A single point, and points with identities, take none from the heap; several without identities are
/// searched jointly, which does.
void associate_sightings(const SideScanSightings& sightings, const LevelledFilter& filter, const std::vector<MapLandmark>& landmarks,
                         const SideScanConfig& side_scan, const ScanAssociationConfig& config, SightingAssociation& answer);

}  // namespace ssjs
