#include "ssjs/io/ping_fields.hpp"

namespace ssjs {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kSlowest_m_s = 1300.0, kFastest_m_s = 1800.0;  ///< in any natural water
constexpr double kUsual_m_s = 1500.0;

bool is_sound_speed(double speed_m_s) { return speed_m_s >= kSlowest_m_s && speed_m_s <= kFastest_m_s; }

}  // namespace

double value_within(double value, double low, double high) { return value >= low && value <= high ? value : SideScanPing::kUnknown; }

double heading_from_degrees(double degrees) {
  const double known = value_within(degrees, -360.0, 360.0);
  const double positive = known < 0.0 ? known + 360.0 : known;
  return (positive >= 360.0 ? positive - 360.0 : positive) * kPi / 180.0;
}

double tilt_from_degrees(double degrees) { return value_within(degrees, -180.0, 180.0) * kPi / 180.0; }

bool is_geographic(double latitude_deg, double longitude_deg) {
  if (latitude_deg == 0.0 && longitude_deg == 0.0) return false;
  return std::abs(latitude_deg) <= 90.0 && std::abs(longitude_deg) <= 180.0;
}

SoundSpeed sound_speed_of(double field_m_s, double computed_m_s, double range_m, double duration_s) {
  if (is_sound_speed(field_m_s)) return {field_m_s, "field"};
  if (is_sound_speed(2.0 * field_m_s)) return {2.0 * field_m_s, "field, doubled"};
  if (is_sound_speed(computed_m_s)) return {computed_m_s, "computed field"};
  if (duration_s > 0.0 && is_sound_speed(2.0 * range_m / duration_s)) return {2.0 * range_m / duration_s, "range and duration"};
  return {kUsual_m_s, "assumed 1500 m/s"};
}

}  // namespace ssjs
