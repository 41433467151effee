#include "ssjs/simulation/seabed.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

/// From -1 to 1, steep at 0: patches have edges. (SS-21)
double patch(double sum) { return 2.0 * sum / std::sqrt(1.0 + 4.0 * sum * sum); }

double dome(double relative_radius_squared) { return std::sqrt(std::max(0.0, 1.0 - relative_radius_squared)); }

}  // namespace

// (SS-22)
double SeabedObject::height_at(const Eigen::Vector2d& point_m) const {
  const Eigen::Vector2d offset = point_m - position_m;
  const double c = std::cos(heading_rad);
  const double s = std::sin(heading_rad);
  const double along = 2.0 * (c * offset.x() + s * offset.y()) / length_m;  // -1 .. 1 on the object
  const double across = 2.0 * (c * offset.y() - s * offset.x()) / width_m;
  const double radius_squared = along * along + across * across;
  switch (shape) {
    case ObjectShape::kBox:
      return std::abs(along) <= 1.0 && std::abs(across) <= 1.0 ? height_m : 0.0;
    case ObjectShape::kCylinder:
      return std::abs(along) <= 1.0 && std::abs(across) <= 1.0 ? 0.5 * height_m * (1.0 + dome(across * across)) : 0.0;
    case ObjectShape::kDome:
      return height_m * dome(radius_squared);
    case ObjectShape::kCone:
      return radius_squared < 1.0 ? height_m * std::min(1.0, 2.0 * (1.0 - std::sqrt(radius_squared))) : 0.0;
  }
  return 0.0;
}

double SeabedObject::radius_m() const { return 0.5 * std::hypot(length_m, width_m); }

std::vector<SeabedObject> scatter_objects(int count, const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m, double clearance_m,
                                          std::uint64_t seed) {
  constexpr int kTries = 10000;
  Rng rng = Rng(seed).stream("objects");
  std::vector<SeabedObject> objects;
  for (int i = 0; i < count; ++i) {
    SeabedObject object;
    object.id = i;
    object.shape = kObjectShapes[static_cast<std::size_t>(i) % kObjectShapes.size()].second;
    object.length_m = rng.uniform(0.8, 2.5);
    object.width_m = object.shape == ObjectShape::kCone ? object.length_m : rng.uniform(0.5, 1.0) * object.length_m;
    if (object.shape == ObjectShape::kCylinder) object.width_m = rng.uniform(0.4, 0.7);
    object.height_m = object.shape == ObjectShape::kCylinder ? object.width_m : rng.uniform(0.35, 1.0);
    object.heading_rad = rng.uniform(-kPi, kPi);
    object.reflectivity = rng.uniform(5.0, 12.0);
    int tries = 0;
    const auto is_free = [&](const Eigen::Vector2d& place) {
      return std::none_of(objects.begin(), objects.end(),
                          [&](const SeabedObject& other) { return (other.position_m - place).norm() < clearance_m; });
    };
    do {
      if (++tries > kTries) throw InvalidArgument("count", count, "there is no room for so many objects; take fewer or less clearance");
      object.position_m = {rng.uniform(from_m.x(), to_m.x()), rng.uniform(from_m.y(), to_m.y())};
    } while (!is_free(object.position_m));
    objects.push_back(object);
  }
  return objects;
}

std::vector<Seabed::Wave> Seabed::random_waves(Rng& rng, int count, double shortest_m, double sigma) {
  std::vector<Wave> waves;
  for (int i = 0; i < count; ++i) {
    const double heading = rng.uniform(-kPi, kPi);
    const double number = 2.0 * kPi / (shortest_m * rng.uniform(1.0, 2.0));
    waves.push_back({{number * std::cos(heading), number * std::sin(heading)}, rng.uniform(-kPi, kPi), sigma * std::sqrt(2.0 / count)});
  }
  return waves;
}

