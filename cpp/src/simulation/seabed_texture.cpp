#include "ssjs/simulation/seabed_texture.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "ssjs/base/angle.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

const Albedo kSand(0.46F, 0.42F, 0.34F);
const Albedo kShell(0.80F, 0.78F, 0.72F);
const std::array<Albedo, 4> kGrowth = {Albedo(0.62F, 0.16F, 0.08F), Albedo(0.60F, 0.48F, 0.06F), Albedo(0.12F, 0.34F, 0.10F),
                                       Albedo(0.40F, 0.12F, 0.38F)};

/// Lattice lengths of the sand's brightness with their shares: ripples of light and dark down to single pebbles. (CS-3)
struct Octave {
  double length_m;
  float share;
};
constexpr std::array<Octave, 7> kOctaves = {
    {{2.5, 0.12F}, {0.9, 0.14F}, {0.35, 0.18F}, {0.14, 0.20F}, {0.06, 0.22F}, {0.028, 0.26F}, {0.013, 0.22F}}};

std::uint8_t stored(float albedo) { return static_cast<std::uint8_t>(std::lround(255.0F * std::clamp(albedo, 0.0F, 1.0F))); }

std::array<std::uint8_t, 3> stored(const Albedo& albedo) { return {stored(albedo.x()), stored(albedo.y()), stored(albedo.z())}; }

/// Calls draw(value, offset in the object's axes) for the grid points within `reach_m` of a place.
template <class T, class Draw>
void draw_around(Raster<T>& raster, const Eigen::Vector2d& place_m, double heading_rad, double reach_m, const Draw& draw) {
  const Eigen::Vector2d first = (place_m - raster.from_m()).array() / raster.cell_m() - reach_m / raster.cell_m();
  const Eigen::Vector2d last = (place_m - raster.from_m()).array() / raster.cell_m() + reach_m / raster.cell_m();
  const Eigen::Rotation2D<double> object_R_world(-heading_rad);
  for (int row = std::max(0, static_cast<int>(first.x())); row <= std::min(raster.rows() - 1, static_cast<int>(last.x())); ++row) {
    for (int column = std::max(0, static_cast<int>(first.y())); column <= std::min(raster.columns() - 1, static_cast<int>(last.y()));
         ++column) {
      draw(raster.at(row, column), Eigen::Vector2d(object_R_world * (raster.point(row, column) - place_m)));
    }
  }
}

struct Place {
  Eigen::Vector2d at_m;
  double heading_rad;
};

Place random_place(Rng& rng, const Eigen::Vector2d& from_m, const Eigen::Vector2d& extent_m) {
  const double x = from_m.x() + rng.uniform() * extent_m.x();
  const double y = from_m.y() + rng.uniform() * extent_m.y();
  return {{x, y}, rng.uniform(-kPi, kPi)};
}

const SeabedTextureConfig& checked(const SeabedTextureConfig& config) {
  throw_if_any(violations(config));
  return config;
}

}  // namespace

SeabedTexture::SeabedTexture(const SeabedTextureConfig& config, const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m,
                             std::uint64_t seed)
    : config_(checked(config)),
      extent_m_(to_m - from_m),
      undulation_(from_m, to_m, config.undulation_length_m, Rng(seed).stream("undulation")),
      relief_(from_m, to_m, config.relief_cell_m),
      colours_(from_m, to_m, config.texture_cell_m) {
  const Rng rng(seed);
  for (int row = 0; row < relief_.rows(); ++row) {
    for (int column = 0; column < relief_.columns(); ++column) {
      relief_.at(row, column).depth_m = static_cast<float>(ground_depth_m(relief_.point(row, column)));
    }
  }
  lay_sand(from_m, to_m, rng);
  scatter_stones(rng.stream("stones"));
  scatter_shells(rng.stream("shells"));
  scatter_growth(rng.stream("growth"));
  set_slopes();
}

double SeabedTexture::ground_depth_m(const Eigen::Vector2d& point_m) const {
  return config_.depth_m + config_.slope_north * point_m.x() + config_.slope_east * point_m.y() +
         config_.undulation_m * static_cast<double>(undulation_.at(point_m.x(), point_m.y()));  // (CS-2)
}

SurfacePatch SeabedTexture::surface(double x_m, double y_m) const {
  const Raster<SurfacePatch>::Cell cell = relief_.cell(x_m, y_m);
  const auto mixed = [&](float SurfacePatch::*part) {
    return bilinear(cell.low[0].*part, cell.low[1].*part, cell.high[0].*part, cell.high[1].*part, cell.across, cell.along);
  };
  return {mixed(&SurfacePatch::depth_m), mixed(&SurfacePatch::slope_north), mixed(&SurfacePatch::slope_east)};
}

Albedo SeabedTexture::albedo(double x_m, double y_m) const {
  const Raster<Colour>::Cell cell = colours_.cell(x_m, y_m);
  Albedo mixed;
  for (int channel = 0; channel < 3; ++channel) {
    const auto c = static_cast<std::size_t>(channel);
    mixed(channel) = bilinear(cell.low[0][c], cell.low[1][c], cell.high[0][c], cell.high[1][c], cell.across, cell.along);
  }
  return mixed / 255.0F;
}

