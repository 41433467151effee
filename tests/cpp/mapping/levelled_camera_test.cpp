// A levelled map with a camera: rays, points, and what becomes of them. docs/math/camera.md
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <map>
#include <set>
#include <string>

#include "mapping/camera_run.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using namespace ssjs::testing;  // NOLINT(google-build-using-namespace)

constexpr Eigen::Index kVehicle = VehicleLayout::kSize;

struct Sum {
  double value = 0.0;
  int dof = 0;
  void add(const Eigen::VectorXd& error, const Eigen::MatrixXd& P) {
    value += normalized_squared_error(error, P);
    dof += static_cast<int>(error.size());
  }
  [[nodiscard]] double per_dof() const { return value / dof; }
};

void expect_in_band(const char* what, const Sum& sum, double probability) {
  const Band band = mean_band(static_cast<double>(sum.dof), 1, probability);
  std::printf("%s: NEES per dof %.3f over %d, band [%.3f, %.3f]\n", what, sum.per_dof(), sum.dof, band.lower / sum.dof,
              band.upper / sum.dof);
  EXPECT_GT(sum.value, band.lower) << what;
  EXPECT_LT(sum.value, band.upper) << what;
}

/// The true ray of a landmark whose first sighting was at `first`, in the frame of a map that began at `start`.
Eigen::Vector3d true_direction_and_depth(const AuvTruth& first, const AuvTruth& start, const Eigen::Vector3d& world_p_point,
                                         const CameraConfig& camera) {
  const VehicleVector then = true_vehicle(first, start);
  const Eigen::Vector3d c1 = map_T_vehicle(then) * vehicle_T_camera(camera).translation;
  const Se2 base_T_world = level_pose(start).inverse();
  Eigen::Vector3d point;
  point << base_T_world * Eigen::Vector2d(world_p_point.head<2>()), world_p_point.z();
  const Eigen::Vector3d g = point - c1;
  return {std::atan2(g.x(), g.z()), std::atan2(-g.y(), std::hypot(g.x(), g.z())), 1.0 / g.norm()};
}

enum class Rays { kAsTheyRun, kNeverConverted };

/// Pose, directions and inverse depths of rays, and points, in one map at the end of `duration_s`.
void add_errors_at_the_end(std::uint64_t seed, double duration_s, Rays rays, Sum& pose, Sum& joint) {
  CameraMission mission = camera_mission();
  mission.simulation.duration_s = duration_s;
  const CameraSurvey made = simulate_camera(mission, seed);
  LevelledBuilderConfig config = matched(mission);
  never_split(config);
  if (rays == Rays::kNeverConverted) {
    config.camera_association.max_linearity = 1e-12;
    config.camera_association.missed_frames = 100000;
  }
  LevelledBuilder builder(config);
  std::vector<std::size_t> first;  // tick of the first sighting of each track
  for (std::size_t i = 0; i < made.survey.ticks.size(); ++i) {
    const TickResult result = builder.feed(made.survey.ticks[i]);
    first.insert(first.end(), static_cast<std::size_t>(result.added), i);
  }
  const LevelledFilter& filter = builder.filter();
  const AuvTruth& start = made.survey.truth.front();
  const Se2 base_T_world = level_pose(start).inverse();
  Eigen::VectorXd all(6 + 3 * filter.landmarks());
  std::vector<Eigen::Index> places{0, 1, 2, 3, 4, 5};
  all.head<6>() = vehicle_error(true_vehicle(made.survey.truth.back(), start), filter.vehicle()).head<6>();
  for (Eigen::Index i = 0; i < filter.landmarks(); ++i) {
    const MapLandmark& landmark = builder.landmarks()[static_cast<std::size_t>(i)];
    const Eigen::Vector3d point = made.survey.world.landmarks_m.col(*landmark.source_id);
    const AuvTruth& then = made.survey.truth[first[static_cast<std::size_t>(landmark.tracks.front())]];
    if (filter.is_ray(i)) {
      all.segment<3>(6 + 3 * i) = true_direction_and_depth(then, start, point, mission.camera) - filter.ray(i).tail<3>();
    } else {
      all.segment<2>(6 + 3 * i) = base_T_world * Eigen::Vector2d(point.head<2>()) - filter.landmark_position(i).head<2>();
      all(6 + 3 * i + 2) = point.z() - filter.landmark_position(i).z();
    }
    for (Eigen::Index k = filter.rows_of(i) - 3; k < filter.rows_of(i); ++k) places.push_back(filter.offset(i) + k);
  }
  const Eigen::MatrixXd P = filter.covariance()(places, places);
  pose.add(all.head<6>(), P.topLeftCorner<6, 6>());
  joint.add(all, P);
}

