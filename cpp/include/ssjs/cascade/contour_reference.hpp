/// What the contours of known objects look like, and how unlike them another one is. docs/math/cascade.md (C-20), (C-22), (C-23).
#pragma once

#include <vector>

#include "ssjs/cascade/contour_signature.hpp"

namespace ssjs {

struct ContourReference {
  ContourSpectrum mean{};
  ContourSpectrum deviation{};    ///< positive
  std::vector<double> distances;  ///< of each known object from all the others, rising
  friend bool operator==(const ContourReference& a, const ContourReference& b) {
    return a.mean == b.mean && a.deviation == b.deviation && a.distances == b.distances;
  }
};

/// Throws InvalidArgument with fewer than three objects.
[[nodiscard]] ContourReference learn_contours(const std::vector<ContourSpectrum>& objects);

/// Throws InvalidArgument unless all numbers are finite, deviations positive and distances rising.
void check_contour_reference(const ContourReference& reference);

/// (C-20): root mean square of the harmonics' distances from their means, in deviations: about 1 for objects like the known ones.
[[nodiscard]] double contour_distance(const ContourSpectrum& spectrum, const ContourReference& reference);

/// (C-23): the share of known objects at least so unlike the others, in (0, 1]. Of objects like the known ones no more than about a
/// part p scores p or less.
[[nodiscard]] double contour_score(double distance, const ContourReference& reference);

}  // namespace ssjs