void SeabedTexture::lay_sand(const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m, const Rng& rng) {
  std::vector<ValueNoise> octaves;
  for (std::size_t i = 0; i < kOctaves.size(); ++i) {
    octaves.emplace_back(from_m, to_m, std::max(kOctaves[i].length_m, config_.texture_cell_m), rng.stream("grain " + std::to_string(i)));
  }
  const auto contrast = static_cast<float>(config_.grain);
  for (int row = 0; row < colours_.rows(); ++row) {
    for (int column = 0; column < colours_.columns(); ++column) {
      const Eigen::Vector2d at = colours_.point(row, column);
      float sum = 0.0F;
      for (std::size_t i = 0; i < kOctaves.size(); ++i) sum += kOctaves[i].share * octaves[i].at(at.x(), at.y());
      colours_.at(row, column) = stored(kSand * (1.0F + 2.0F * contrast * sum));  // (CS-3)
    }
  }
}

void SeabedTexture::scatter_stones(Rng rng) {
  for (int i = count_of(config_.stones_per_m2); i > 0; --i) {
    const Place place = random_place(rng, relief_.from_m(), extent_m_);
    const double length_m = 0.5 * rng.uniform(0.06, 0.30);
    const double width_m = length_m * rng.uniform(0.6, 1.0);
    const double height_m = 0.45 * width_m;
    const auto brightness = static_cast<float>(rng.uniform(0.55, 1.5));
    const Albedo tint = 1.0F + 0.12F * Albedo(static_cast<float>(rng.uniform(-1, 1)), 0.0F, static_cast<float>(rng.uniform(-1, 1)));
    const auto radius = [&](const Eigen::Vector2d& p) { return std::hypot(p.x() / length_m, p.y() / width_m); };
    draw_around(relief_, place.at_m, place.heading_rad, length_m, [&](SurfacePatch& patch, const Eigen::Vector2d& p) {
      if (radius(p) < 1.0) patch.depth_m -= static_cast<float>(height_m * 0.5 * (1.0 + std::cos(kPi * radius(p))));
    });
    draw_around(colours_, place.at_m, place.heading_rad, length_m, [&](Colour& colour, const Eigen::Vector2d& p) {
      if (radius(p) >= 0.85) return;
      const Albedo sand = Albedo(colour[0], colour[1], colour[2]) / 255.0F;
      colour = stored(brightness * tint * (0.5F * sand + 0.5F * kSand));
    });
  }
}

void SeabedTexture::scatter_shells(Rng rng) {
  for (int i = count_of(config_.shells_per_m2); i > 0; --i) {
    const Place place = random_place(rng, relief_.from_m(), extent_m_);
    const double length_m = 0.5 * rng.uniform(0.01, 0.04);
    const double width_m = length_m * rng.uniform(0.4, 0.9);
    draw_around(colours_, place.at_m, place.heading_rad, length_m, [&](Colour& colour, const Eigen::Vector2d& p) {
      if (std::hypot(p.x() / length_m, p.y() / width_m) < 1.0) colour = stored(kShell);
    });
  }
}

/// Lobed outlines, streaked inside: what a region of interest is found by.
void SeabedTexture::scatter_growth(Rng rng) {
  for (int i = count_of(config_.growth_per_m2); i > 0; --i) {
    const Place place = random_place(rng, relief_.from_m(), extent_m_);
    const double radius_m = 0.5 * rng.uniform(0.15, 0.50);
    const Albedo& growth = kGrowth[static_cast<std::size_t>(rng.below(kGrowth.size()))];
    const double lobes = std::floor(rng.uniform(3.0, 7.0));
    const double depth_of_lobes = rng.uniform(0.1, 0.3);
    const double streaks = rng.uniform(40.0, 90.0);
    draw_around(colours_, place.at_m, place.heading_rad, radius_m * (1.0 + depth_of_lobes), [&](Colour& colour, const Eigen::Vector2d& p) {
      const double angle = std::atan2(p.y(), p.x());
      if (p.norm() > radius_m * (1.0 + depth_of_lobes * std::cos(lobes * angle))) return;
      const double streak = 0.75 + 0.25 * std::cos(streaks * p.x() + 3.0 * std::cos(0.5 * streaks * p.y()));
      const Albedo sand = Albedo(colour[0], colour[1], colour[2]) / 255.0F;
      colour = stored(growth * static_cast<float>(streak) * (0.4F + 0.6F * sand / kSand));
    });
  }
}

void SeabedTexture::set_slopes() {
  const float twice_m = 2.0F * static_cast<float>(relief_.cell_m());
  for (int row = 0; row < relief_.rows(); ++row) {
    for (int column = 0; column < relief_.columns(); ++column) {
      const int r = std::clamp(row, 1, relief_.rows() - 2);
      const int c = std::clamp(column, 1, relief_.columns() - 2);
      SurfacePatch& patch = relief_.at(row, column);
      patch.slope_north = (relief_.at(r + 1, c).depth_m - relief_.at(r - 1, c).depth_m) / twice_m;
      patch.slope_east = (relief_.at(r, c + 1).depth_m - relief_.at(r, c - 1).depth_m) / twice_m;
    }
  }
}

int SeabedTexture::count_of(double per_m2) const { return static_cast<int>(std::lround(per_m2 * extent_m_.x() * extent_m_.y())); }

}  // namespace ssjs
