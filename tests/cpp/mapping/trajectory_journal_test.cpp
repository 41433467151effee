#include "ssjs/mapping/trajectory_journal.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "filter/dense_filter.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using testing::largest_difference;
using testing::random_covariance;
using testing::random_matrix;
using testing::random_motion;
using testing::random_observation;

constexpr double kTolerance = 1e-9;  // of covariances near 1

/// A linear Kalman filter over [vehicle | landmarks | clones of past vehicle poses]: what the journal has to reproduce. Covariances
/// only, as nothing here depends on the means.
class ClonedFilter {
 public:
  void reset(const Eigen::Matrix3d& covariance) {
    P_ = covariance;
    landmarks_ = 0;
    filtered_.clear();
  }
  void predict(const MotionPrediction& motion) {
    Eigen::MatrixXd F = Eigen::MatrixXd::Identity(P_.rows(), P_.rows());
    F.topLeftCorner<3, 3>() = motion.F;
    move(F);
    P_.topLeftCorner<3, 3>() += motion.Q;
  }
  void clone() {
    Eigen::MatrixXd G = Eigen::MatrixXd::Zero(P_.rows() + 3, P_.rows());
    G.topRows(P_.rows()).setIdentity();
    G.bottomLeftCorner<3, 3>().setIdentity();
    filtered_.push_back({P_.topLeftCorner<3, 3>(), P_.topLeftCorner(3, 3 + 2 * landmarks_)});
    P_ = (G * P_ * G.transpose()).eval();
  }
  void add(const Eigen::Matrix<double, 2, 3>& J_vehicle, const Eigen::Matrix2d& noise) {
    const Eigen::Index at = 3 + 2 * landmarks_++;
    const Eigen::Index clones = P_.rows() - at;
    Eigen::MatrixXd G = Eigen::MatrixXd::Zero(P_.rows() + 2, P_.rows());
    G.topLeftCorner(at, at).setIdentity();
    G.block<2, 3>(at, 0) = J_vehicle;
    G.bottomRightCorner(clones, clones).setIdentity();
    move(G);
    P_.block<2, 2>(at, at) += noise;
    for (Filtered& past : filtered_) past.with_state = (past.with_state * G.topLeftCorner(at + 2, at).transpose()).eval();
  }
  void remove(Eigen::Index landmark) {
    const Eigen::Index last = 3 + 2 * --landmarks_;
    const Eigen::Index clones = P_.rows() - last - 2;
    Eigen::MatrixXd G = Eigen::MatrixXd::Zero(P_.rows() - 2, P_.rows());
    G.topLeftCorner(last, last).setIdentity();
    G.bottomRightCorner(clones, clones).setIdentity();
    if (3 + 2 * landmark != last) {
      G.middleRows<2>(3 + 2 * landmark).setZero();
      G.block<2, 2>(3 + 2 * landmark, last).setIdentity();
    }
    move(G);
    for (Filtered& past : filtered_) past.with_state = (past.with_state * G.topLeftCorner(last, last + 2).transpose()).eval();
  }
  /// t: how the coordinates follow a turn of the heading (F-8), zero for an additive filter.
  void update(const std::vector<LinearObservation>& observations, const Eigen::VectorXd& t) {
    const auto k = static_cast<Eigen::Index>(2 * observations.size());
    const Eigen::Index n = 3 + 2 * landmarks_;
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(k, P_.rows());
    Eigen::MatrixXd R = Eigen::MatrixXd::Zero(k, k);
    for (Eigen::Index i = 0; i < k; i += 2) {
      const LinearObservation& z = observations[static_cast<std::size_t>(i / 2)];
      H.block<2, 3>(i, 0) = z.H_vehicle;
      H.block<2, 2>(i, 3 + 2 * z.landmark) = z.H_landmark;
      R.block<2, 2>(i, i) = z.R;
    }
    const Eigen::MatrixXd K = P_ * H.transpose() * (H * P_ * H.transpose() + R).inverse();
    const Eigen::MatrixXd A = Eigen::MatrixXd::Identity(P_.rows(), P_.rows()) - K * H;
    for (Filtered& past : filtered_) past.with_state = (past.with_state * A.topLeftCorner(n, n).transpose()).eval();
    P_ = (A * P_ * A.transpose() + K * R * K.transpose()).eval();
    Eigen::MatrixXd T = Eigen::MatrixXd::Identity(P_.rows(), P_.rows());
    T.block(0, 2, n, 1) += t;
    move(T);
  }

