/// Vehicle driven by forward speed and turn rate. docs/math/sensors.md (M-5..M-7).
#pragma once

#include "ssjs/base/config_field.hpp"
#include "ssjs/sensors/motion.hpp"

namespace ssjs {

struct VelocityControl {
  double speed_m_s = 0.0;
  double turn_rate_rad_s = 0.0;
};

/// White noise as in AckermanConfig. The *_fraction terms grow with the command: sigma^2 = base^2 + (fraction * |command|)^2.
struct UnicycleConfig {
  double speed_sigma_m_s = 0.05;
  double speed_sigma_fraction = 0.0;
  double turn_rate_sigma_rad_s = 0.1;
  double turn_rate_sigma_fraction = 0.0;
  double lateral_sigma_m_s = 0.0;
  double noise_step_s = 0.1;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("speed_sigma_m_s", speed_sigma_m_s, Rule::positive(), "speed noise of one sample of noise_step_s");
    v.field("speed_sigma_fraction", speed_sigma_fraction, Rule::not_negative(), "speed noise as a fraction of the speed");
    v.field("turn_rate_sigma_rad_s", turn_rate_sigma_rad_s, Rule::positive(), "turn-rate noise of one sample of noise_step_s");
    v.field("turn_rate_sigma_fraction", turn_rate_sigma_fraction, Rule::not_negative(), "turn-rate noise as a fraction of the rate");
    v.field("lateral_sigma_m_s", lateral_sigma_m_s, Rule::not_negative(), "side slip of one sample of noise_step_s");
    v.field("noise_step_s", noise_step_s, Rule::positive(), "length of the sample that the sigmas describe");
  }
};

/// Exact circular arc over dt seconds. No noise is added while both commands are exactly 0.
[[nodiscard]] MotionPrediction predict_unicycle(const Se2& submap_T_vehicle, const VelocityControl& control, double dt_s,
                                                const UnicycleConfig& config);

}  // namespace ssjs
