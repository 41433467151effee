#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "ssjs/base/angle.hpp"
#include "study.hpp"

namespace ssjs::benchmarks {
namespace {

constexpr std::size_t kTurnPings = 5;

/// By the true headings; the survey leaves such pings out by the measured ones.
bool turns(const std::vector<SonarPose>& poses, std::size_t ping, double most_rad_s) {
  const SonarPose& from = poses[ping > kTurnPings ? ping - kTurnPings : 0];
  const SonarPose& to = poses[std::min(ping + kTurnPings, poses.size() - 1)];
  return std::abs(angle_difference(to.world_T_sonar.rpy.z(), from.world_T_sonar.rpy.z())) > most_rad_s * (to.time_s - from.time_s);
}

JudgedContact judge_contact(const SurveyRun& run, const SideScanContact& contact, const SideScanSurveyConfig& config) {
  const auto ping = static_cast<std::size_t>(contact.index);
  const SonarPose& pose = run.poses[ping];
  const Eigen::Matrix3d body_R_world = pose.world_T_sonar.rotation().transpose();
  JudgedContact judged;
  judged.contact = &contact;
  judged.in_turn = turns(run.poses, ping, config.most_turn_rate_rad_s);
  double nearest_m = kMatch_m;
  for (std::size_t i = 0; i < run.objects.size(); ++i) {
    const Eigen::Vector3d body_p_object = body_R_world * (run.feet_m[i] - pose.world_T_sonar.translation);
    const Eigen::Vector2d error_m = (contact.body_p_contact.position_m - body_p_object).head<2>();
    if (!(error_m.norm() < nearest_m)) continue;
    nearest_m = error_m.norm();
    judged.object = &run.objects[i];
    const Eigen::Matrix2d P = contact.body_p_contact.covariance_m2.topLeftCorner<2, 2>();
    judged.error_m = {error_m.x(), starboard_sign(contact.side) * error_m.y()};
    judged.nis = error_m.dot(P.inverse() * error_m);
    judged.normalised = judged.error_m.cwiseQuotient(P.diagonal().cwiseSqrt());
  }
  return judged;
}

}  // namespace

Judgement judge(const SurveyRun& run, const SideScanSurveyConfig& config) {
  Judgement judgement;
  for (const SideScanContact& contact : run.contacts) judgement.contacts.push_back(judge_contact(run, contact, config));
  const auto same_pass = [](std::uint64_t a, std::uint64_t b) { return (a > b ? a - b : b - a) < 40; };
  for (JudgedContact& judged : judgement.contacts) {
    judged.is_second = judged.object && std::any_of(judgement.contacts.begin(), judgement.contacts.end(), [&](const JudgedContact& other) {
                         return &other != &judged && other.object == judged.object &&
                                same_pass(other.contact->index, judged.contact->index) && other.error_m.norm() < judged.error_m.norm();
                       });
  }
  for (const ObjectSighting& sighting : run.sightings) {
    const double range_m = std::abs(sighting.body_p_object.y());
    if (range_m < kLeastGroundRange_m || range_m > kMostGroundRange_m) continue;
    if (turns(run.poses, sighting.ping, config.most_turn_rate_rad_s)) continue;
    JudgedPass pass;
    pass.object = &run.objects[static_cast<std::size_t>(sighting.object)];
    pass.ground_range_m = range_m;
    pass.found = std::any_of(judgement.contacts.begin(), judgement.contacts.end(), [&](const JudgedContact& judged) {
      return judged.object == pass.object && same_pass(judged.contact->index, sighting.ping);
    });
    judgement.passes.push_back(pass);
  }
  return judgement;
}

}  // namespace ssjs::benchmarks