  [[nodiscard]] Eigen::Matrix3d exit_covariance() const { return P_.topLeftCorner<3, 3>(); }
  [[nodiscard]] Eigen::Matrix3d clone_with_exit(std::size_t clone) const { return P_.block<3, 3>(at(clone), 0); }
  [[nodiscard]] Eigen::Matrix3d smoothed_covariance(std::size_t clone) const { return P_.block<3, 3>(at(clone), at(clone)); }
  [[nodiscard]] Eigen::Matrix3d filtered_covariance(std::size_t clone) const { return filtered_[clone].covariance; }
  /// Cov(error of the pose as it was filtered then, error of the exit pose now).
  [[nodiscard]] Eigen::Matrix3d filtered_with_exit(std::size_t clone) const { return filtered_[clone].with_state.leftCols<3>(); }

 private:
  /// A past pose whose estimate is left as it was: only its correlation with the present error moves, by the same matrices.
  struct Filtered {
    Eigen::Matrix3d covariance;
    Eigen::Matrix<double, 3, Eigen::Dynamic> with_state;
  };

  void move(const Eigen::MatrixXd& G) {
    P_ = (G * P_ * G.transpose()).eval();
    if (G.rows() == G.cols()) {
      const Eigen::Index n = 3 + 2 * landmarks_;
      for (Filtered& past : filtered_) past.with_state = (past.with_state * G.topLeftCorner(n, n).transpose()).eval();
    }
  }
  [[nodiscard]] Eigen::Index at(std::size_t clone) const { return 3 + 2 * landmarks_ + static_cast<Eigen::Index>(3 * clone); }

  Eigen::MatrixXd P_;
  Eigen::Index landmarks_ = 0;
  std::vector<Filtered> filtered_;
};

/// The filter with its journal, and the oracle, through the same operations.
struct Twin {
  explicit Twin(const Eigen::Matrix3d& start, ErrorForm form = ErrorForm::kAdditive) : filter(4, form), error_form(form) {
    filter.reset({{}, start});
    filter.watch(&journal);
    oracle.reset(start);
  }
  void predict(Rng& rng) {
    MotionPrediction motion = random_motion(rng, filter.vehicle_pose());
    motion.F.leftCols<2>().setIdentity();  // a motion of the plane
    motion.F(2, 2) = 1.0;
    filter.predict(motion);
    oracle.predict(motion);
  }
  void step() {
    journal.step(static_cast<double>(steps++), filter);
    oracle.clone();
  }
  void add(Rng& rng) {
    const Eigen::Matrix<double, 2, 3> J = random_matrix(rng, 2, 3, 0.7);
    const Eigen::Matrix2d noise = random_covariance(rng, 2, 0.3);
    filter.add_landmark(Eigen::Vector2d(1.0, 1.0), J, noise);
    oracle.add(J, noise);
  }
  void remove(Rng& rng) {
    const auto gone = static_cast<Eigen::Index>(rng.below(static_cast<std::uint64_t>(filter.landmarks())));
    filter.remove_landmark(gone);
    oracle.remove(gone);
  }
  void update(Rng& rng, int count) {
    std::vector<LinearObservation> observations;
    for (int i = 0; i < count; ++i) {
      observations.push_back(random_observation(rng, static_cast<Eigen::Index>(rng.below(static_cast<std::uint64_t>(filter.landmarks())))));
    }
    const Eigen::VectorXd before = filter.state().mean;
    (void)filter.update(observations);
    Eigen::VectorXd t = Eigen::VectorXd::Zero(before.size());
    if (error_form == ErrorForm::kInvariant) {
      const Eigen::VectorXd moved = filter.state().mean - before;
      t.head<2>() << -moved(1), moved(0);
      for (Eigen::Index at = 3; at < t.size(); at += 2) t.segment<2>(at) << -moved(at + 1), moved(at);
    }
    oracle.update(observations, t);
  }
  [[nodiscard]] std::vector<SubmapStep> conditioned() { return journal.take_steps({filter.vehicle_pose(), filter.vehicle_covariance()}); }

