/// A scan as the picture that a sonar gives of it, and the picture's regions as observations. docs/math/scan_pictures.md to
///
/// The picture is a metric grid about the vehicle: row 0 ahead, column 0 to port, the vehicle in the middle pixel. What lies nearer than
/// the least or farther than the greatest range is invalid.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/base/random.hpp"
#include "ssjs/features/feature.hpp"
#include "ssjs/geometry/se2.hpp"
#include "ssjs/imaging/regions.hpp"
#include "ssjs/imaging/sonar_image.hpp"

namespace ssjs {

/// Something on the seabed that echoes: an oval.
struct Echo {
  double area_m2 = 0.0;
  double aspect = 1.0;       ///< longer to shorter axis
  double heading_rad = 0.0;  ///< of the longer axis, global frame
  double level = 0.0;        ///< mean, of 0 .. 255
  double shadow_m = 0.0;     ///< length of the shadow behind it; 0: flat

  [[nodiscard]] double radius_m() const;  ///< of the circle of its area
};

struct ScanPictureConfig {
  double pixel_m = 0.2;
  double min_range_m = 1.0;
  double max_range_m = 30.0;
  double background_level = 55.0;
  int looks = 6;
  int echo_looks = 16;
  double shadow_part = 0.2;
  double edge_px = 4.0;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("pixel_m", pixel_m, Rule{0.02, 10.0, true, true}, "side of a pixel");
    v.field("min_range_m", min_range_m, Rule::not_negative(), "nothing nearer is seen");
    v.field("max_range_m", max_range_m, Rule::positive(), "nothing farther is seen");
    v.field("background_level", background_level, Rule::positive(), "mean level of the seabed");
    v.field("looks", looks, Rule::closed(1, 255), "of the speckle on the seabed: the more, the smoother");
    v.field("echo_looks", echo_looks, Rule::closed(1, 255), "of the speckle on what echoes");
    v.field("shadow_part", shadow_part, Rule::closed(0, 1), "level of a shadow as a part of the seabed's");
    v.field("edge_px", edge_px, Rule::positive(), "width of a region's edge in which speckle decides over a pixel");
  }
};

/// One echo and where the sonar heard it.
struct HeardEcho {
  Echo echo;
  Eigen::Vector2d vehicle_p_echo = Eigen::Vector2d::Zero();
  std::int64_t id = 0;
};

/// The echoes with their shadows on a seabed of speckle., (Q-2) Nearer shadows lie over farther echoes.
[[nodiscard]] SonarImage scan_picture(const std::vector<HeardEcho>& echoes, const Se2& global_T_vehicle, const ScanPictureConfig& config,
                                      const Rng& rng);

/// Where a place in the picture lies, vehicle frame, and back.
[[nodiscard]] Eigen::Vector2d vehicle_point(const cv::Point2d& pixel, const ScanPictureConfig& config);
[[nodiscard]] cv::Point2d picture_point(const Eigen::Vector2d& vehicle_p, const ScanPictureConfig& config);

/// Standard deviation of the centroid of a region of so many pixels, in each direction.
[[nodiscard]] double centroid_sigma_m(std::int64_t area_px, const ScanPictureConfig& config);

/// A region's centroid as range and bearing; the covariance holds that of the centroid beside `sensor`, the sonar's own.
[[nodiscard]] Feature region_feature(const Region& region, const Eigen::Matrix2d& sensor, const ScanPictureConfig& config);

}  // namespace ssjs
