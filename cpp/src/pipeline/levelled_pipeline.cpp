#include "ssjs/pipeline/levelled_pipeline.hpp"

#include <chrono>
#include <limits>
#include <utility>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using Clock = std::chrono::steady_clock;

LevelledBuilderConfig local_config(const LevelledConfig& config) {
  throw_if_any(config.violations());
  LevelledBuilderConfig local = config.local;
  if (config.method == LevelledMethod::kOneMap) {
    local.split.policy = {std::nullopt, std::nullopt, std::nullopt, std::nullopt, std::nullopt, 0};
    local.split.longest_m = std::numeric_limits<double>::max();
  }
  return local;
}

/// Identities that are known in a map are known between maps.
PortJoinerConfig joining_config(const LevelledConfig& config) {
  PortJoinerConfig joining = config.joining;
  joining.association =
      config.local.association.method == AssociationMethod::kKnown ? AssociationMethod::kKnown : AssociationMethod::kJointCompatibility;
  return joining;
}

}  // namespace

std::vector<std::string> LevelledConfig::violations() const {
  std::vector<std::string> found = ssjs::violations(*this);
  const CompassUse use = local.compass_use;
  if (joining.north_offset_rad && (use == CompassUse::kFirstReading || use == CompassUse::kNone)) {
    found.emplace_back(
        "joining.north_offset_rad: with compass_use = first_reading or none the maps hold no compass that could tell where north is: leave "
        "it out, or set compass_use = filter or mean");
  }
  return found;
}

LevelledPipeline::LevelledPipeline(const LevelledConfig& config)
    : builder_(local_config(config)),
      joiner_(joining_config(config)),
      dead_reckoning_(config.local.velocity_log, config.joining.north_offset_rad),
      joining_(config.joining) {}

LevelledReport LevelledPipeline::feed(const NavigationTick& tick) {
  if (finished_) throw InvalidArgument("tick", tick.time_s, "the mission is finished");
  LevelledReport report;
  TickResult local = builder_.feed(tick);
  dead_reckoning_.feed(tick);
  if (local.closed) {
    const auto begin = Clock::now();
    report.join = joiner_.take(std::move(*local.closed));
    global_T_base_ = joiner_.global_T_newest_base();
    report.association_time_s = report.join->association_time_s;
    report.global_time_s = std::chrono::duration<double>(Clock::now() - begin).count() - report.association_time_s;
  }
  if (builder_.index() == 0 && builder_.offset_known() && joining_.north_offset_rad) face_north();
  report.submap = builder_.index();
  report.update = local.update;
  report.refused = local.refused;
  report.observations = static_cast<int>(tick.sightings.size());
  report.wrong_pairs = local.wrong_pairs;
  report.vehicle = global_T_vehicle();
  return report;
}

/// Until the first map is closed, base 0 heads where its compass says.
void LevelledPipeline::face_north() {
  constexpr Eigen::Index kStart = VehicleLayout::kStartOffset;
  const double sigma = joining_.north_offset_sigma_rad;
  global_T_base_.mean.heading = wrap_angle(builder_.filter().vehicle()(kStart) - *joining_.north_offset_rad);
  global_T_base_.covariance(2, 2) = builder_.filter().vehicle_covariance()(kStart, kStart) + sigma * sigma;
}

/// The base moves x, y and heading; depth, roll and pitch are absolute in the map already.
SurveyStep LevelledPipeline::global_T_vehicle() const {
  const std::vector<Eigen::Index> planar{0, 1, 5};
  const VehicleVector x = builder_.filter().vehicle();
  const Matrix6d P = builder_.filter().vehicle_covariance().topLeftCorner<6, 6>();
  const Se2 base_T_vehicle = Se2::from_vector(x(planar));
  const Se2 global = global_T_base_.mean * base_T_vehicle;
  Matrix6d J = Matrix6d::Identity();
  J.topLeftCorner<2, 2>() = global_T_base_.mean.rotation();
  SurveyStep step;
  step.time_s = builder_.time_s();
  step.global_T_vehicle = x.head<6>();
  step.global_T_vehicle(planar) = global.vector();
  step.covariance = J * P * J.transpose();
  const Eigen::Matrix3d J_base = compose_jacobian_left(global_T_base_.mean, base_T_vehicle);
  step.covariance(planar, planar) += J_base * global_T_base_.covariance * J_base.transpose();
  return step;
}

JoinReport LevelledPipeline::finish() {
  if (finished_) throw InvalidArgument("finish", "second call", "a mission ends once");
  finished_ = true;
  JoinReport report;
  if (std::optional<LevelledSubmap> last = builder_.finish("end")) report = joiner_.take(std::move(*last));
  if (!joiner_.maps().empty()) joiner_.finish();
  return report;
}

std::vector<SurveyStep> LevelledPipeline::trajectory() const {
  std::vector<SurveyStep> trajectory;
  for (const PortMap& map : maps()) {
    const std::vector<SurveyStep> steps = steps_in_world(map, level());
    trajectory.insert(trajectory.end(), steps.begin(), steps.end());
  }
  return trajectory;
}

}  // namespace ssjs