  TrajectoryJournal journal;
  Ekf filter;
  ErrorForm error_form;
  ClonedFilter oracle;
  int steps = 0;
};

void expect_oracle(Twin& twin) {
  const std::vector<SubmapStep> steps = twin.conditioned();
  ASSERT_EQ(steps.size(), static_cast<std::size_t>(twin.steps));
  const Eigen::Matrix3d P_exit = twin.oracle.exit_covariance();
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const Eigen::Matrix3d gain = twin.oracle.clone_with_exit(i) * P_exit.inverse();
    EXPECT_LE(largest_difference(steps[i].covariance, twin.oracle.filtered_covariance(i)), kTolerance) << "step " << i;
    EXPECT_LE(largest_difference(steps[i].exit_gain, gain), kTolerance) << "step " << i;
    // The estimate is left as it was filtered, so its covariance given the exit is that of the filtered error.
    const Eigen::Matrix3d with_exit = twin.oracle.filtered_with_exit(i);
    const Eigen::Matrix3d conditional = twin.oracle.filtered_covariance(i) - with_exit * P_exit.inverse() * with_exit.transpose();
    EXPECT_LE(largest_difference(steps[i].conditional_covariance, conditional), kTolerance) << "step " << i;
  }
}

/// Motion with and without a step, several updates in a row, landmarks that come and go.
void drive(Twin& twin, Rng& rng, int rounds) {
  for (int round = 0; round < rounds; ++round) {
    for (std::uint64_t i = 0; i <= rng.below(3); ++i) {
      twin.predict(rng);
      if (rng.below(3) != 0) twin.step();
    }
    if (round % 3 == 1) twin.add(rng);
    if (round % 4 == 3 && twin.filter.landmarks() > 2) twin.remove(rng);
    if (round % 5 != 4) twin.update(rng, 1 + static_cast<int>(rng.below(3)));
    if (round % 5 == 2) twin.update(rng, 2);
    if (round % 6 == 5) twin.add(rng);
    twin.step();
  }
}

TEST(TrajectoryJournal, C3_C4_GainsEqualTheFilterWithClonedPoses) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Rng rng(seed);
    Twin twin(random_covariance(rng, 3, 0.4));
    twin.step();  // the first pose, before anything has happened
    for (int i = 0; i < 3; ++i) twin.add(rng);
    drive(twin, rng, 15);
    expect_oracle(twin);
  }
}

TEST(TrajectoryJournal, C3_C4_FollowsAnInvariantFilterToo) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Rng rng(seed);
    Twin twin(random_covariance(rng, 3, 0.4), ErrorForm::kInvariant);
    twin.step();
    for (int i = 0; i < 3; ++i) twin.add(rng);
    drive(twin, rng, 15);
    expect_oracle(twin);
  }
}

TEST(TrajectoryJournal, C3_WhatHappensAfterTheLastStepCounts) {
  Rng rng(331);
  Twin twin(random_covariance(rng, 3, 0.4));
  twin.step();
  for (int i = 0; i < 4; ++i) twin.add(rng);
  drive(twin, rng, 5);
  twin.predict(rng);
  twin.update(rng, 2);
  expect_oracle(twin);
  twin.remove(rng);
  expect_oracle(twin);
  twin.predict(rng);  // motion that no update follows: a closing scan of new landmarks only
  twin.predict(rng);
  expect_oracle(twin);
}

