/// The improved Otsu threshold: a second Otsu pass above the first threshold when the picture is full of small bright spots.
/// [yuan2016] section 3.2, equations 1 to 10, docs/math/segmentation.md (O-8) to (O-11)
#pragma once

#include <cstdint>
#include <optional>

#include "ssjs/base/config_field.hpp"
#include "ssjs/imaging/sonar_image.hpp"

namespace ssjs {

struct ImprovedOtsuConfig {
  std::optional<int> spot_px;
  std::optional<int> spot_limit;
  std::optional<double> canny_high;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("spot_px", spot_px, Rule::at_least(1), "contours of fewer pixels are spots; unset: 10 to 60 by the size of the image");
    v.field("spot_limit", spot_limit, Rule::not_negative(),
            "more spots than this ask for the second pass; unset: by the size of the image");
    v.field("canny_high", canny_high, Rule::closed(0, 1),
            "gradient of a strong edge as a fraction of the image's largest; unset: the first threshold as a fraction of full scale");
  }
};

struct ImprovedOtsu {
  int first_threshold = 0;         ///< T, of Otsu's method
  int threshold = 0;               ///< T*: above T if the second pass fired and found two classes, otherwise T
  std::int64_t spots = 0;          ///< N_a: contours of fewer than spot_px pixels
  int spot_px = 0;                 ///< a
  double spot_limit = 0;           ///< as configured or derived from the image
  double canny_high = 0;           ///< likewise
  bool second_pass_fired = false;  ///< spots > spot_limit
};

/// None for images of one level or without a valid pixel.
/// The answer depends on the speckle as well as on the spots: a filter before it takes edges away, and the gate may stay shut.
[[nodiscard]] std::optional<ImprovedOtsu> improved_otsu(const SonarImage& image, const ImprovedOtsuConfig& config);

/// a and the limit that the image's number of valid pixels asks for. (O-11)
[[nodiscard]] int automatic_spot_px(std::int64_t valid_px);
[[nodiscard]] double automatic_spot_limit(std::int64_t valid_px, int spot_px);

}  // namespace ssjs
