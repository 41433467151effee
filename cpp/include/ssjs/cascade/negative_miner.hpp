/// Windows of pictures without objects that a cascade takes for objects all the same: what its next layer learns from.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>

#include "ssjs/base/random.hpp"
#include "ssjs/cascade/haar_cascade.hpp"
#include "ssjs/cascade/window_set.hpp"
#include "ssjs/imaging/sonar_image.hpp"

namespace ssjs {

/// Pictures without objects, read one at a time: never all of them need be in memory. `read` is called on the caller's thread;
/// none: the picture could not be read, it is passed over.
struct NegativeImages {
  std::size_t count = 0;
  std::function<std::optional<SonarImage>(std::size_t index)> read;
};

struct MinedNegatives {
  WindowSet windows;
  double windows_looked_at = 0;  ///< on the grids of the pictures that were scanned
  double windows_passed = 0;     ///< of these, by the cascade
  std::size_t images_missing = 0;
};

/// Up to `wanted` windows that pass all stages, as the detector saw them; with no stage yet, windows drawn at random places and
/// sizes. Pictures are taken in an order drawn from the stream named `name`, at first so many windows of each that all
/// contribute, then all that they hold. The result does not depend on `threads`.
[[nodiscard]] MinedNegatives mine_negatives(const HaarCascade& cascade, const NegativeImages& images, std::size_t wanted,
                                            double scale_factor, const Rng& rng, const std::string& name, int threads);

}  // namespace ssjs
