/// More training windows out of one labelled object, changed as another pass of the sonar would have changed it. Thesis 4.3.4.
#pragma once

#include <cstddef>

#include "ssjs/base/config_field.hpp"
#include "ssjs/base/random.hpp"
#include "ssjs/cascade/window_set.hpp"

namespace ssjs {

struct SampleAugmentationConfig {
  double scale_spread = 0.1;
  double shift_spread = 0.05;
  double gain_spread = 0.2;
  double additive_noise = 3.0;
  double multiplicative_noise = 0.1;
  bool flip_along_track = true;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("scale_spread", scale_spread, Rule{0.0, 1.0, false, true}, "boxes grow or shrink by up to this part of their size");
    v.field("shift_spread", shift_spread, Rule{0.0, 1.0, false, true}, "boxes move by up to this part of their size");
    v.field("gain_spread", gain_spread, Rule{0.0, 1.0, false, true}, "levels grow or shrink by up to this part of themselves");
    v.field("additive_noise", additive_noise, Rule::not_negative(), "standard deviation of noise added to the levels");
    v.field("multiplicative_noise", multiplicative_noise, Rule::not_negative(), "standard deviation of noise as a part of the level");
    v.field("flip_along_track", flip_along_track, "half of the copies upside down; never left to right, for shadows have a direction");
  }
};

/// Up to `copies` changed windows of the object in `box`, of recording `recording`. Rows are along track. Copies whose box leaves the
/// picture are left out.
[[nodiscard]] WindowSet augmented_windows(const cv::Mat& image, const cv::Rect& box, cv::Size window, std::size_t copies, int recording,
                                          const SampleAugmentationConfig& config, Rng rng);

}  // namespace ssjs
