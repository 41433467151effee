/// A position fix as a levelled map hands it on: seen from one of its two bases. docs/math/ports.md (P-30).
#pragma once

#include <Eigen/Core>
#include <optional>

#include "ssjs/sensors/constant_velocity.hpp"
#include "ssjs/sensors/position_fix.hpp"

namespace ssjs {

struct BaseFix {
  double time_s = 0.0;
  Eigen::Vector2d base_p_vehicle = Eigen::Vector2d::Zero();  ///< where the vehicle was at the fix, m; 0 where the fix came with the base
  PositionFix fix;                                           ///< its covariance with what the way from the fix to the base adds

  void archive(Archive& a) {
    a("time_s", time_s);
    a("base_p_vehicle", base_p_vehicle);
    a("fix", fix);
  }
};

/// Keeps the newest fix until a map can be closed for it.
class FixKeeper {
 public:
  /// interval_s: between two fixes that are used; nothing: none is.
  explicit FixKeeper(std::optional<double> interval_s) : interval_s_(interval_s) {}

  /// The vehicle being at `vehicle` in the present map. A fix within the interval is left aside, but not one that an operator sets.
  void keep(double time_s, const PositionFix& fix, const VehicleVector& vehicle);

  [[nodiscard]] bool waits() const { return kept_.has_value(); }
  [[nodiscard]] double kept_s() const { return kept_->time_s; }

  /// The kept one from the base that stands where the vehicle is now; nothing when none waits. The keeper is empty then.
  [[nodiscard]] std::optional<BaseFix> take(double time_s, const VehicleVector& vehicle, const VehicleMatrix& covariance);

 private:
  struct Kept {
    double time_s;
    PositionFix fix;
    Eigen::Vector2d map_p_vehicle;

    void archive(Archive& a) {
      a("time_s", time_s);
      a("fix", fix);
      a("map_p_vehicle", map_p_vehicle);
    }
  };
  std::optional<double> interval_s_;
  std::optional<double> used_s_;
  std::optional<Kept> kept_;

 public:
  void archive(Archive& a) {
    a("used_s", used_s_);
    a("kept", kept_);
  }
};

}  // namespace ssjs
