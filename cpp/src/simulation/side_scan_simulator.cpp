#include "ssjs/simulation/side_scan_simulator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

constexpr int kPatternSteps = 1024;

/// Gauss-Hermite nodes in standard deviations, with weights: the beam's directions. (SS-30)
struct BeamRay {
  double sigmas;
  double weight;
};
std::vector<BeamRay> beam_rays(int count) {
  if (count == 1) return {{0, 1}};
  if (count == 2) return {{-1, 0.5}, {1, 0.5}};
  const double outer = std::sqrt(3.0);
  return {{-outer, 1.0 / 6.0}, {0, 2.0 / 3.0}, {outer, 1.0 / 6.0}};
}

/// Mean 1, variance 1 / shape. Marsaglia and Tsang 2000; shapes below 1 by a power of a uniform deviate.
double gamma_deviate(Rng& rng, double shape) {
  const double raised = shape < 1 ? shape + 1 : shape;
  const double d = raised - 1.0 / 3.0;
  const double c = 1.0 / std::sqrt(9.0 * d);
  while (true) {
    const double x = rng.normal();
    const double root = 1.0 + c * x;
    if (root <= 0) continue;
    const double v = root * root * root;
    if (std::log(1.0 - rng.uniform()) >= 0.5 * x * x + d - d * v + d * std::log(v)) continue;
    const double boost = shape < 1 ? std::pow(1.0 - rng.uniform(), 1.0 / shape) : 1.0;
    return d * v * boost / shape;
  }
}

/// Mean of `looks` exponential deviates of mean 1. (SS-31)
double speckle_deviate(Rng& rng, int looks) {
  double sum = 0;
  for (int i = 0; i < looks; ++i) sum -= std::log(1.0 - rng.uniform());
  return sum / looks;
}

}  // namespace

/// Ground points of a fan: foot + t * across, t >= 0. (SS-24)
struct SideScanSimulator::Fan {
  Eigen::Vector2d foot_m;
  Eigen::Vector2d across;
};

SideScanSimulator::SideScanSimulator(Seabed seabed, const SideScanSimulationConfig& config, std::uint64_t seed)
    : seabed_(std::move(seabed)), config_(config), spacing_m_(0), speckle_(Rng(seed).stream("speckle")) {
  throw_if_any(violations(config));
  spacing_m_ = config.range_m / config.samples;
  const double decibel = 0.1 * std::log(10.0);
  const double last_gain_db = 30.0 * std::log10(config.range_m) + 2.0 * config.gain_db_m * config.range_m;
  for (int i = 0; i < config.samples; ++i) {
    const double range_m = std::max(i * spacing_m_, spacing_m_);
    // (SS-28) the gain undoes spreading; what it leaves of the absorption stays
    gain_.push_back(std::exp(decibel * 2.0 * (config.gain_db_m - config.absorption_db_m) * range_m));
    const double gain_db = 30.0 * std::log10(range_m) + 2.0 * config.gain_db_m * range_m;
    noise_.push_back(std::exp(decibel * (config.noise_db + gain_db - last_gain_db)));
  }
  const double half_cosine = std::cos(0.5 * config.vertical_beam_rad);
  const double exponent = std::log(0.5) / std::log(half_cosine);  // (SS-29) half the power at half the width
  for (int i = 0; i <= kPatternSteps; ++i) pattern_.push_back(std::pow(static_cast<double>(i) / kPatternSteps, exponent));
}

double SideScanSimulator::pattern(double cosine) const {
  const double place = kPatternSteps * std::clamp(cosine, 0.0, 1.0);
  const auto below = std::min(static_cast<std::size_t>(place), static_cast<std::size_t>(kPatternSteps - 1));
  const double part = place - static_cast<double>(below);
  return pattern_[below] + part * (pattern_[below + 1] - pattern_[below]);
}

SideScanSimulator::Fan SideScanSimulator::fan_of(const SonarPose& pose, SonarSide side, double beam_rad) const {
  const double heading = pose.world_T_sonar.rpy.z();
  const Eigen::Vector2d forward(std::cos(heading), std::sin(heading));
  const Eigen::Vector2d starboard(-std::sin(heading), std::cos(heading));
  const Eigen::Vector2d outward = starboard_sign(side) * starboard;
  const Eigen::Vector2d below = pose.world_T_sonar.translation.head<2>();
  const double altitude_m = seabed_.depth_m(below) - pose.world_T_sonar.translation.z();
  // The plane across the vehicle leans by the pitch: it meets the plane of the seabed so far ahead of the nadir.
  const double lean = std::tan(pose.world_T_sonar.rpy.y());
  const double yield = 1.0 - lean * seabed_.slope().dot(forward);
  Fan fan;
  fan.foot_m = below + forward * (lean * altitude_m / yield);
  fan.across = outward + forward * (lean * seabed_.slope().dot(outward) / yield + std::tan(beam_rad));
  return fan;
}

