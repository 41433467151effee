/// A seabed as a camera sees it: sand, stones, shells, patches of coloured growth. docs/math/camera_simulation.md (CS-2), (CS-3)
///
/// World frame: x north, y east, z down from the surface, m.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/base/random.hpp"
#include "ssjs/simulation/raster.hpp"
#include "ssjs/simulation/value_noise.hpp"

namespace ssjs {

struct SeabedTextureConfig {
  double depth_m = 19.5;
  double slope_north = 0.01;
  double slope_east = -0.006;
  double undulation_m = 0.05;
  double undulation_length_m = 4.0;
  double grain = 0.35;
  double stones_per_m2 = 0.25;
  double shells_per_m2 = 1.0;
  double growth_per_m2 = 0.04;
  double texture_cell_m = 0.006;
  double relief_cell_m = 0.02;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("depth_m", depth_m, Rule::positive(), "of the seabed's plane at the origin");
    v.field("slope_north", slope_north, Rule::closed(-0.5, 0.5), "metres by which the seabed falls for a metre to the north");
    v.field("slope_east", slope_east, Rule::closed(-0.5, 0.5), "and to the east");
    v.field("undulation_m", undulation_m, Rule::not_negative(), "amplitude of its long waves");
    v.field("undulation_length_m", undulation_length_m, Rule::positive(), "distance of their crests, about");
    v.field("grain", grain, Rule::closed(0, 1), "contrast of the sand, of its mean brightness");
    v.field("stones_per_m2", stones_per_m2, Rule::closed(0, 100), "half sunk stones of 6 to 30 cm");
    v.field("shells_per_m2", shells_per_m2, Rule::closed(0, 100), "bright specks of 1 to 4 cm");
    v.field("growth_per_m2", growth_per_m2, Rule::closed(0, 100), "patches of coloured growth, 15 to 50 cm");
    v.field("texture_cell_m", texture_cell_m, Rule::closed(0.002, 1), "of the colours");
    v.field("relief_cell_m", relief_cell_m, Rule::closed(0.002, 1), "of the heights");
  }
};

using Albedo = Eigen::Array3f;  ///< red, green, blue: the part of the light that comes back, 0..1

/// Depth of the surface and its derivatives to the north and to the east.
struct SurfacePatch {
  float depth_m = 0.0F;
  float slope_north = 0.0F;
  float slope_east = 0.0F;
};

class SeabedTexture {
 public:
  /// Drawn between two corners; beyond them the border goes on. Streams of the seed: "undulation", "grain 0", ..., "stones", "shells",
  /// "growth".
  SeabedTexture(const SeabedTextureConfig& config, const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m, std::uint64_t seed);

  [[nodiscard]] double ground_depth_m(const Eigen::Vector2d& point_m) const;  ///< without stones: what a wide beam measures. (CS-2)
  [[nodiscard]] SurfacePatch surface(double x_m, double y_m) const;           ///< with them
  [[nodiscard]] Albedo albedo(double x_m, double y_m) const;
  [[nodiscard]] const Raster<SurfacePatch>& relief() const { return relief_; }

 private:
  using Colour = std::array<std::uint8_t, 3>;

  void lay_sand(const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m, const Rng& rng);
  void scatter_stones(Rng rng);
  void scatter_shells(Rng rng);
  void scatter_growth(Rng rng);
  void set_slopes();
  [[nodiscard]] int count_of(double per_m2) const;

  SeabedTextureConfig config_;
  Eigen::Vector2d extent_m_;
  ValueNoise undulation_;
  Raster<SurfacePatch> relief_;
  Raster<Colour> colours_;
};

}  // namespace ssjs
