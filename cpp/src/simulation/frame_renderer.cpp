#include "ssjs/simulation/frame_renderer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

constexpr float kSandAlbedo = 0.42F;  // the green of the sand, by which a camera is exposed
constexpr double kShallowest = 0.05;  // rays less steep than this (downwards, of their length) are taken not to reach the seabed

/// exp(-x) from a table, to 1e-5: pixels need a dozen each.
class Falloff {
 public:
  Falloff() {
    for (std::size_t i = 0; i < values_.size(); ++i) values_[i] = std::exp(-static_cast<float>(i) / kPerUnit);
  }
  [[nodiscard]] float operator()(float x) const {
    const float at = std::min(x * kPerUnit, static_cast<float>(values_.size() - 2));
    const auto i = static_cast<std::size_t>(at);
    return values_[i] + (at - static_cast<float>(i)) * (values_[i + 1] - values_[i]);
  }

 private:
  static constexpr float kPerUnit = 128.0F;
  std::array<float, 16 * 128> values_{};
};

const Falloff& falloff() {
  static const Falloff table;
  return table;
}

/// Normalised Gaussian weights from the middle outwards.
std::vector<float> blur_weights(double sigma_px) {
  const int reach = std::max(1, static_cast<int>(std::ceil(2.5 * sigma_px)));
  std::vector<float> weights;
  float sum = 0.0F;
  for (int i = 0; i <= reach; ++i) {
    weights.push_back(sigma_px > 0.0 ? std::exp(-0.5F * static_cast<float>(i * i / (sigma_px * sigma_px))) : (i == 0 ? 1.0F : 0.0F));
    sum += weights.back() * (i == 0 ? 1.0F : 2.0F);
  }
  for (float& weight : weights) weight /= sum;
  return weights;
}

/// Along one line of `count` values that lie `step` apart; the border's value goes on beyond it.
void blur_line(const float* from, float* to, int count, int step, const std::vector<float>& weights) {
  const int reach = static_cast<int>(weights.size()) - 1;
  for (int i = 0; i < count; ++i) {
    float sum = weights[0] * from[i * step];
    for (int k = 1; k <= reach; ++k) {
      sum += weights[static_cast<std::size_t>(k)] * (from[std::max(0, i - k) * step] + from[std::min(count - 1, i + k) * step]);
    }
    to[i * step] = sum;
  }
}

void blur(std::vector<float>& levels, int width, int height, double sigma_px) {
  if (sigma_px <= 0.0) return;
  const std::vector<float> weights = blur_weights(sigma_px);
  std::vector<float> rows(levels.size());
  for (int row = 0; row < height; ++row) {
    for (int channel = 0; channel < 3; ++channel) {
      const int first = 3 * width * row + channel;
      blur_line(&levels[static_cast<std::size_t>(first)], &rows[static_cast<std::size_t>(first)], width, 3, weights);
    }
  }
  for (int first = 0; first < 3 * width; ++first) {
    blur_line(&rows[static_cast<std::size_t>(first)], &levels[static_cast<std::size_t>(first)], height, 3 * width, weights);
  }
}

/// Mean 0, standard deviation 1, from four of the sixteen bits of one draw each: a sensor's noise to the eye and to a detector.
float noise_of(std::uint64_t bits) {
  const auto sum = static_cast<float>((bits & 0xffffU) + ((bits >> 16U) & 0xffffU) + ((bits >> 32U) & 0xffffU) + (bits >> 48U));
  constexpr float kScale = 1.7320508F / 65536.0F;  // four uniform numbers in [0, 1) have the variance 1/3
  return (sum - 131070.0F) * kScale;
}

}  // namespace

FrameRenderer::FrameRenderer(const SeabedTexture& seabed, CameraRays rays, const FrameLightConfig& light, std::uint64_t seed)
    : seabed_(seabed), rays_(std::move(rays)), light_(light), seed_(seed) {
  throw_if_any(violations(light));
  const auto pixels = static_cast<std::size_t>(std::max(0, rays_.width_px)) * static_cast<std::size_t>(std::max(0, rays_.height_px));
  if (pixels == 0 || rays_.slopes.size() != pixels) {
    throw InvalidArgument("rays.slopes", std::to_string(rays_.slopes.size()) + " entries", "must have one per pixel of the frame");
  }
}

std::optional<Eigen::Vector3d> FrameRenderer::seen_point(const SeabedTexture& seabed, const Eigen::Vector3d& world_p_camera,
                                                         const Eigen::Vector3d& world_direction) {
  constexpr int kMostSteps = 200;
  constexpr double kTolerance_m = 1e-7;
  if (world_direction.z() < kShallowest * world_direction.norm()) return std::nullopt;
  double depth_m = seabed.ground_depth_m(world_p_camera.head<2>());
  Eigen::Vector3d point = world_p_camera;
  for (int step = 0; step < kMostSteps; ++step) {
    point = world_p_camera + (depth_m - world_p_camera.z()) / world_direction.z() * world_direction;  // (CS-4)
    const double next_m = static_cast<double>(seabed.surface(point.x(), point.y()).depth_m);
    if (std::abs(next_m - depth_m) < kTolerance_m) break;
    depth_m = next_m;
  }
  return point;
}