/// The highest of seabed and objects. Objects far from the line cost a dot product.
void SideScanSimulator::add_objects(const Fan& fan, int count) {
  const double step_m = spacing_m_ / config_.steps_per_sample;
  const double across_squared = fan.across.squaredNorm();
  for (std::size_t k = 0; k < seabed_.objects().size(); ++k) {
    const SeabedObject& object = seabed_.objects()[k];
    const Eigen::Vector2d offset = object.position_m - fan.foot_m;
    const double middle = offset.dot(fan.across) / across_squared;
    const double radius = object.radius_m();
    if ((offset - middle * fan.across).squaredNorm() > radius * radius) continue;
    const int first = std::max(0, static_cast<int>(std::ceil((middle - radius) / step_m)));
    const int last = std::min(count - 1, static_cast<int>(std::floor((middle + radius) / step_m)));
    for (int i = first; i <= last; ++i) {
      const double height_m = object.height_at(fan.foot_m + i * step_m * fan.across);
      if (height_m == 0) continue;
      const auto index = static_cast<std::size_t>(i);
      const double top_m = seabed_.foot_depth_m(k) - height_m;
      if (top_m >= profile_.depth_m[index]) continue;
      profile_.depth_m[index] = top_m;
      profile_.reflectivity[index] = object.reflectivity;
      on_object_[index] = 1;
    }
  }
}

/// (SS-27) A lit part echoes evenly over the samples between its two slant ranges.
void SideScanSimulator::add_echo(double near_m, double far_m, double power) {
  const double low = std::min(near_m, far_m) / spacing_m_ + 0.5;  // sample i covers i - 0.5 .. i + 0.5
  const double high = std::max(near_m, far_m) / spacing_m_ + 0.5;
  const int first = static_cast<int>(low);
  const int last = static_cast<int>(high);
  if (first == last) {
    if (first < config_.samples) power_[static_cast<std::size_t>(first)] += power;
    return;
  }
  const double density = power / (high - low);
  for (int i = first; i <= std::min(last, config_.samples - 1); ++i)
    power_[static_cast<std::size_t>(i)] += density * (std::min<double>(i + 1, high) - std::max<double>(i, low));
}

void SideScanSimulator::add_fan(const SonarPose& pose, SonarSide side, double beam_rad, double weight) {
  const Fan fan = fan_of(pose, side, beam_rad);
  const double step_m = spacing_m_ / config_.steps_per_sample;
  const int count = config_.samples * config_.steps_per_sample + 1;
  seabed_.sample(fan.foot_m, step_m * fan.across, count, profile_);
  on_object_.assign(static_cast<std::size_t>(count), 0);
  add_objects(fan, count);

  const Eigen::Vector2d lead = fan.foot_m - pose.world_T_sonar.translation.head<2>();
  const double lead_squared = lead.squaredNorm();
  const double lead_across = lead.dot(fan.across);
  const double across_squared = fan.across.squaredNorm();
  const double across_length = std::sqrt(across_squared);
  const double axis = config_.depression_rad + starboard_sign(side) * pose.world_T_sonar.rpy.x();
  const double axis_cos = std::cos(axis);
  const double axis_sin = std::sin(axis);
  const double scale = weight / spacing_m_;

  double steepest = std::numeric_limits<double>::infinity();  // (SS-25) the lowest h / t so far: what has a larger one is hidden
  double t = 0;
  double h = profile_.depth_m[0] - pose.world_T_sonar.translation.z();
  double range = std::sqrt(lead_squared + h * h);
  for (std::size_t i = 1; i < profile_.depth_m.size(); ++i) {
    const double t_next = static_cast<double>(i) * step_m;
    const double h_next = profile_.depth_m[i] - pose.world_T_sonar.translation.z();
    const double range_next = std::sqrt(lead_squared + 2.0 * t_next * lead_across + t_next * t_next * across_squared + h_next * h_next);
    if (h_next < steepest * t_next) {
      double lit = 1.0;
      double range_lit = range;
      const double fall = h_next - h;
      if (t > 0 && h > steepest * t) {  // (SS-26) the part beyond the ray that closed the shadow
        const double hidden = std::clamp((h - steepest * t) / (steepest * step_m - fall), 0.0, 1.0);
        lit = 1.0 - hidden;
        range_lit = range + hidden * (range_next - range);
      }
      const double t_mid = 0.5 * (t + t_next) * across_length;
      const double h_mid = 0.5 * (h + h_next);
      const double run = step_m * across_length;
      const double distance_squared = t_mid * t_mid + h_mid * h_mid;
      const double length_squared = run * run + fall * fall;
      const double cross = run * h_mid - fall * t_mid;  // sine of the grazing angle times both lengths
      const double grazing_squared = cross * cross / (distance_squared * length_squared);
      const double cosine = (t_mid * axis_cos + h_mid * axis_sin) / std::sqrt(distance_squared);
      const double reflectivity = std::max(profile_.reflectivity[i - 1] * on_object_[i - 1], profile_.reflectivity[i] * on_object_[i]);
      const double sediment = on_object_[i - 1] != 0 || on_object_[i] != 0 ? reflectivity : profile_.reflectivity[i];
      add_echo(range_lit, range_next, scale * sediment * grazing_squared * std::sqrt(length_squared) * lit * pattern(cosine));
      steepest = h_next / t_next;
    }
    t = t_next;
    h = h_next;
    range = range_next;
  }
}

