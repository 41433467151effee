#include "ssjs/survey/sonar_loop.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>
#include <variant>

#include "ssjs/base/angle.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

constexpr double kLeastLandmark = 2.5, kGreatestLandmark = 5.0;  // area, of spot_m2
constexpr double kDimmestLandmark = 0.9;                         // of landmark_level
constexpr double kShortestShadow_m = 1.0, kLongestShadow_m = 3.0;
constexpr double kGreatestAspect = 2.5;
constexpr double kLargeSpots = 0.03;      // of all spots
constexpr double kSpotClearance_m = 1.2;  // between spots and landmarks

std::vector<Echo> landmark_echoes(std::size_t count, const SonarLoopConfig& config, Rng rng) {
  std::vector<Echo> echoes;
  for (std::size_t i = 0; i < count; ++i) {
    Echo echo;
    echo.area_m2 = config.spot_m2 * rng.uniform(kLeastLandmark, kGreatestLandmark);
    echo.aspect = rng.uniform(1.0, kGreatestAspect);
    echo.heading_rad = rng.uniform(-kPi, kPi);
    echo.level = config.landmark_level * rng.uniform(kDimmestLandmark, 1.0);
    echo.shadow_m = rng.uniform(kShortestShadow_m, kLongestShadow_m);
    echoes.push_back(echo);
  }
  return echoes;
}

/// (O-14) in metres: many small spots, a few as large as what is looked for.
Echo spot_echo(const SonarLoopConfig& config, Rng& rng) {
  Echo echo;
  const double u = rng.uniform();
  echo.area_m2 = config.spot_m2 * (rng.uniform() < kLargeSpots ? 1.2 + 1.8 * u : 0.9 * u * u);
  echo.aspect = rng.uniform(1.0, kGreatestAspect);
  echo.heading_rad = rng.uniform(-kPi, kPi);
  echo.level = rng.uniform(config.dimmest_spot_level, config.brightest_spot_level);
  return echo;
}

/// Adds spots wherever the sonar comes to see, clear of the landmarks.
void strew_spots(const SonarLoopConfig& config, double reach_m, Rng rng, World& world, std::vector<Echo>& echoes) {
  Eigen::Vector2d low = world.waypoints.front(), high = low;
  for (const Eigen::Vector2d& waypoint : world.waypoints) {
    low = low.cwiseMin(waypoint);
    high = high.cwiseMax(waypoint);
  }
  low.array() -= reach_m;
  high.array() += reach_m;
  const auto landmarks = world.landmarks_m.cols();
  const auto draws = static_cast<Eigen::Index>(std::lround(0.01 * config.spots_per_100_m2 * (high - low).prod()));
  std::int64_t next_id = world.ids.empty() ? 0 : *std::max_element(world.ids.begin(), world.ids.end()) + 1;
  std::vector<Eigen::Vector2d> places;
  for (Eigen::Index draw = 0; draw < draws; ++draw) {
    const double x_m = rng.uniform(low.x(), high.x());
    const double y_m = rng.uniform(low.y(), high.y());
    const Echo spot = spot_echo(config, rng);
    const Eigen::Vector2d place(x_m, y_m);
    bool is_clear = true;
    for (Eigen::Index i = 0; i < landmarks && is_clear; ++i) {
      const double least_m = kSpotClearance_m + spot.radius_m() + echoes[static_cast<std::size_t>(i)].radius_m();
      is_clear = (world.landmarks_m.col(i) - place).norm() >= least_m;
    }
    if (!is_clear) continue;
    places.push_back(place);
    echoes.push_back(spot);
    world.ids.push_back(next_id++);
  }
  world.landmarks_m.conservativeResize(2, landmarks + static_cast<Eigen::Index>(places.size()));
  for (std::size_t i = 0; i < places.size(); ++i) world.landmarks_m.col(landmarks + static_cast<Eigen::Index>(i)) = places[i];
}

/// What a picture's regions show.
class Observer {
 public:
  Observer(const SonarLoopConfig& config, const Eigen::Matrix2d& sensor, std::int64_t first_spot_id)
      : config_(config), sensor_(sensor), first_spot_id_(first_spot_id) {}

  [[nodiscard]] const SonarLoopCounts& counts() const { return counts_; }

  [[nodiscard]] Features observe(const SonarImage& picture, const std::vector<HeardEcho>& heard) {
    const SegmentationResult found = segment(picture, config_.segmentation);
    ++counts_.pictures;
    if (found.threshold) counts_.threshold_sum += *found.threshold;
    if (found.improved_otsu && found.improved_otsu->second_pass_fired) ++counts_.second_passes;
    std::vector<std::vector<const HeardEcho*>> inside(found.regions.regions.size());
    for (const HeardEcho& echo : heard) {
      const cv::Point2d middle = picture_point(echo.vehicle_p_echo, config_.picture);
      const cv::Point pixel(static_cast<int>(std::lround(middle.x)), static_cast<int>(std::lround(middle.y)));
      if (!cv::Rect({0, 0}, found.mask.size()).contains(pixel)) continue;
      const int label = found.regions.labels.at<int>(pixel);
      if (label > 0) inside[static_cast<std::size_t>(label - 1)].push_back(&echo);
    }
    Features features;
    for (std::size_t i = 0; i < inside.size(); ++i) {
      Feature feature = region_feature(found.regions.regions[i], sensor_, config_.picture);
      if (const HeardEcho* nearest = nearest_to(feature, inside[i])) feature.landmark_id = nearest->id;
      count(inside[i]);
      features.push_back(feature);
    }
    return features;
  }

