#include "ssjs/features/tree_detector.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "ssjs/base/angle.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

/// Neighbouring returns on one surface.
struct Object {
  Eigen::Index first_beam = 0;
  Eigen::Index last_beam = 0;
  int returns = 0;
  Eigen::Vector2d sensor_p_first = Eigen::Vector2d::Zero();  ///< where the first boundary beam hit
  Eigen::Vector2d sensor_p_last = Eigen::Vector2d::Zero();
  bool is_clear = true;
};

void check(const LaserScan& scan, const TreeDetectorConfig& config) {
  throw_if_any(violations(config));
  if (config.min_range_m >= config.max_range_m) {
    throw InvalidArgument("TreeDetectorConfig.min_range_m", config.min_range_m,
                          "must be below max_range_m = " + std::to_string(config.max_range_m));
  }
  if (config.min_diameter_m >= config.max_diameter_m) {
    throw InvalidArgument("TreeDetectorConfig.min_diameter_m", config.min_diameter_m,
                          "must be below max_diameter_m = " + std::to_string(config.max_diameter_m));
  }
  if (!std::isfinite(scan.first_angle_rad)) throw InvalidArgument("LaserScan.first_angle_rad", scan.first_angle_rad, "must be finite");
  if (!std::isfinite(scan.step_rad) || scan.step_rad == 0.0) {
    throw InvalidArgument("LaserScan.step_rad", scan.step_rad, "must be finite and not zero");
  }
  if (config.masked_beams >= scan.range_m.size()) {
    throw InvalidArgument("TreeDetectorConfig.masked_beams", std::to_string(config.masked_beams),
                          "must leave some of the " + std::to_string(scan.range_m.size()) + " beams of the scan");
  }
}

class Detector {
 public:
  Detector(const LaserScan& scan, const TreeDetectorConfig& config) : scan_(scan), config_(config) {}

  [[nodiscard]] std::vector<Trunk> run() {
    collect_objects();
    mark_crowded_objects();
    mark_covered_objects();
    std::vector<Trunk> trunks;
    for (const Object& object : objects_) {
      if (!object.is_clear || object.returns < config_.min_beams) continue;
      // A trunk at the border of the sweep may go on beyond it.
      if (object.first_beam == config_.masked_beams || object.last_beam == scan_.range_m.size() - 1) continue;
      const Trunk trunk = fit(object);
      const double slant = std::abs(scan_.range_m(object.first_beam) - scan_.range_m(object.last_beam));
      if (slant > config_.max_slant * trunk.diameter_m) continue;  // (T-4)
      if (trunk.diameter_m < config_.min_diameter_m || trunk.diameter_m > config_.max_diameter_m) continue;
      if (trunk.range_m < config_.min_range_m || trunk.range_m > config_.max_range_m) continue;
      trunks.push_back(trunk);
    }
    return trunks;
  }

 private:
  [[nodiscard]] bool is_return(Eigen::Index beam) const {
    const double range = scan_.range_m(beam);
    return range > 0.0 && range < config_.no_return_m;  // false for NaN
  }

  [[nodiscard]] double angle(double beam) const { return scan_.first_angle_rad + beam * scan_.step_rad; }

  void collect_objects() {  // (T-1)
    for (Eigen::Index beam = config_.masked_beams; beam < scan_.range_m.size(); ++beam) {
      if (!is_return(beam)) continue;
      const double range = scan_.range_m(beam);
      const Eigen::Vector2d sensor_p_hit(range * std::cos(angle(static_cast<double>(beam))),
                                         range * std::sin(angle(static_cast<double>(beam))));
      const bool goes_on = !objects_.empty() && beam - objects_.back().last_beam <= config_.max_missing_beams + 1 &&
                           std::abs(range - scan_.range_m(objects_.back().last_beam)) <= config_.max_range_jump_m;
      if (!goes_on) {
        objects_.emplace_back();
        objects_.back().first_beam = beam;
        objects_.back().sensor_p_first = sensor_p_hit;
      }
      objects_.back().last_beam = beam;
      objects_.back().sensor_p_last = sensor_p_hit;
      ++objects_.back().returns;
    }
  }

  void mark_crowded_objects() {  // (T-2)
    const double min_squared = config_.min_clearance_m * config_.min_clearance_m;
    for (std::size_t a = 0; a < objects_.size(); ++a) {
      for (std::size_t b = a + 1; b < objects_.size(); ++b) {
        if ((objects_[b].sensor_p_first - objects_[a].sensor_p_last).squaredNorm() < min_squared) {
          objects_[a].is_clear = false;
          objects_[b].is_clear = false;
        }
      }
    }
  }

  /// Where two objects meet in neighbouring beams, the farther one goes on behind the nearer: its boundary beam is no tangent.
  void mark_covered_objects() {  // (T-3)
    for (std::size_t b = 1; b < objects_.size(); ++b) {
      Object& left = objects_[b - 1];
      Object& right = objects_[b];
      if (right.first_beam - left.last_beam != 1) continue;
      (scan_.range_m(right.first_beam) > scan_.range_m(left.last_beam) ? right : left).is_clear = false;
    }
  }

  /// The return nearest to the bisector; the mean of two where they are equally near.
  [[nodiscard]] double middle_range(const Object& object) const {
    const Eigen::Index sum = object.first_beam + object.last_beam;
    for (Eigen::Index left = sum / 2, right = sum - left;; --left, ++right) {  // ends at the boundary beams, which are returns
      if (is_return(left) && is_return(right)) return 0.5 * (scan_.range_m(left) + scan_.range_m(right));
      if (is_return(left)) return scan_.range_m(left);
      if (is_return(right)) return scan_.range_m(right);
    }
  }

  [[nodiscard]] Trunk fit(const Object& object) const {
    // Every beam stands for one step, so the tangents lie half a step outside the boundary beams.
    const double half_angle = 0.5 * std::abs(scan_.step_rad) * static_cast<double>(object.last_beam - object.first_beam + 1);
    const double tangent_length = 0.5 * (scan_.range_m(object.first_beam) + scan_.range_m(object.last_beam));
    Trunk trunk;
    trunk.diameter_m = 2.0 * tangent_length * std::sin(half_angle);                                          // (T-5) the chord
    trunk.range_m = middle_range(object) + 0.5 * trunk.diameter_m;                                           // (T-6)
    trunk.bearing_rad = wrap_angle(angle(0.5 * static_cast<double>(object.first_beam + object.last_beam)));  // the bisector
    return trunk;
  }

  const LaserScan& scan_;
  const TreeDetectorConfig& config_;
  std::vector<Object> objects_;
};

}  // namespace

std::vector<Trunk> detect_trunks(const LaserScan& scan, const TreeDetectorConfig& config) {
  if (scan.range_m.size() == 0) return {};
  check(scan, config);
  return Detector(scan, config).run();
}

}  // namespace ssjs
