#include "ssjs/survey/scan_picture.hpp"

#include <algorithm>
#include <cmath>

#include "ssjs/base/angle.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/imaging/speckle.hpp"

namespace ssjs {
namespace {

/// Pixels from the vehicle's to the border.
int reach_px(const ScanPictureConfig& config) { return static_cast<int>(std::ceil(config.max_range_m / config.pixel_m)); }

/// Calls at(row, column, vehicle_p) for the pixels in the square of half a side `reach_m` about a place.
template <class At>
void near(const Eigen::Vector2d& vehicle_p_middle, double reach_m, const cv::Size& size, const ScanPictureConfig& config, const At& at) {
  const cv::Point2d middle = picture_point(vehicle_p_middle, config);
  const double reach = reach_m / config.pixel_m;
  const int first_row = std::max(0, static_cast<int>(std::floor(middle.y - reach)));
  const int last_row = std::min(size.height - 1, static_cast<int>(std::ceil(middle.y + reach)));
  const int first_column = std::max(0, static_cast<int>(std::floor(middle.x - reach)));
  const int last_column = std::min(size.width - 1, static_cast<int>(std::ceil(middle.x + reach)));
  for (int row = first_row; row <= last_row; ++row) {
    for (int column = first_column; column <= last_column; ++column)
      at(row, column, vehicle_point({static_cast<double>(column), static_cast<double>(row)}, config));
  }
}

/// Behind the echo, seen from the sonar, as wide as the echo is from there.
void draw_shadow(const HeardEcho& heard, const ScanPictureConfig& config, cv::Mat& levels) {
  const double range_m = heard.vehicle_p_echo.norm();
  if (heard.echo.shadow_m == 0.0 || range_m == 0.0) return;
  const Eigen::Vector2d away = heard.vehicle_p_echo / range_m;
  const double half_m = 0.5 * heard.echo.shadow_m;
  const double widest_m = heard.echo.radius_m() * (1.0 + heard.echo.shadow_m / range_m);
  near(heard.vehicle_p_echo + half_m * away, half_m + widest_m, levels.size(), config,
       [&](int row, int column, const Eigen::Vector2d& vehicle_p) {
         const double along = vehicle_p.dot(away);
         const double across = away.x() * vehicle_p.y() - away.y() * vehicle_p.x();
         if (along < range_m || along > range_m + heard.echo.shadow_m) return;
         if (std::abs(across) > heard.echo.radius_m() * along / range_m) return;
         levels.at<float>(row, column) = static_cast<float>(config.shadow_part * config.background_level);
       });
}

void draw_echo(const HeardEcho& heard, double vehicle_heading_rad, const ScanPictureConfig& config, cv::Mat& levels, cv::Mat& looks) {
  const Echo& echo = heard.echo;
  const double longer_m = echo.radius_m() * std::sqrt(echo.aspect);
  const double shorter_m = echo.radius_m() / std::sqrt(echo.aspect);
  const double heading = echo.heading_rad - vehicle_heading_rad;
  const double c = std::cos(heading), s = std::sin(heading);
  near(heard.vehicle_p_echo, longer_m, levels.size(), config, [&](int row, int column, const Eigen::Vector2d& vehicle_p) {
    const Eigen::Vector2d d = vehicle_p - heard.vehicle_p_echo;
    const double along = (c * d.x() + s * d.y()) / longer_m;
    const double across = (c * d.y() - s * d.x()) / shorter_m;
    if (along * along + across * across > 1.0) return;
    levels.at<float>(row, column) = static_cast<float>(echo.level);
    looks.at<unsigned char>(row, column) = static_cast<unsigned char>(config.echo_looks);
  });
}

}  // namespace

double Echo::radius_m() const { return std::sqrt(area_m2 / kPi); }

cv::Point2d picture_point(const Eigen::Vector2d& vehicle_p, const ScanPictureConfig& config) {
  const int middle = reach_px(config);
  return {middle - vehicle_p.y() / config.pixel_m, middle - vehicle_p.x() / config.pixel_m};
}

Eigen::Vector2d vehicle_point(const cv::Point2d& pixel, const ScanPictureConfig& config) {
  const int middle = reach_px(config);
  return config.pixel_m * Eigen::Vector2d(middle - pixel.y, middle - pixel.x);
}

SonarImage scan_picture(const std::vector<HeardEcho>& echoes, const Se2& global_T_vehicle, const ScanPictureConfig& config,
                        const Rng& rng) {
  throw_if_any(violations(config));
  if (!(config.max_range_m > config.min_range_m)) throw InvalidArgument("max_range_m", config.max_range_m, "must be above min_range_m");
  const int side = 2 * reach_px(config) + 1;
  cv::Mat levels(side, side, CV_32F, cv::Scalar(config.background_level));
  cv::Mat looks(side, side, CV_8U, cv::Scalar(config.looks));
  std::vector<HeardEcho> far_to_near = echoes;
  std::stable_sort(far_to_near.begin(), far_to_near.end(),
                   [](const HeardEcho& a, const HeardEcho& b) { return a.vehicle_p_echo.squaredNorm() > b.vehicle_p_echo.squaredNorm(); });
  for (const HeardEcho& heard : far_to_near) {
    draw_shadow(heard, config, levels);
    draw_echo(heard, global_T_vehicle.heading, config, levels, looks);
  }
  SonarImage picture{speckled(levels, looks, rng), cv::Mat(side, side, CV_8U)};
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      const double range_m = vehicle_point({static_cast<double>(column), static_cast<double>(row)}, config).norm();
      picture.valid.at<unsigned char>(row, column) = range_m >= config.min_range_m && range_m <= config.max_range_m ? 255 : 0;
    }
  }
  picture.intensity.setTo(0, picture.valid == 0);
  return picture;
}

double centroid_sigma_m(std::int64_t area_px, const ScanPictureConfig& config) {
  const double radius_px = std::sqrt(static_cast<double>(area_px) / kPi);
  return config.pixel_m * std::sqrt(config.edge_px / (4.0 * kPi * radius_px));
}

Feature region_feature(const Region& region, const Eigen::Matrix2d& sensor, const ScanPictureConfig& config) {
  const Eigen::Vector2d vehicle_p = vehicle_point(region.centroid_px, config);
  const double range_m = vehicle_p.norm();
  if (!(range_m > 0.0)) throw InvalidArgument("centroid", range_m, "must not be at the sonar");
  const double sigma_m = centroid_sigma_m(region.area_px, config);
  Feature feature;
  feature.range_bearing << range_m, std::atan2(vehicle_p.y(), vehicle_p.x());
  feature.covariance = sensor;
  feature.covariance(0, 0) += sigma_m * sigma_m;
  feature.covariance(1, 1) += sigma_m * sigma_m / (range_m * range_m);
  return feature;
}

}  // namespace ssjs
