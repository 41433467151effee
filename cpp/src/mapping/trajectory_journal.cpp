#include "ssjs/mapping/trajectory_journal.hpp"

namespace ssjs {

void TrajectoryJournal::clear() { steps_.clear(); }

void TrajectoryJournal::step(double time_s, const Se2& base_T_vehicle, const Eigen::Matrix3d& covariance) {
  steps_.push_back({time_s, base_T_vehicle, covariance, Eigen::Matrix3d::Zero(), covariance});
}

std::vector<SubmapStep> TrajectoryJournal::steps(const GaussianSe2& /*base_T_exit*/) const { return steps_; }

}  // namespace ssjs