 private:
  static const HeardEcho* nearest_to(const Feature& feature, const std::vector<const HeardEcho*>& echoes) {
    const Eigen::Vector2d place = feature.range() * Eigen::Vector2d(std::cos(feature.bearing()), std::sin(feature.bearing()));
    const auto nearest = std::min_element(echoes.begin(), echoes.end(), [&](const HeardEcho* a, const HeardEcho* b) {
      return (a->vehicle_p_echo - place).squaredNorm() < (b->vehicle_p_echo - place).squaredNorm();
    });
    return nearest == echoes.end() ? nullptr : *nearest;
  }

  void count(const std::vector<const HeardEcho*>& inside) {
    const bool has_landmark = std::any_of(inside.begin(), inside.end(), [&](const HeardEcho* echo) { return echo->id < first_spot_id_; });
    ++counts_.regions;
    ++(has_landmark ? counts_.of_landmarks : inside.empty() ? counts_.of_nothing : counts_.of_spots);
    if (inside.size() > 1) ++counts_.merged;
  }

  const SonarLoopConfig& config_;
  Eigen::Matrix2d sensor_;
  std::int64_t first_spot_id_;
  SonarLoopCounts counts_;
};

std::vector<HeardEcho> heard_in(const Features& scan, const std::vector<Echo>& echoes) {
  std::vector<HeardEcho> heard;
  for (const Feature& feature : scan) {
    const std::int64_t id = feature.landmark_id.value();
    const Eigen::Vector2d place(feature.range() * std::cos(feature.bearing()), feature.range() * std::sin(feature.bearing()));
    heard.push_back({echoes[static_cast<std::size_t>(id)], place, id});
  }
  return heard;
}

/// The landmarks, and those spots that some region was of.
void keep_seen(World& world, std::int64_t first_spot_id, const std::set<std::int64_t>& seen) {
  World kept;
  kept.waypoints = world.waypoints;
  std::vector<Eigen::Index> columns;
  for (std::size_t i = 0; i < world.ids.size(); ++i) {
    if (world.ids[i] >= first_spot_id && seen.count(world.ids[i]) == 0) continue;
    kept.ids.push_back(world.ids[i]);
    columns.push_back(static_cast<Eigen::Index>(i));
  }
  kept.landmarks_m.resize(2, static_cast<Eigen::Index>(columns.size()));
  for (std::size_t i = 0; i < columns.size(); ++i) kept.landmarks_m.col(static_cast<Eigen::Index>(i)) = world.landmarks_m.col(columns[i]);
  world = std::move(kept);
}

}  // namespace

std::vector<std::string> SonarLoopConfig::violations() const {
  std::vector<std::string> all = ssjs::violations(*this);
  for (const std::string& violation : segmentation.violations()) {
    const std::string named = "segmentation." + violation;
    if (std::find(all.begin(), all.end(), named) == all.end()) all.push_back(named);
  }
  if (!(picture.max_range_m > picture.min_range_m)) all.emplace_back("picture.max_range_m: must be above picture.min_range_m");
  if (!(brightest_spot_level >= dimmest_spot_level)) all.emplace_back("brightest_spot_level: must not be below dimmest_spot_level");
  return all;
}

SonarLoopMission simulate_sonar_loop(const Scenario& scenario, const SonarLoopConfig& config, std::uint64_t seed) {
  throw_if_any(config.violations());
  const Rng rng(seed);
  World world = scenario.world;
  for (std::size_t i = 0; i < world.ids.size(); ++i) {
    if (world.ids[i] != static_cast<std::int64_t>(i))
      throw InvalidArgument("World.ids", static_cast<double>(world.ids[i]), "must count from 0");
  }
  const auto first_spot_id = static_cast<std::int64_t>(world.ids.size());
  std::vector<Echo> echoes = landmark_echoes(world.ids.size(), config, rng.stream("echoes"));
  strew_spots(config, config.picture.max_range_m, rng.stream("spots"), world, echoes);

  VehicleSimulationConfig drive = scenario.config;
  drive.min_range_m = config.picture.min_range_m;
  drive.max_range_m = config.picture.max_range_m;
  SonarLoopMission made{simulate(world, drive, seed), {}};
  Eigen::Matrix2d sensor = Eigen::Matrix2d::Zero();
  sensor.diagonal() << drive.range_sigma_m * drive.range_sigma_m, drive.bearing_sigma_rad * drive.bearing_sigma_rad;

  Observer observer(config, sensor, first_spot_id);
  const Rng pictures = rng.stream("pictures");
  std::set<std::int64_t> seen;
  std::vector<Event> events;
  for (Event& event : made.mission.events) {
    if (const auto* scan = std::get_if<Features>(&event.record)) {
      const auto step = static_cast<std::size_t>(std::lround(event.time_s / drive.step_s));
      const Se2 global_T_vehicle = step == 0 ? Se2() : made.mission.global_T_vehicle[step - 1];
      const std::vector<HeardEcho> heard = heard_in(*scan, echoes);
      const SonarImage picture = scan_picture(heard, global_T_vehicle, config.picture, pictures.stream(std::to_string(step)));
      Features features = observer.observe(picture, heard);
      for (const Feature& feature : features) {
        if (feature.landmark_id) seen.insert(*feature.landmark_id);
      }
      if (features.empty()) continue;
      event.record = std::move(features);
    }
    events.push_back(std::move(event));
  }
  made.mission.events = std::move(events);
  made.counts = observer.counts();
  keep_seen(made.mission.world, first_spot_id, seen);
  return made;
}

}  // namespace ssjs
