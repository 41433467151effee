/// A point seen by side-scan sonar, abeam of the vehicle. Thesis 5.11, 5.12 corrected; docs/math/auv.md (A-11..A-14).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "ssjs/base/archive.hpp"
#include "ssjs/base/config_field.hpp"
#include "ssjs/sensors/vehicle_state.hpp"

namespace ssjs {

/// What a sighting measures.
enum class SideScanForm {
  kPoint,       ///< x, y, z in the body frame: the height of the point is measured by itself (a shadow, a second receiver)
  kFlatBottom,  ///< x and slant range: the height comes from the seabed state, once, when the landmark is new
};

struct SideScanConfig {
  SideScanForm form = SideScanForm::kPoint;
  double along_track_sigma_m = 0.2;            ///< picking the point in the image
  double timing_sigma_s = 0.05;                ///< times the speed, along track
  double ping_interval_s = 0.1;                ///< times the speed: a point lies anywhere between two pings
  double beam_width_rad = 0.0174532925199433;  ///< times the range: the width of what one ping sees, -3 dB
  double across_sigma_m = 0.2;
  double height_sigma_m = 0.3;        ///< kPoint
  double flat_bottom_sigma_m = 0.35;  ///< kFlatBottom: height of a point above or below the seabed under the vehicle
  double gate_probability = 0.999;
  template <class Visitor>
  void visit(Visitor& v) {
    v.choice("form", form, Choices<SideScanForm>{{"point", SideScanForm::kPoint}, {"flat_bottom", SideScanForm::kFlatBottom}},
             "point: x, y and z are measured; flat_bottom: x and slant range, the depth from the seabed under the vehicle");
    v.field("along_track_sigma_m", along_track_sigma_m, Rule::positive(), "along track: picking the point in the image");
    v.field("timing_sigma_s", timing_sigma_s, Rule::not_negative(), "along track: error of the stamp, times the speed");
    v.field("ping_interval_s", ping_interval_s, Rule::not_negative(), "along track: spacing of the pings, times the speed");
    v.field("beam_width_rad", beam_width_rad, Rule::not_negative(), "along track: width of the beam, times the range");
    v.field("across_sigma_m", across_sigma_m, Rule::positive(), "across track, or along the slant range");
    v.field("height_sigma_m", height_sigma_m, Rule::positive(), "height of a point (form point)");
    v.field("flat_bottom_sigma_m", flat_bottom_sigma_m, Rule::positive(), "height of a point over the seabed (form flat_bottom)");
    v.field("gate_probability", gate_probability, Rule::open(0, 1), "of the pairing of a sighting with a landmark");
  }
};

/// One point of one ping or of one burst of pings. kFlatBottom: y is the slant range with the sign of the side (starboard positive), z
/// is not read.
struct SideScanSighting {
  Eigen::Vector3d vehicle_p_point = Eigen::Vector3d::Zero();  ///< m, body frame
  std::optional<Eigen::Matrix3d> covariance;                  ///< where the detector gives it; m^2
  std::optional<std::int64_t> landmark_id;                    ///< where the source knows it

  void archive(Archive& a) {
    a("vehicle_p_point", vehicle_p_point);
    a("covariance", covariance);
    a("landmark_id", landmark_id);
  }
};

using SideScanSightings = std::vector<SideScanSighting>;

/// diag(x, y, z): the noise of a sighting at this range and speed.
[[nodiscard]] Eigen::Matrix3d side_scan_covariance(double range_m, double speed_m_s, const SideScanConfig& config);

struct SideScanRows {
  VehicleRows vehicle;
  Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 3, 3> H_landmark;
};

/// Residual of a sighting against a landmark (x, y in the map, z depth). Throws InvalidArgument for a landmark at the sonar (kFlatBottom).
[[nodiscard]] SideScanRows side_scan_rows(const VehicleVector& state, const SideScanSighting& sighting,
                                          const Eigen::Vector3d& map_p_landmark, const SideScanConfig& config);

struct SideScanLandmark {
  Eigen::Vector3d map_p_landmark;
  Eigen::Matrix<double, 3, VehicleLayout::kSize> J_vehicle;
  Eigen::Matrix3d noise;  ///< added by the measurement (and the flat bottom)
};

/// Where a sighting puts a new landmark; nothing when it cannot lie on the bottom (kFlatBottom: slant range shorter than the altitude).
[[nodiscard]] std::optional<SideScanLandmark> landmark_from_side_scan(const VehicleVector& state, const SideScanSighting& sighting,
                                                                      const SideScanConfig& config);

}  // namespace ssjs