TEST(TrajectoryJournal, C4_TheExitItselfHasUnitGainAndNothingLeft) {
  Rng rng(332);
  Twin twin(random_covariance(rng, 3, 0.4));
  for (int i = 0; i < 3; ++i) twin.add(rng);
  drive(twin, rng, 8);
  const SubmapStep exit = twin.conditioned().back();
  EXPECT_LE(largest_difference(exit.exit_gain, Eigen::Matrix3d::Identity()), kTolerance);
  EXPECT_LE(exit.conditional_covariance.cwiseAbs().maxCoeff(), kTolerance);
}

TEST(TrajectoryJournal, C4_LeavesOutWhatLaterScansSayBesidesTheExit) {
  // The clone of a filter is smoothed by every later scan; the journal's pose follows the exit alone. Its covariance given the exit is
  // therefore never smaller, and is larger where landmarks were seen again.
  Rng rng(333);
  Twin twin(random_covariance(rng, 3, 0.4));
  twin.step();
  for (int i = 0; i < 3; ++i) twin.add(rng);
  drive(twin, rng, 12);
  const std::vector<SubmapStep> steps = twin.conditioned();
  double largest = 0.0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const Eigen::Matrix3d with_exit = twin.oracle.clone_with_exit(i);
    const Eigen::Matrix3d smoothed =
        twin.oracle.smoothed_covariance(i) - with_exit * twin.oracle.exit_covariance().inverse() * with_exit.transpose();
    const Eigen::Vector3d eigenvalues = (steps[i].conditional_covariance - smoothed).selfadjointView<Eigen::Lower>().eigenvalues();
    EXPECT_GE(eigenvalues.minCoeff(), -kTolerance) << "step " << i;
    largest = std::max(largest, eigenvalues.maxCoeff());
  }
  EXPECT_GT(largest, 1e-4);
}

TEST(TrajectoryJournal, C3_TwoStepsByHand) {
  // x1 = x0 + w, P0 = 1, Var w = 3 (every component alone): Cov(e0, e1) = 1, P1 = 4: gain 1/4, conditional 1 - 1/4.
  Twin twin(Eigen::Matrix3d::Identity());
  twin.step();
  twin.filter.predict({{}, Eigen::Matrix3d::Identity(), 3.0 * Eigen::Matrix3d::Identity()});
  const std::vector<SubmapStep> steps = twin.conditioned();
  EXPECT_LE(largest_difference(steps[0].exit_gain, 0.25 * Eigen::Matrix3d::Identity()), kTolerance);
  EXPECT_LE(largest_difference(steps[0].conditional_covariance, 0.75 * Eigen::Matrix3d::Identity()), kTolerance);
}

TEST(TrajectoryJournal, RefusesWhatIsNoMotionOfThePlane) {
  Twin twin(Eigen::Matrix3d::Identity());
  EXPECT_THROW(twin.filter.predict({{}, 0.9 * Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Identity()}), InvalidArgument);
}

TEST(TrajectoryJournal, UnconditionedStepsAreAsFiltered) {
  Rng rng(334);
  Twin twin(random_covariance(rng, 3, 0.4));
  for (int i = 0; i < 3; ++i) twin.add(rng);
  drive(twin, rng, 4);
  for (const SubmapStep& step : twin.journal.take_unconditioned_steps()) {
    EXPECT_EQ(step.exit_gain, Eigen::Matrix3d::Zero());
    EXPECT_EQ(step.conditional_covariance, step.covariance);
  }
}

TEST(TrajectoryJournal, ClearStartsOver) {
  Rng rng(335);
  const Eigen::Matrix3d start = random_covariance(rng, 3, 0.4);
  Twin twin(start);
  for (int i = 0; i < 5; ++i) twin.add(rng);
  drive(twin, rng, 6);
  twin.predict(rng);  // left pending
  twin.journal.clear();
  twin.filter.reset({{}, start});
  twin.oracle.reset(start);
  twin.steps = 0;
  twin.step();
  twin.add(rng);
  twin.add(rng);
  drive(twin, rng, 6);
  expect_oracle(twin);
}

}  // namespace
}  // namespace ssjs