void expect_rays_consistent(Rays rays, const std::vector<double>& durations_s, int runs, double probability) {
  for (const double duration_s : durations_s) {
    Sum pose, joint;
    for (int seed = 1; seed <= runs; ++seed) add_errors_at_the_end(static_cast<std::uint64_t>(seed), duration_s, rays, pose, joint);
    std::printf("after %.1f s, ", duration_s);
    expect_in_band("pose", pose, probability);
    expect_in_band("            pose and landmarks", joint, probability);
  }
}

TEST(LevelledCamera, I5_YoungRaysAreConsistent) { expect_rays_consistent(Rays::kNeverConverted, {1.2, 4.0}, 8, 0.999); }
TEST(LevelledCamera, I5_YoungRaysAreConsistentOver50RunsLong) { expect_rays_consistent(Rays::kNeverConverted, {1.2, 4.0}, 50, 0.99); }
TEST(LevelledCamera, I8_RaysAndPointsAreConsistent) { expect_rays_consistent(Rays::kAsTheyRun, {4.0, 20.0}, 8, 0.999); }
TEST(LevelledCamera, I8_RaysAndPointsAreConsistentOver50RunsLong) { expect_rays_consistent(Rays::kAsTheyRun, {4.0, 20.0}, 50, 0.99); }

/// Maps of 6 m, at their ends: the exit and the points that rays became.
struct MapCheck {
  Sum exit, joint;
  int points = 0, wrong_pairs = 0, paired = 0, unknown = 0;
  SensorStatistics camera;
};

MapCheck map_check(CameraMission mission, AssociationMethod method, int runs) {
  MapCheck check;
  mission.simulation.duration_s = 40.0;
  for (int seed = 1; seed <= runs; ++seed) {
    const CameraSurvey made = simulate_camera(mission, static_cast<std::uint64_t>(seed));
    LevelledBuilderConfig config = matched(mission);
    split_every(config, 6.0);
    config.association.method = method;
    LevelledBuilder builder(config);
    for (const NavigationTick& tick : made.survey.ticks) {
      TickResult result = builder.feed(tick);
      check.wrong_pairs += result.wrong_pairs;
      check.paired += result.paired;
      if (!result.closed) continue;
      const LevelledSubmap& map = *result.closed;
      bool known = true;
      for (const MapLandmark& landmark : map.landmarks) known = known && landmark.source_id;
      if (!known) ++check.unknown;  // a map with clutter that was seen thrice
      if (!known) continue;
      const Eigen::VectorXd error = map_error(map, made.survey);
      check.exit.add(error.head<3>(), map.covariance.topLeftCorner<3, 3>());
      check.joint.add(error, map.covariance);
      check.points += static_cast<int>(map.landmark_count());
    }
    const SensorStatistics& camera = builder.statistics(NavigationSensor::kCamera);
    check.camera.used += camera.used;
    check.camera.refused += camera.refused;
    check.camera.nis_sum += camera.nis_sum;
    check.camera.dof += camera.dof;
  }
  std::printf("%d points, %d pairs, %d wrong, camera: used %d, refused %d, NIS per dof %.3f, maps with clutter %d\n", check.points,
              check.paired, check.wrong_pairs, check.camera.used, check.camera.refused, check.camera.nis_sum / check.camera.dof,
              check.unknown);
  return check;
}

void expect_maps_consistent(const CameraMission& mission, AssociationMethod method, int runs, double probability) {
  const MapCheck check = map_check(mission, method, runs);
  expect_in_band("exit", check.exit, probability);
  expect_in_band("exit, offsets and points", check.joint, probability);
  EXPECT_GT(check.points, 20 * runs);
  EXPECT_LE(check.wrong_pairs, check.paired / 1000);
  EXPECT_NEAR(check.camera.nis_sum / check.camera.dof, 1.0, 0.1);
  EXPECT_LE(check.camera.refused, check.camera.used / 100);
}

CameraMission cluttered() {
  CameraMission mission = camera_mission();
  mission.clutter = 5;
  return mission;
}

