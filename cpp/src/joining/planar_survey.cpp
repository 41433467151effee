#include "ssjs/joining/planar_survey.hpp"

#include <algorithm>
#include <utility>

#include "ssjs/base/angle.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/joining/planar_submap.hpp"

namespace ssjs {
namespace {

/// The two bases of one map at a time: all that its steps need (U-4).
class BorderKnowledge final : public PortKnowledge {
 public:
  explicit BorderKnowledge(const std::vector<Se2>& bases) { values_.bases = bases; }
  void at(int map, const Matrix6d& covariance) {
    map_ = map;
    covariance_ = covariance;
  }
  [[nodiscard]] const PortValues& values() const override { return values_; }
  [[nodiscard]] Eigen::MatrixXd covariance(const std::vector<Unknown>& unknowns) const override {
    std::vector<Eigen::Index> rows;
    for (const Unknown& base : unknowns) {
      for (Eigen::Index i = 0; i < 3; ++i) rows.push_back(3 * Eigen::Index{base.index - map_} + i);
    }
    return covariance_(rows, rows);
  }

 private:
  PortValues values_;
  int map_ = 0;
  Matrix6d covariance_ = Matrix6d::Zero();
};

/// Everything moved by world_T_base_0, whose uncertainty is independent of it (U-5).
void move_by(const GaussianSe2& world_T_base_0, WorldEstimate& estimate) {
  const Eigen::Matrix3d J_old = compose_jacobian_right(world_T_base_0.mean);
  std::vector<Eigen::Matrix3d> J_moving;
  for (Se2& base : estimate.global_T_base) {
    J_moving.push_back(compose_jacobian_left(world_T_base_0.mean, base));
    base = world_T_base_0.mean * base;
  }
  const auto moved = [&](const Eigen::MatrixXd& P, std::size_t first) {
    const Eigen::Index n = P.rows() / 3;
    Eigen::MatrixXd J(P.rows(), 3);
    Eigen::MatrixXd turned(P.rows(), P.cols());
    for (Eigen::Index i = 0; i < n; ++i) {
      J.middleRows<3>(3 * i) = J_moving[first + static_cast<std::size_t>(i)];
      for (Eigen::Index j = 0; j < n; ++j) turned.block<3, 3>(3 * i, 3 * j) = J_old * P.block<3, 3>(3 * i, 3 * j) * J_old.transpose();
    }
    return Eigen::MatrixXd(turned + J * world_T_base_0.covariance * J.transpose());
  };
  for (std::size_t k = 0; k < estimate.border_covariance.size(); ++k)
    estimate.border_covariance[k] = moved(estimate.border_covariance[k], k);
  if (estimate.base_covariance.size() > 0) estimate.base_covariance = moved(estimate.base_covariance, 0);
  const Eigen::Matrix2d R = world_T_base_0.mean.rotation();
  for (LandmarkEstimate& landmark : estimate.landmarks) {
    const Eigen::Matrix<double, 2, 3> J = act_jacobian(world_T_base_0.mean, landmark.position.mean);
    landmark.position.covariance = R * landmark.position.covariance * R.transpose() + J * world_T_base_0.covariance * J.transpose();
    landmark.position.mean = world_T_base_0.mean * landmark.position.mean;
  }
}

/// The heading of the first base by its compass.
GaussianSe2 heading_by_compass(const LevelledSubmap& first, const NorthOffset& north) {
  GaussianSe2 heading;
  const double sigma_squared = north.sigma_rad * north.sigma_rad;
  if (first.compass_mean) {
    heading.mean.heading = angle_difference(first.compass_mean->offset_rad, north.mean_rad);
    heading.covariance(2, 2) = first.compass_mean->variance + sigma_squared;
  } else if (first.compass != CompassPorts::kNone) {
    const Eigen::Index row = LevelledSubmap::compass_offset();
    heading.mean.heading = angle_difference(first.mean(row), north.mean_rad);
    heading.covariance(2, 2) = first.covariance(row, row) + sigma_squared;
  } else {
    throw InvalidArgument("north_offset_rad", north.mean_rad, "the maps hold no compass: leave it out");
  }
  return heading;
}

}  // namespace

PlanarSurvey::PlanarSurvey(std::unique_ptr<MapJoiner> joiner, std::optional<NorthOffset> north)
    : joiner_(std::move(joiner)), north_(north) {}

JoinReport PlanarSurvey::take(LevelledSubmap submap) {
  const auto next = static_cast<int>(maps_.size());
  if (submap.index != next) throw InvalidArgument("submap.index", submap.index, "the next map is number " + std::to_string(next));
  if (next == 0 && north_) world_T_base_0_ = heading_by_compass(submap, *north_);
  const Submap planar = planar_submap_of(submap, static_cast<std::int64_t>(tracks_.size()));
  for (Eigen::Index i = 0; i < submap.landmark_count(); ++i) tracks_.push_back({next, i});
  maps_.push_back({std::move(submap), {{0, {UnknownKind::kBase, next + 1}}}});
  return joiner_->take(planar);
}

JoinReport PlanarSurvey::finish() { return maps_.empty() ? JoinReport{} : joiner_->finish(); }

GaussianSe2 PlanarSurvey::global_T_newest_base() const { return compose_independent(world_T_base_0_, joiner_->global_T_newest_base()); }

/// (U-3): depth is absolute in every map, and its error that of the map alone.
SurveyLandmark PlanarSurvey::with_depth(const LandmarkEstimate& planar) const {
  SurveyLandmark landmark;
  landmark.landmark = planar.landmark;
  double information = 0.0;
  double weighted_depth = 0.0;
  for (const std::int64_t track : planar.landmark.tracks) {
    const Track& seen = tracks_[static_cast<std::size_t>(track)];
    const LevelledSubmap& map = maps_[static_cast<std::size_t>(seen.map)].submap;
    const Eigen::Index z = map.landmark_offset(seen.landmark) + 2;
    information += 1.0 / map.covariance(z, z);
    weighted_depth += map.mean(z) / map.covariance(z, z);
    landmark.maps.push_back(seen.map);
    const std::vector<double> seen_s = map.times_seen_s(seen.landmark);
    landmark.seen_s.insert(landmark.seen_s.end(), seen_s.begin(), seen_s.end());
  }
  std::sort(landmark.seen_s.begin(), landmark.seen_s.end());
  std::sort(landmark.maps.begin(), landmark.maps.end());
  landmark.maps.erase(std::unique(landmark.maps.begin(), landmark.maps.end()), landmark.maps.end());
  landmark.position << planar.position.mean, weighted_depth / information;
  landmark.covariance.topLeftCorner<2, 2>() = planar.position.covariance;
  landmark.covariance(2, 2) = 1.0 / information;
  return landmark;
}

SurveyEstimate PlanarSurvey::estimate(std::size_t max_joint_bases) const {
  SurveyEstimate survey;
  if (maps_.empty()) return survey;
  WorldEstimate world = joiner_->estimate(maps_.size() <= max_joint_bases ? BaseCovariance::kJoint : BaseCovariance::kBorders);
  if (north_) move_by(world_T_base_0_, world);
  BorderKnowledge borders(world.global_T_base);
  for (const PortMap& map : maps_) {
    const auto k = static_cast<std::size_t>(map.base());
    const Matrix6d& border = world.border_covariance[k];
    survey.global_T_base.push_back({world.global_T_base[k], border.topLeftCorner<3, 3>()});
    borders.at(map.base(), border);
    const std::vector<SurveyStep> steps = steps_in_world(map, borders);
    survey.steps.insert(survey.steps.end(), steps.begin(), steps.end());
  }
  const Eigen::Index rows = 3 * static_cast<Eigen::Index>(maps_.size());  // without the last base, where no map starts
  if (world.base_covariance.size() > 0) survey.base_covariance = world.base_covariance.topLeftCorner(rows, rows);
  for (const LandmarkEstimate& landmark : world.landmarks) survey.landmarks.push_back(with_depth(landmark));
  survey.live_maps = std::move(world.maps);
  return survey;
}

}  // namespace ssjs
