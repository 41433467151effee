#include "ssjs/joining/port_survey.hpp"

namespace ssjs {
namespace {

constexpr std::size_t kMaxJointLandmarks = 300;  // 3.2 MB a triangle, and growing with the square

}  // namespace

JoinReport PortSurvey::finish() {
  if (maps().empty()) return {};
  return joiner_.finish();
}

SurveyEstimate PortSurvey::estimate(std::size_t max_joint_bases) const {
  SurveyEstimate estimate;
  const PortLevel& level = joiner_.level();
  std::vector<Unknown> bases;
  for (const PortMap& map : maps()) {
    bases.push_back({UnknownKind::kBase, map.base()});
    estimate.global_T_base.push_back({level.values().base(map.base()), level.covariance({bases.back()})});
    const std::vector<SurveyStep> steps = steps_in_world(map, level);
    estimate.steps.insert(estimate.steps.end(), steps.begin(), steps.end());
    estimate.live_maps.push_back({map.base(), {map.base()}, static_cast<int>(map.submap.landmark_count())});
  }
  if (!bases.empty() && bases.size() <= max_joint_bases) estimate.base_covariance = level.covariance(bases);
  estimate.landmarks = landmarks_in_world(maps(), level);
  if (estimate.landmarks.size() <= kMaxJointLandmarks) estimate.landmark_covariance = joint_landmark_covariance(maps(), level);
  return estimate;
}

}  // namespace ssjs
