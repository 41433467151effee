#include "ssjs/mapping/levelled_journal.hpp"

#include <utility>

namespace ssjs {
namespace {

constexpr double kExitVariance = 1e-12;  // as in TrajectoryJournal: a vehicle that hardly moved, an offset that does not drift

}  // namespace

void LevelledJournal::step(double time_s, const LevelledFilter& filter) { record_.step(time_s, filter, conditions_); }

std::vector<LevelledStep> LevelledJournal::take_steps(const LevelledFilter& filter, const std::vector<Eigen::Index>& exit) {
  std::vector<LevelledStep> steps = record_.smoothed(filter.size(), exit, exit_covariance(filter, exit));
  clear();
  return steps;
}

UnsmoothedSteps LevelledJournal::take_unsmoothed(const LevelledFilter& filter, const std::vector<Eigen::Index>& exit,
                                                 LevelledRecord blank) {
  blank.clear();
  blank.match(record_);
  return {std::exchange(record_, std::move(blank)), filter.size(), exit, exit_covariance(filter, exit)};
}

Eigen::MatrixXd LevelledJournal::exit_covariance(const LevelledFilter& filter, const std::vector<Eigen::Index>& exit) {
  const auto p = static_cast<Eigen::Index>(exit.size());
  return filter.covariance()(exit, exit) + kExitVariance * Eigen::MatrixXd::Identity(p, p);
}

}  // namespace ssjs