TEST(LevelledCamera, I8_MapsOfKnownPointsAreConsistent) { expect_maps_consistent(camera_mission(), AssociationMethod::kKnown, 4, 0.999); }
TEST(LevelledCamera, I8_MapsOfKnownPointsAreConsistentOver50RunsLong) {
  expect_maps_consistent(camera_mission(), AssociationMethod::kKnown, 50, 0.99);
}
TEST(LevelledCamera, I12_MapsPairedByGateAndLooksAreConsistent) {
  expect_maps_consistent(cluttered(), AssociationMethod::kJointCompatibility, 4, 0.999);
}
TEST(LevelledCamera, I12_MapsPairedByGateAndLooksAreConsistentOver50RunsLong) {
  expect_maps_consistent(cluttered(), AssociationMethod::kJointCompatibility, 50, 0.99);
}

TEST(LevelledCamera, AMapHoldsPointsSeenOftenEnough) {
  CameraMission mission = cluttered();
  mission.simulation.duration_s = 20.0;
  const CameraSurvey made = simulate_camera(mission, 5);
  LevelledBuilderConfig config = matched(mission);
  config.association.method = AssociationMethod::kJointCompatibility;
  never_split(config);
  LevelledBuilder builder(config);
  std::set<std::int64_t> tracks;
  for (const NavigationTick& tick : made.survey.ticks) {
    for (const FrameSighting& sighting : builder.feed(tick).frame) {
      EXPECT_LE((sighting.measured - sighting.predicted).dot(sighting.S.llt().solve(sighting.measured - sighting.predicted)), 13.9);
      tracks.insert(sighting.track);
    }
  }
  const LevelledSubmap map = *builder.finish("end");
  ASSERT_GT(map.landmark_count(), 15);
  EXPECT_EQ(map.mean.size(), map.landmark_offset(map.landmark_count()));
  for (Eigen::Index i = 0; i < map.landmark_count(); ++i) {
    const MapLandmark& landmark = map.landmarks[static_cast<std::size_t>(i)];
    EXPECT_GE(landmark.times_seen, config.camera_association.min_sightings);
    EXPECT_EQ(static_cast<int>(map.times_seen_s(i).size()), landmark.times_seen);
    EXPECT_TRUE(landmark.of_camera);
    EXPECT_EQ(landmark.descriptor.size(), 64);
    EXPECT_EQ(tracks.count(landmark.tracks.front()), 1U);
  }
}