std::vector<std::uint8_t> FrameRenderer::render(const Se3& world_T_vehicle, const Se3& vehicle_T_camera, std::uint64_t number) const {
  const Se3 world_T_camera = world_T_vehicle * vehicle_T_camera;
  const Eigen::Vector3d camera = world_T_camera.translation;
  const Eigen::Vector3d lamp = world_T_vehicle * Eigen::Vector3d(light_.lamp_forward_m, light_.lamp_starboard_m, light_.lamp_down_m);
  const Eigen::Matrix3f R = world_T_camera.rotation().cast<float>();
  const Eigen::Vector3f axis = R.col(2);
  if (axis.z() < static_cast<float>(kShallowest)) {
    throw InvalidArgument("world_T_camera", static_cast<double>(axis.z()), "the camera must look down");
  }
  const Eigen::Array3f per_m(static_cast<float>(light_.red_per_m), static_cast<float>(light_.green_per_m),
                             static_cast<float>(light_.blue_per_m));
  const auto exposed_m = static_cast<float>(light_.exposed_at_m);
  // (CS-7): what sand below the camera would send, made the level of the exposure
  const Eigen::Array3f taken = (-2.0F * exposed_m * per_m).exp();
  const Eigen::Array3f balanced = (taken(1) / taken).pow(static_cast<float>(light_.white_balance));
  const Eigen::Array3f gain = static_cast<float>(light_.exposure) * exposed_m * exposed_m / (kSandAlbedo * taken(1)) * balanced;
  const Eigen::Array3f veil = static_cast<float>(light_.exposure * light_.backscatter) * balanced * taken / taken(1);
  const auto beam = static_cast<float>(0.5 / (light_.beam_rad * light_.beam_rad));
  const Falloff& decay = falloff();

  std::vector<float> levels(3 * rays_.slopes.size());
  float depth_m = static_cast<float>(seabed_.ground_depth_m(camera.head<2>()));
  double distances_m = 0.0;
  for (std::size_t pixel = 0; pixel < rays_.slopes.size(); ++pixel) {
    const Eigen::Vector2f& slope = rays_.slopes[pixel];
    const Eigen::Vector3f direction = R * Eigen::Vector3f(slope.x(), slope.y(), 1.0F);
    const float down = std::max(direction.z(), static_cast<float>(kShallowest));
    SurfacePatch patch;
    Eigen::Vector3f from_camera;
    constexpr int kSteps = 3;  // from the depth of the pixel before: the seabed between two pixels hardly changes
    for (int step = 0; step < kSteps; ++step) {
      from_camera = (depth_m - static_cast<float>(camera.z())) / down * direction;  // (CS-4)
      patch = seabed_.surface(camera.x() + static_cast<double>(from_camera.x()), camera.y() + static_cast<double>(from_camera.y()));
      depth_m = patch.depth_m;
    }
    const Eigen::Vector3f from_lamp = from_camera + (camera - lamp).cast<float>();
    const float camera_m = from_camera.norm();
    const float lamp_m = from_lamp.norm();
    const Eigen::Vector3f up = Eigen::Vector3f(patch.slope_north, patch.slope_east, -1.0F).normalized();
    const float facing = std::max(0.0F, -up.dot(from_lamp) / lamp_m);
    const float ahead = std::max(0.05F, axis.dot(from_lamp) / lamp_m);
    const float shone = decay(beam * (1.0F / (ahead * ahead) - 1.0F));  // (CS-5)
    const Albedo albedo =
        seabed_.albedo(camera.x() + static_cast<double>(from_camera.x()), camera.y() + static_cast<double>(from_camera.y()));
    const float lit = shone * facing / (lamp_m * lamp_m);
    for (int channel = 0; channel < 3; ++channel) {
      const float water = decay(per_m(channel) * (camera_m + lamp_m));
      const float scattered = veil(channel) * shone * (1.0F - decay(per_m(channel) * camera_m));                          // (CS-8)
      levels[3 * pixel + static_cast<std::size_t>(channel)] = gain(channel) * albedo(channel) * lit * water + scattered;  // (CS-6)
    }
    distances_m += static_cast<double>(camera_m);
  }
  const double mean_m = distances_m / static_cast<double>(rays_.slopes.size());
  blur(levels, rays_.width_px, rays_.height_px, light_.blur_px + light_.scatter_px_per_m * mean_m);
  std::vector<std::uint8_t> frame(levels.size());
  add_noise(levels, number, frame);
  return frame;
}

/// (CS-9)
void FrameRenderer::add_noise(const std::vector<float>& levels, std::uint64_t number, std::vector<std::uint8_t>& frame) const {
  Rng rng = Rng(seed_).stream("frame " + std::to_string(number));
  const auto shot = static_cast<float>(light_.shot_noise);
  const auto read = static_cast<float>(light_.read_noise * light_.read_noise);
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const float level = levels[i] + std::sqrt(read + shot * std::max(0.0F, levels[i])) * noise_of(rng.next());
    frame[i] = static_cast<std::uint8_t>(std::clamp(level + 0.5F, 0.0F, 255.0F));
  }
}

}  // namespace ssjs