std::vector<double> SideScanSimulator::mean_power(const SonarPose& pose, SonarSide side) {
  power_.assign(static_cast<std::size_t>(config_.samples), 0.0);
  const double sigma = config_.beam_width_rad / (2.0 * std::sqrt(2.0 * std::log(2.0)));
  for (const BeamRay& ray : beam_rays(config_.beam_rays)) add_fan(pose, side, sigma * ray.sigmas, ray.weight);
  for (std::size_t i = 0; i < power_.size(); ++i) power_[i] *= gain_[i];
  return power_;
}

SideScanPing SideScanSimulator::ping(const SonarPose& pose) {
  if (!pose.world_T_sonar.translation.allFinite())
    throw InvalidArgument("pose.world_T_sonar", pose.world_T_sonar.translation.x(), "must be finite");
  SideScanPing ping;
  ping.time_s = pose.time_s;
  ping.number = next_number_++;
  ping.north_m = pose.world_T_sonar.translation.x();
  ping.east_m = pose.world_T_sonar.translation.y();
  ping.depth_m = pose.world_T_sonar.translation.z();
  ping.altitude_m = seabed_.depth_m(pose.world_T_sonar.translation.head<2>()) - pose.world_T_sonar.translation.z();
  if (!(ping.altitude_m > 0))
    throw InvalidArgument("pose.world_T_sonar", pose.world_T_sonar.translation.z(), "the sonar must be above the seabed");
  ping.heading_rad = pose.world_T_sonar.rpy.z() < 0 ? pose.world_T_sonar.rpy.z() + 2.0 * kPi : pose.world_T_sonar.rpy.z();
  ping.roll_rad = pose.world_T_sonar.rpy.x();
  ping.pitch_rad = pose.world_T_sonar.rpy.y();
  ping.speed_m_s = pose.speed_m_s;
  ping.sound_speed_m_s = config_.sound_speed_m_s;
  for (const SonarSide side : {SonarSide::kPort, SonarSide::kStarboard}) {
    SideScanChannel channel;
    channel.side = side;
    channel.frequency_hz = config_.frequency_hz;
    channel.sample_interval_s = 2.0 * spacing_m_ / config_.sound_speed_m_s;
    const std::vector<double> power = mean_power(pose, side);
    channel.samples.reserve(power.size());
    for (std::size_t i = 0; i < power.size(); ++i) {
      const double texture = config_.texture_shape > 0 ? gamma_deviate(speckle_, config_.texture_shape) : 1.0;
      const double transmitted = static_cast<double>(i) * spacing_m_ < config_.transmit_m ? 4.0 : 0.0;
      const double mean = power[i] * texture + noise_[i] + transmitted;
      channel.samples.push_back(static_cast<float>(config_.echo_level * std::sqrt(mean * speckle_deviate(speckle_, config_.looks))));
    }
    ping.channels.push_back(std::move(channel));
  }
  find_sightings(pose, ping.number);
  return ping;
}

void SideScanSimulator::find_sightings(const SonarPose& pose, std::uint32_t number) {
  const std::vector<SeabedObject>& objects = seabed_.objects();
  const Eigen::Matrix3d world_R_body = pose.world_T_sonar.rotation();
  sightings_.clear();
  const bool is_first = !last_pose_;
  ahead_m_.resize(objects.size(), 0.0);
  for (std::size_t k = 0; k < objects.size(); ++k) {
    const Eigen::Vector3d foot(objects[k].position_m.x(), objects[k].position_m.y(), seabed_.foot_depth_m(k));
    const Eigen::Vector3d body_p_object = world_R_body.transpose() * (foot - pose.world_T_sonar.translation);
    const double before = ahead_m_[k];
    ahead_m_[k] = body_p_object.x();
    if (is_first || (before < 0) == (ahead_m_[k] < 0)) continue;
    const bool is_last = std::abs(before) < std::abs(ahead_m_[k]);  // the ping before was nearer
    const SonarPose& nearer = is_last ? *last_pose_ : pose;
    ObjectSighting sighting;
    sighting.object = objects[k].id;
    sighting.ping = is_last ? number - 1 : number;
    sighting.body_p_object = nearer.world_T_sonar.rotation().transpose() * (foot - nearer.world_T_sonar.translation);
    sighting.side = sighting.body_p_object.y() < 0 ? SonarSide::kPort : SonarSide::kStarboard;
    sighting.slant_range_m = (foot - Eigen::Vector3d(0, 0, objects[k].height_m) - nearer.world_T_sonar.translation).norm();
    if (sighting.slant_range_m > config_.range_m) continue;
    sighting.sample = sighting.slant_range_m / spacing_m_;
    sightings_.push_back(sighting);
  }
  last_pose_ = pose;
}

}  // namespace ssjs