/// Points of a filter whose vehicle is known exactly, beside the least-squares solution over all pixels of the track.
TEST(LevelledCamera, I8_PointsAgreeWithABatchTriangulation) {
  CameraMission mission = camera_mission();
  mission.simulation.duration_s = 12.0;
  const CameraSurvey made = simulate_camera(mission, 3);
  const PinholeCamera camera = *pinhole_camera(mission.camera);
  LevelledFilter filter(8);
  filter.reset(state_in_world(made.survey.truth.front()), VehicleMatrix(1e-14 * VehicleMatrix::Identity()));
  std::vector<std::int64_t> ids;
  std::map<std::int64_t, std::vector<std::pair<std::size_t, Eigen::Vector2d>>> pixels;
  int converted = 0;
  for (std::size_t i = 0; i < made.survey.ticks.size(); ++i) {
    if (!made.survey.ticks[i].frame) continue;
    const VehicleVector x = state_in_world(made.survey.truth[i]);
    filter.predict({x, VehicleMatrix::Identity(), VehicleMatrix::Zero()});
    std::vector<StateRows> rows;
    std::vector<CameraSighting> fresh;
    for (const CameraSighting& sighting : made.survey.ticks[i].frame->sightings) {
      const auto known = std::find(ids.begin(), ids.end(), *sighting.landmark_id);
      const Eigen::Index at = known - ids.begin();
      pixels[*sighting.landmark_id].emplace_back(i, sighting.pixel);
      if (known == ids.end()) {
        fresh.push_back(sighting);
        continue;
      }
      StateRows block{VehicleRows(2), at, {}, {}};
      const auto take = [&](const auto& seen) {
        block.vehicle.residual = sighting.pixel - seen.pixel;
        block.vehicle.H = seen.H_vehicle;
        block.H_landmark = seen.H_landmark.template leftCols<3>();
      };
      if (filter.is_ray(at)) {
        const auto seen = predict_pixel(x, filter.ray(at), camera, mission.camera);
        take(*seen);
        block.H_ray = seen->H_landmark.rightCols<3>();
      } else {
        take(*predict_pixel(x, filter.landmark_position(at), camera, mission.camera));
      }
      block.vehicle.R = std::pow(mission.camera.sigma_px, 2) * Eigen::Matrix2d::Identity();
      rows.push_back(block);
    }
    (void)filter.update(rows);
    for (const CameraSighting& sighting : fresh) {
      filter.add_landmark(*ray_from_pixel(x, sighting.pixel, camera, mission.camera));
      ids.push_back(*sighting.landmark_id);
    }
    const Eigen::Vector3d map_p_camera = map_T_vehicle(x) * vehicle_T_camera(mission.camera).translation;
    for (Eigen::Index k = 0; k < filter.landmarks(); ++k) {
      if (!filter.is_ray(k) || linearity_index(filter.ray(k), filter.inverse_depth_sigma(k), map_p_camera) >= 0.1) continue;
      filter.convert_to_point(k);
      ++converted;
    }
  }
  const Eigen::MatrixXd P = filter.covariance();
  int compared = 0;
  double worst_sigmas = 0.0, worst_m = 0.0;
  for (Eigen::Index k = 0; k < filter.landmarks(); ++k) {
    const auto& seen = pixels[ids[static_cast<std::size_t>(k)]];
    if (filter.is_ray(k) || seen.size() < 5) continue;
    // the relief of the seabed is a measurement too: the inverse depth of the first pixel
    const VehicleVector first = state_in_world(made.survey.truth[seen.front().first]);
    const NewRay prior = *ray_from_pixel(first, seen.front().second, camera, mission.camera);
    Eigen::Vector3d point = made.survey.world.landmarks_m.col(ids[static_cast<std::size_t>(k)]);
    Eigen::Matrix3d information;
    for (int round = 0; round < 10; ++round) {
      const Eigen::Vector3d away = point - prior.ray.head<3>();
      const Eigen::RowVector3d J_rho = -away.transpose() / std::pow(away.norm(), 3);
      const double weight = 1.0 / std::pow(mission.camera.relief * prior.ray(5), 2);
      information = weight * J_rho.transpose() * J_rho;
      Eigen::Vector3d gradient = weight * J_rho.transpose() * (prior.ray(5) - 1.0 / away.norm());
      for (const auto& [tick, pixel] : seen) {
        const auto expected = predict_pixel(state_in_world(made.survey.truth[tick]), point, camera, mission.camera);
        const Eigen::Matrix<double, 2, 3> H = expected->H_landmark / mission.camera.sigma_px;
        information += H.transpose() * H;
        gradient += H.transpose() * (pixel - expected->pixel) / mission.camera.sigma_px;
      }
      point += information.llt().solve(gradient);
    }
    const Eigen::Vector3d difference = filter.landmark_position(k) - point;
    const Eigen::Matrix3d own = P.block<3, 3>(filter.offset(k), filter.offset(k));
    worst_sigmas = std::max(worst_sigmas, std::sqrt(difference.dot(own.llt().solve(difference)) / 3.0));
    worst_m = std::max(worst_m, difference.norm());
    EXPECT_LT(std::sqrt(difference.dot(own.llt().solve(difference)) / 3.0), 0.3) << "point " << k << ", " << seen.size() << " pixels";
    EXPECT_NEAR((own * information).trace() / 3.0, 1.0, 0.15) << "point " << k << ", " << seen.size() << " pixels";
    ++compared;
  }
  std::printf("%d converted, %d compared: at most %.3f sigma and %.2f mm from the batch\n", converted, compared, worst_sigmas,
              1e3 * worst_m);
  EXPECT_GT(compared, 20);
}

