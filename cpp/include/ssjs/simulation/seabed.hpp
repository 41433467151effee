/// A simulated seabed with objects on it. docs/math/side_scan.md (SS-20) to (SS-22)
///
/// World frame: x north, y east, z down from the surface, m.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "ssjs/base/angle.hpp"
#include "ssjs/base/config_field.hpp"
#include "ssjs/base/random.hpp"

namespace ssjs {

struct SeabedConfig {
  double depth_m = 20.0;
  double slope_north = 0.0;
  double slope_east = 0.0;
  double undulation_m = 0.1;
  double undulation_length_m = 40.0;
  double ripple_m = 0.02;
  double ripple_length_m = 0.6;
  double ripple_heading_rad = 0.6;
  double patch_length_m = 25.0;
  double patch_contrast = 0.5;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("depth_m", depth_m, Rule::positive(), "of the seabed's plane at the origin");
    v.field("slope_north", slope_north, Rule::closed(-1, 1), "metres by which the seabed falls for a metre to the north");
    v.field("slope_east", slope_east, Rule::closed(-1, 1), "and to the east");
    v.field("undulation_m", undulation_m, Rule::not_negative(), "standard deviation of the long waves of the seabed");
    v.field("undulation_length_m", undulation_length_m, Rule::positive(), "shortest of their wavelengths; the longest is twice as long");
    v.field("ripple_m", ripple_m, Rule::not_negative(), "amplitude of the ripples, which grow where the sediment is bright");
    v.field("ripple_length_m", ripple_length_m, Rule::positive(), "their wavelength");
    v.field("ripple_heading_rad", ripple_heading_rad, Rule::any(), "direction across their crests, from north to east");
    v.field("patch_length_m", patch_length_m, Rule::positive(),
            "shortest wavelength of the sediment patches; the longest is twice as long");
    v.field("patch_contrast", patch_contrast, Rule{0, 1, false, true}, "echo of sediment lies between 1 - contrast and 1 + contrast");
  }
};

enum class ObjectShape {
  kBox,       ///< with a flat top and upright sides
  kCylinder,  ///< lying along its length: an ellipse of width and height in section, upright below its middle
  kDome,      ///< half an ellipsoid, such as a boulder or a sphere sunk in to its middle
  kCone,      ///< cut off at half its radius, as a moored mine's sinker or a manta mine
};

inline const Choices<ObjectShape> kObjectShapes = {
    {"box", ObjectShape::kBox}, {"cylinder", ObjectShape::kCylinder}, {"dome", ObjectShape::kDome}, {"cone", ObjectShape::kCone}};

/// One object. It stands on the depth that the seabed has below its centre.
struct SeabedObject {
  std::int64_t id = 0;
  ObjectShape shape = ObjectShape::kBox;
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();  ///< of its centre: north, east
  double heading_rad = 0.0;                              ///< of its length
  double length_m = 1.0;
  double width_m = 1.0;
  double height_m = 0.5;
  double reflectivity = 8.0;  ///< echo strength (power) over that of mean sediment

  /// Height above its foot at a point of the plane; 0 beside it.
  [[nodiscard]] double height_at(const Eigen::Vector2d& point_m) const;
  [[nodiscard]] double radius_m() const;  ///< of the circle around its plan
};

/// Objects drawn one by one: shapes in turn, lengths 0.8 to 2.5 m, places uniform over the rectangle and at least `clearance_m` apart.
/// Stream "objects" of the seed. Throws InvalidArgument where there is no room for so many.
[[nodiscard]] std::vector<SeabedObject> scatter_objects(int count, const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m,
                                                        double clearance_m, std::uint64_t seed);

/// What a line over the seabed meets, without objects.
struct SeabedProfile {
  std::vector<double> depth_m;
  std::vector<double> reflectivity;  ///< power, about 1
  std::vector<double> ripples_m;     ///< height of full ripples, before the sediment damps them
};

class Seabed {
 public:
  /// Waves take their directions and phases from the stream "seabed" of the seed.
  Seabed(const SeabedConfig& config, std::vector<SeabedObject> objects, std::uint64_t seed);

  [[nodiscard]] double depth_m(const Eigen::Vector2d& point_m) const;       ///< of the seabed without objects
  [[nodiscard]] double reflectivity(const Eigen::Vector2d& point_m) const;  ///< likewise
  /// At start + i * step, i = 0 .. count - 1. `profile` keeps its memory.
  void sample(const Eigen::Vector2d& start_m, const Eigen::Vector2d& step_m, int count, SeabedProfile& profile) const;
  [[nodiscard]] Eigen::Vector2d slope() const { return slope_; }   ///< of the plane: towards north, towards east
  [[nodiscard]] double plane_depth_m() const { return depth_m_; }  ///< of the plane at the origin
  [[nodiscard]] const std::vector<SeabedObject>& objects() const { return objects_; }
  [[nodiscard]] double foot_depth_m(std::size_t object) const { return foot_depths_m_[object]; }

 private:
  /// amplitude * cos(wave . point + phase)
  struct Wave {
    Eigen::Vector2d wave;
    double phase = 0;
    double amplitude = 0;
  };
  static double at(const std::vector<Wave>& waves, const Eigen::Vector2d& point_m);
  static void add(const std::vector<Wave>& waves, const Eigen::Vector2d& start_m, const Eigen::Vector2d& step_m, int count,
                  std::vector<double>& sum);
  static std::vector<Wave> random_waves(Rng& rng, int count, double shortest_m, double sigma);

  double depth_m_;
  Eigen::Vector2d slope_;
  double patch_contrast_;
  std::vector<Wave> undulations_;
  std::vector<Wave> ripples_;
  std::vector<Wave> patches_;
  std::vector<SeabedObject> objects_;
  std::vector<double> foot_depths_m_;
};

}  // namespace ssjs