Seabed::Seabed(const SeabedConfig& config, std::vector<SeabedObject> objects, std::uint64_t seed)
    : depth_m_(config.depth_m),
      slope_(config.slope_north, config.slope_east),
      patch_contrast_(config.patch_contrast),
      objects_(std::move(objects)) {
  throw_if_any(violations(config));
  Rng rng = Rng(seed).stream("seabed");
  undulations_ = random_waves(rng, 4, config.undulation_length_m, config.undulation_m);
  patches_ = random_waves(rng, 6, config.patch_length_m, 1.0);
  for (const double turn : {-0.12, 0.12}) {  // two trains at a small angle: crests that begin, end and fork
    const double number = 2.0 * kPi / config.ripple_length_m * (1.0 + 0.3 * turn);
    const double heading = config.ripple_heading_rad + turn;
    ripples_.push_back({{number * std::cos(heading), number * std::sin(heading)}, rng.uniform(-kPi, kPi), 0.5 * config.ripple_m});
  }
  for (const SeabedObject& object : objects_) {
    if (!(object.length_m > 0) || !(object.width_m > 0) || !(object.height_m > 0) || !object.position_m.allFinite())
      throw InvalidArgument("objects", static_cast<double>(object.id), "length, width and height must be positive, its place finite");
    foot_depths_m_.push_back(depth_m(object.position_m));
  }
}

double Seabed::at(const std::vector<Wave>& waves, const Eigen::Vector2d& point_m) {
  double sum = 0;
  for (const Wave& wave : waves) sum += wave.amplitude * std::cos(wave.wave.dot(point_m) + wave.phase);
  return sum;
}

// (SS-20), (SS-21)
double Seabed::depth_m(const Eigen::Vector2d& point_m) const {
  const double rippled = 0.5 * (1.0 + patch(at(patches_, point_m)));
  return depth_m_ + slope_.dot(point_m) + at(undulations_, point_m) + rippled * at(ripples_, point_m);
}

double Seabed::reflectivity(const Eigen::Vector2d& point_m) const { return 1.0 + patch_contrast_ * patch(at(patches_, point_m)); }

/// Along a line the phase of a wave grows evenly: its cosine is the real part of a geometric sequence. (SS-23)
void Seabed::add(const std::vector<Wave>& waves, const Eigen::Vector2d& start_m, const Eigen::Vector2d& step_m, int count,
                 std::vector<double>& sum) {
  for (const Wave& wave : waves) {
    if (wave.amplitude == 0) continue;
    const std::complex<double> first = std::polar(wave.amplitude, wave.wave.dot(start_m) + wave.phase);
    const std::complex<double> ratio = std::polar(1.0, wave.wave.dot(step_m));
    double re = first.real();
    double im = first.imag();
    for (int i = 0; i < count; ++i) {
      sum[static_cast<std::size_t>(i)] += re;
      const double next = re * ratio.real() - im * ratio.imag();
      im = re * ratio.imag() + im * ratio.real();
      re = next;
    }
  }
}

void Seabed::sample(const Eigen::Vector2d& start_m, const Eigen::Vector2d& step_m, int count, SeabedProfile& profile) const {
  const auto size = static_cast<std::size_t>(std::max(count, 0));
  profile.depth_m.assign(size, 0.0);
  profile.reflectivity.assign(size, 0.0);
  profile.ripples_m.assign(size, 0.0);
  add(undulations_, start_m, step_m, count, profile.depth_m);
  add(patches_, start_m, step_m, count, profile.reflectivity);
  add(ripples_, start_m, step_m, count, profile.ripples_m);
  const double first = depth_m_ + slope_.dot(start_m);
  const double fall = slope_.dot(step_m);
  for (std::size_t i = 0; i < size; ++i) {
    const double kind = patch(profile.reflectivity[i]);
    profile.depth_m[i] += first + static_cast<double>(i) * fall + 0.5 * (1.0 + kind) * profile.ripples_m[i];
    profile.reflectivity[i] = 1.0 + patch_contrast_ * kind;
  }
}

}  // namespace ssjs
