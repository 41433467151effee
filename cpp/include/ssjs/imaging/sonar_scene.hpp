/// Simulated sonar pictures of which the truth is known. docs/math/segmentation.md (O-13) to (O-15)
/// Level times speckle: gamma deviates of mean 1 and variance 1 / looks, one a pixel, then cut off to 8 bits.
#pragma once

#include <opencv2/core.hpp>

#include "ssjs/base/config_field.hpp"
#include "ssjs/base/random.hpp"
#include "ssjs/imaging/sonar_image.hpp"

namespace ssjs {

struct SonarScene {
  SonarImage image;
  cv::Mat object;  ///< CV_8U, 255 on the object
};

enum class SceneObject { kShip, kBranch, kBody };

/// One object with its shadow on an even seabed that is strewn with small bright spots.
struct SpottedSceneConfig {
  int rows = 800;
  int columns = 800;
  SceneObject object = SceneObject::kShip;
  double object_length_px = 170;
  double object_level = 235;
  int object_looks = 16;
  double background_level = 55;
  int looks = 6;
  double shadow = 0.2;
  int spots = 900;
  int spot_px = 30;
  double dimmest_spot_level = 100;
  double brightest_spot_level = 220;
  bool fan = false;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("rows", rows, Rule::at_least(16), "height of the picture, px");
    v.field("columns", columns, Rule::at_least(16), "width of the picture, px");
    v.choice("object", object,
             Choices<SceneObject>{{"ship", SceneObject::kShip}, {"branch", SceneObject::kBranch}, {"body", SceneObject::kBody}},
             "what lies on the seabed");
    v.field("object_length_px", object_length_px, Rule::positive(), "its longest side");
    v.field("object_level", object_level, Rule::positive(), "mean level of its brightest parts; no part is below 0.9 of it");
    v.field("object_looks", object_looks, Rule::at_least(1), "of the speckle on the object: the more, the smoother");
    v.field("background_level", background_level, Rule::positive(), "mean level of the seabed");
    v.field("looks", looks, Rule::at_least(1), "of the speckle elsewhere");
    v.field("shadow", shadow, Rule::closed(0, 1), "level of the shadow as a part of the seabed's");
    v.field("spots", spots, Rule::not_negative(), "how many small bright spots");
    v.field("spot_px", spot_px, Rule::at_least(4), "spots have 2 to 0.9 times so many pixels, three in a hundred 1.2 to 3 times");
    v.field("dimmest_spot_level", dimmest_spot_level, Rule::positive(), "levels of spots are uniform from here");
    v.field("brightest_spot_level", brightest_spot_level, Rule::positive(), "to here");
    v.field("fan", fan, "a forward-looking sonar's fan: what lies beyond is invalid");
  }
};

/// The scenes of the paper's three pictures: a ship of 800 x 800 pixels, a branch of 417 x 228, a body in a fan of 1920 x 932.
[[nodiscard]] SpottedSceneConfig ship_scene();
[[nodiscard]] SpottedSceneConfig branch_scene();
[[nodiscard]] SpottedSceneConfig body_scene();

/// The object lies near the middle, turned any way. Spots keep clear of it and of its shadow.
[[nodiscard]] SonarScene simulate_spotted_scene(const SpottedSceneConfig& config, const Rng& rng);

/// An elliptical echo and its shadow under a gain that rises linearly across track.
struct UnevenGainSceneConfig {
  int rows = 800;
  int columns = 800;
  double contrast = 2;
  double gradient = 0.6;
  double background_level = 50;
  int looks = 4;
  double shadow = 0.15;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("rows", rows, Rule::at_least(16), "height of the picture, px");
    v.field("columns", columns, Rule::at_least(16), "width of the picture, px");
    v.field("contrast", contrast, Rule::positive(), "level of the echo over that of the seabed");
    v.field("gradient", gradient, Rule::closed(0, 1), "the gain goes from 1 - gradient at the left to 1 + gradient at the right");
    v.field("background_level", background_level, Rule::positive(), "mean level of the seabed in the middle");
    v.field("looks", looks, Rule::at_least(1), "of the speckle");
    v.field("shadow", shadow, Rule::closed(0, 1), "level of the shadow as a part of the seabed's");
  }
};

[[nodiscard]] SonarScene simulate_uneven_gain_scene(const UnevenGainSceneConfig& config, const Rng& rng);

}  // namespace ssjs
