/// Remembers what the filter did inside one submap, so that every past pose can be conditioned on the exit pose when the
/// submap closes: the adjoint recursion of the fixed-interval smoother (Bryson and Frazier 1963), for the exit pose alone.
/// docs/math/submaps.md (C-3, C-4).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "ssjs/filter/ekf.hpp"
#include "ssjs/filter/filter_watcher.hpp"
#include "ssjs/mapping/submap.hpp"

namespace ssjs {

/// Memory grows with the scans of one submap and is kept for the next: after the largest submap nothing allocates but the steps.
///
/// A motion of the plane is a shear of the pose error: the heading's error moves the position, F = [I lever; 0 1], and one motion after
/// the other adds their levers.
class TrajectoryJournal final : public FilterWatcher {
 public:
  void clear();

  void on_predict(const Eigen::Matrix3d& F) override;
  void on_update(const std::vector<LinearObservation>& observations, const Eigen::Ref<const Eigen::MatrixXd>& Y,
                 const Eigen::Ref<const Eigen::MatrixXd>& L, const Eigen::Ref<const Eigen::VectorXd>& t) override;
  void on_add(const Eigen::Matrix<double, 2, 3>& J_vehicle) override;
  void on_remove(Eigen::Index landmark, Eigen::Index last) override;

  /// The present pose becomes a step of the trajectory.
  void step(double time_s, Ekf& filter);

  /// Hands the steps over, with their gain on the exit pose (C-4). unconditioned: without a gain, as filtered. clear() comes next.
  [[nodiscard]] std::vector<SubmapStep> take_steps(const GaussianSe2& base_T_exit);
  [[nodiscard]] std::vector<SubmapStep> take_unconditioned_steps();

 private:
  enum class Kind { kStep, kUpdate, kAdd, kRemove };
  struct Entry {
    Kind kind = Kind::kStep;
    Eigen::Vector2d lever = Eigen::Vector2d::Zero();  ///< of the vehicle's motion since the entry before
    std::size_t data = 0;                             ///< where its numbers start in numbers_
    Eigen::Index rows = 0;                            ///< update: state size n; step: landmark coordinates in the snapshot
    Eigen::Index columns = 0;                         ///< update: innovation size k; remove: index of the last landmark
    std::size_t observation = 0;                      ///< update: first of k / 2 in observations_
    Eigen::Index landmark = 0;                        ///< remove
    bool has_snapshot = false;                        ///< step: numbers_ holds P(vehicle, landmarks) at this step
  };

  void push(Entry entry);
  void store(const Eigen::Ref<const Eigen::MatrixXd>& matrix);

  std::vector<Entry> entries_;
  std::vector<double> numbers_;
  std::vector<LinearObservation> observations_;
  std::vector<SubmapStep> steps_;
  std::size_t expected_steps_ = 0;                   ///< as many as the submap before had
  Eigen::Vector2d lever_ = Eigen::Vector2d::Zero();  ///< since the last entry
  bool snapshot_due_ = true;
};

}  // namespace ssjs
