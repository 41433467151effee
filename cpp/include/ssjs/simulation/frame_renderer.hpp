/// Frames of a camera that looks at a textured seabed by the light of the vehicle's lamp. docs/math/camera_simulation.md (CS-4..CS-9)
///
/// World frame: x north, y east, z down. Camera frame: x along the columns, y along the rows, z ahead.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/geometry/se3.hpp"
#include "ssjs/simulation/seabed_texture.hpp"

namespace ssjs {

struct FrameLightConfig {
  double lamp_forward_m = 0.4, lamp_starboard_m = 0.25, lamp_down_m = 0.0;
  double beam_rad = 0.7;
  double red_per_m = 0.30, green_per_m = 0.10, blue_per_m = 0.13;
  double backscatter = 0.5;
  double blur_px = 0.35;
  double scatter_px_per_m = 0.1;
  double exposure = 105.0;
  double exposed_at_m = 2.5;
  double white_balance = 0.8;
  double shot_noise = 0.2;
  double read_noise = 1.2;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("lamp_forward_m", lamp_forward_m, Rule::any(), "of the lamp in the vehicle, forward; it shines where the camera looks");
    v.field("lamp_starboard_m", lamp_starboard_m, Rule::any(), "... to starboard");
    v.field("lamp_down_m", lamp_down_m, Rule::any(), "... down");
    v.field("beam_rad", beam_rad, Rule::open(0.0, 1.6), "standard deviation of the lamp's beam about its axis");
    v.field("red_per_m", red_per_m, Rule::not_negative(), "attenuation of red light in a metre of water");
    v.field("green_per_m", green_per_m, Rule::not_negative(), "... of green");
    v.field("blue_per_m", blue_per_m, Rule::not_negative(), "... of blue");
    v.field("backscatter", backscatter, Rule::closed(0, 1), "light that the water throws back, of a well lit seabed's");
    v.field("blur_px", blur_px, Rule::closed(0, 10), "of the lens: standard deviation");
    v.field("scatter_px_per_m", scatter_px_per_m, Rule::closed(0, 10), "more of it for a metre of water");
    v.field("exposure", exposure, Rule::closed(1, 255), "level of level sand below the camera at the distance exposed_at_m");
    v.field("exposed_at_m", exposed_at_m, Rule::positive(), "see exposure");
    v.field("white_balance", white_balance, Rule::closed(0, 1),
            "of what the water takes of each colour there, the camera puts back so much");
    v.field("shot_noise", shot_noise, Rule::not_negative(), "variance of a level, for each level");
    v.field("read_noise", read_noise, Rule::not_negative(), "standard deviation of a level in the dark");
  }
};

/// (x/z, y/z) of the ray of every pixel, row by row, as the camera with its lens has it.
struct CameraRays {
  int width_px = 0;
  int height_px = 0;
  std::vector<Eigen::Vector2f> slopes;
};

class FrameRenderer {
 public:
  /// `seabed` must outlive it. Throws InvalidArgument for a configuration out of its rules, or rays that are not one a pixel.
  FrameRenderer(const SeabedTexture& seabed, CameraRays rays, const FrameLightConfig& light, std::uint64_t seed);

  /// Red, green, blue, row by row: the same for the same seed and number, whatever was rendered before and beside it.
  /// Stream "frame <number>" of the seed. The camera must look down.
  [[nodiscard]] std::vector<std::uint8_t> render(const Se3& world_T_vehicle, const Se3& vehicle_T_camera, std::uint64_t number) const;

  /// Where the ray of the slopes (x/z, y/z) meets the seabed; nothing where it does not go down. (CS-4)
  [[nodiscard]] static std::optional<Eigen::Vector3d> seen_point(const SeabedTexture& seabed, const Eigen::Vector3d& world_p_camera,
                                                                 const Eigen::Vector3d& world_direction);

 private:
  void add_noise(const std::vector<float>& levels, std::uint64_t number, std::vector<std::uint8_t>& frame) const;

  const SeabedTexture& seabed_;
  CameraRays rays_;
  FrameLightConfig light_;
  std::uint64_t seed_;
};

}  // namespace ssjs