TEST(LevelledCamera, ArchivedWithRaysItGoesOnAsBefore) {
  CameraMission mission = cluttered();
  mission.simulation.duration_s = 30.0;
  const CameraSurvey made = simulate_camera(mission, 9);
  LevelledBuilderConfig config = matched(mission);
  config.association.method = AssociationMethod::kJointCompatibility;
  split_every(config, 6.0);
  LevelledBuilder builder(config), other(config);
  std::vector<LevelledSubmap> maps, others;
  for (std::size_t i = 0; i < made.survey.ticks.size(); ++i) {
    TickResult result = builder.feed(made.survey.ticks[i]);
    if (result.closed) maps.push_back(std::move(*result.closed));
    if (i == 200) {
      int rays = 0;
      for (Eigen::Index k = 0; k < builder.filter().landmarks(); ++k) rays += builder.filter().is_ray(k) ? 1 : 0;
      EXPECT_GT(rays, 0);
      Archive out;
      builder.archive(out);
      const std::string bytes = out.take_bytes();
      Archive in(bytes, "builder");
      other.archive(in);
      in.end();
      others = maps;
    } else if (i > 200) {
      TickResult same = other.feed(made.survey.ticks[i]);
      EXPECT_EQ(same.paired, result.paired);
      if (same.closed) others.push_back(std::move(*same.closed));
    }
  }
  maps.push_back(*builder.finish("end"));
  others.push_back(*other.finish("end"));
  ASSERT_EQ(maps.size(), others.size());
  ASSERT_GT(maps.size(), 2U);
  for (std::size_t i = 0; i < maps.size(); ++i) {
    EXPECT_EQ(maps[i].mean, others[i].mean);
    EXPECT_EQ(maps[i].covariance, others[i].covariance);
    for (std::size_t k = 0; k < maps[i].steps.size(); ++k) EXPECT_EQ(maps[i].steps[k].gain, others[i].steps[k].gain);
    for (std::size_t k = 0; k < maps[i].landmarks.size(); ++k) {
      EXPECT_EQ(maps[i].landmarks[k].descriptor, others[i].landmarks[k].descriptor);
    }
  }
}

/// CPU time of what a frame costs beyond the other samples, in maps of 40 to 60 landmarks; smoothing of a map's steps is apart.
TEST(LevelledCamera, WhatAFrameCostsLong) {
  CameraMission mission = camera_mission();
  mission.points_per_m2 = 6.0;
  mission.simulation.duration_s = 40.0;
  const CameraSurvey made = simulate_camera(mission, 2);
  LevelledBuilderConfig config = matched(mission);
  config.association.method = AssociationMethod::kJointCompatibility;
  config.split.policy.max_distance_m = 10.0;
  LevelledBuilder builder(config, StepSmoothing::kByCaller);
  double of_frames_s = 0.0, of_others_s = 0.0, of_smoothing_s = 0.0, worst_s = 0.0;
  int frames = 0, sightings = 0, maps = 0;
  Eigen::Index landmarks = 0, rows = 0;
  for (const NavigationTick& tick : made.survey.ticks) {
    const std::clock_t begin = std::clock();
    TickResult result = builder.feed(tick);
    const double took_s = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    (tick.frame ? of_frames_s : of_others_s) += took_s;
    if (tick.frame) {
      ++frames;
      worst_s = std::max(worst_s, took_s);
      sightings += static_cast<int>(tick.frame->sightings.size());
      landmarks += builder.filter().landmarks();
      rows += builder.filter().size();
    }
    if (!result.steps) continue;
    const std::clock_t start = std::clock();
    result.closed->steps = result.steps->smoothed();
    of_smoothing_s += static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    builder.reuse(std::move(result.steps->record));
    ++maps;
  }
  const auto ticks = static_cast<double>(made.survey.ticks.size());
  std::printf(
      "a frame of %.1f sightings, %.1f landmarks and %.0f rows in the state: %.2f ms CPU (worst %.2f), another tick %.3f ms; "
      "smoothing %.1f ms a map, %d maps\n",
      static_cast<double>(sightings) / frames, static_cast<double>(landmarks) / frames, static_cast<double>(rows) / frames,
      1e3 * of_frames_s / frames, 1e3 * worst_s, 1e3 * of_others_s / (ticks - frames), 1e3 * of_smoothing_s / std::max(maps, 1), maps);
  EXPECT_GT(sightings, 30 * frames);
  EXPECT_GT(landmarks, 30 * frames);
  EXPECT_GT(maps, 1);
}

TEST(LevelledCamera, FramesNeedACamera) {
  const CameraMission mission = camera_mission();
  LevelledBuilderConfig config = matched(mission);
  config.camera.fy_px.reset();
  try {
    const LevelledBuilder builder(config);
    FAIL() << "half a camera was taken";
  } catch (const InvalidArgument& error) {
    EXPECT_NE(std::string(error.what()).find("camera.fy_px"), std::string::npos) << error.what();
  }
  config.camera = CameraConfig{};
  LevelledBuilder builder(config);
  NavigationTick tick = tick_at(0.0);
  tick.frame.emplace();
  EXPECT_THROW((void)builder.feed(tick), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
