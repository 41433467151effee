/// Car-like vehicle with a wheel encoder on the rear left wheel. Thesis 3.17, 3.18 corrected; docs/math/sensors.md (M-1..M-4).
#pragma once

#include "ssjs/base/config_field.hpp"
#include "ssjs/sensors/motion.hpp"

namespace ssjs {

struct AckermanControl {
  double speed_m_s = 0.0;     ///< of the encoder wheel
  double steering_rad = 0.0;  ///< positive turns left
};

/// Dimensions, calibration and noise. Noise is white: a sigma is the standard deviation of one sample held for noise_step_s,
/// so a step of length dt has variance sigma^2 * noise_step_s / dt, and cutting a step in two changes nothing.
struct AckermanConfig {
  double wheelbase_m = 2.83;          ///< L
  double encoder_offset_m = 0.76;     ///< H, rear axle centre to the encoder wheel
  double reference_forward_m = 3.78;  ///< a, rear axle to the state's reference point, forward
  double reference_left_m = 0.5;      ///< b, the same, to the left
  double steering_scale = 1.0;        ///< true steering = scale * measured + offset
  double steering_offset_rad = 0.0;
  double speed_sigma_m_s = 0.5;
  double steering_sigma_rad = 0.0349;
  double lateral_sigma_m_s = 0.0;  ///< side slip
  double noise_step_s = 0.025;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("wheelbase_m", wheelbase_m, Rule::positive(), "distance between the axles (L)");
    v.field("encoder_offset_m", encoder_offset_m, Rule::any(), "rear axle centre to the encoder wheel, positive to the left (H)");
    v.field("reference_forward_m", reference_forward_m, Rule::any(), "rear axle to the tracked point, forward (a)");
    v.field("reference_left_m", reference_left_m, Rule::any(), "rear axle to the tracked point, left (b)");
    v.field("steering_scale", steering_scale, Rule::positive(), "true steering = scale * measured + offset");
    v.field("steering_offset_rad", steering_offset_rad, Rule::closed(-0.5, 0.5), "true steering = scale * measured + offset");
    v.field("speed_sigma_m_s", speed_sigma_m_s, Rule::positive(), "speed noise of one sample of noise_step_s");
    v.field("steering_sigma_rad", steering_sigma_rad, Rule::positive(), "steering noise of one sample of noise_step_s");
    v.field("lateral_sigma_m_s", lateral_sigma_m_s, Rule::not_negative(), "side slip of one sample of noise_step_s");
    v.field("noise_step_s", noise_step_s, Rule::positive(), "length of the sample that the sigmas describe");
  }
};

/// Holds the control for dt seconds. No noise is added while the vehicle stands still (speed exactly 0).
[[nodiscard]] MotionPrediction predict_ackerman(const Se2& submap_T_vehicle, const AckermanControl& control, double dt_s,
                                                const AckermanConfig& config);

/// Throws InvalidArgument for a command that predict_ackerman() would refuse.
void check_drivable(const AckermanControl& control, const AckermanConfig& config);

}  // namespace ssjs
