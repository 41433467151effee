/// More training windows out of few: thesis 4.3.4 found its cascade of use only after that.
#pragma once

#include "ssjs/base/config_field.hpp"
#include "ssjs/base/random.hpp"
#include "ssjs/cascade/window_set.hpp"

namespace ssjs {

struct AugmentationConfig {
  int copies = 3;
  double scale = 0.1;
  double shift_px = 0.5;
  double gain = 0.2;
  double additive_noise = 4.0;
  double multiplicative_noise = 0.1;
  bool flip_along_track = true;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("copies", copies, Rule::not_negative(), "of each window, besides itself");
    v.field("scale", scale, Rule{0, 1, false, true}, "copies are larger or smaller by up to this part");
    v.field("shift_px", shift_px, Rule::not_negative(), "and moved by up to so much");
    v.field("gain", gain, Rule{0, 1, false, true}, "and brighter or darker by up to this part");
    v.field("additive_noise", additive_noise, Rule::not_negative(), "deviation of noise of the receiver, grey levels");
    v.field("multiplicative_noise", multiplicative_noise, Rule::not_negative(), "deviation of speckle, part of the level");
    v.field("flip_along_track", flip_along_track, "turn every other copy upside down; never left to right, since a shadow has a direction");
  }
};

/// The windows, then their copies in the same order, each with the recording of its original. Rows are pings. Copies depend on `rng`
/// and on the window's place in the set alone. For windows whose pictures are gone: where they are there, copies are better cut from
/// them anew, since what is done here blurs and adds noise that windows without object do not have.
[[nodiscard]] WindowSet augmented(const WindowSet& windows, const AugmentationConfig& config, const Rng& rng);

}  // namespace ssjs
