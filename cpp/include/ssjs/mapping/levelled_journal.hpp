/// Remembers what the filter of a levelled map did, so that past poses know all that the map measured after them, and can be conditioned
/// on its exit. docs/math/submaps.md (C-3, C-4), auv.md, [bierman1973].
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "ssjs/base/archive.hpp"
#include "ssjs/filter/levelled_filter.hpp"
#include "ssjs/mapping/levelled_record.hpp"
#include "ssjs/mapping/levelled_submap.hpp"

namespace ssjs {

/// What it remembers lies in memory that is kept from map to map.
class LevelledJournal final : public LevelledFilterWatcher {
 public:
  static constexpr std::size_t kMostBytes = std::size_t{256} << 20U;

  /// Without conditions, steps stay as filtered (a gain of zero on the exit) and nothing else is remembered. The same becomes of the
  /// oldest steps of a map for which `most_bytes` do not suffice: hours in one map.
  explicit LevelledJournal(bool conditions = true, std::size_t most_bytes = kMostBytes) : conditions_(conditions), record_(most_bytes) {}

  void clear() { record_.clear(); }

  void on_predict(const VehicleMatrix& F) override { record_.predict(F); }
  void on_update(const std::vector<StateRows>& rows, const std::vector<Eigen::Index>& offsets, const Eigen::Ref<const Eigen::MatrixXd>& Y,
                 const Eigen::Ref<const Eigen::MatrixXd>& L) override {
    record_.update(rows, offsets, Y, L);
  }
  void on_add(const Eigen::Ref<const Eigen::MatrixXd>& J_vehicle) override { record_.add(J_vehicle); }
  void on_convert(Eigen::Index offset, const Eigen::Matrix<double, 3, 6>& J) override { record_.convert(offset, J); }
  void on_drop(Eigen::Index offset, Eigen::Index rows) override { record_.drop(offset, rows); }

  /// The present pose becomes a step of the trajectory.
  void step(double time_s, const LevelledFilter& filter);

  /// Hands the steps over, smoothed, with their gain on these entries of the filter's present state. The journal is empty
  /// then.
  [[nodiscard]] std::vector<LevelledStep> take_steps(const LevelledFilter& filter, const std::vector<Eigen::Index>& exit);
  /// The same without the work, which costs as much as some hundred filter steps; goes on in `blank`, a record with this journal's limit.
  [[nodiscard]] UnsmoothedSteps take_unsmoothed(const LevelledFilter& filter, const std::vector<Eigen::Index>& exit, LevelledRecord blank);

 private:
  [[nodiscard]] static Eigen::MatrixXd exit_covariance(const LevelledFilter& filter, const std::vector<Eigen::Index>& exit);

  bool conditions_;
  LevelledRecord record_;

 public:
  void archive(Archive& a) { a("record", record_); }
  [[nodiscard]] bool fits(const LevelledFilter& filter) const { return record_.fits(filter.size()); }
};

}  // namespace ssjs
