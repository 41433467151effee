/// Remembers what the filter of a levelled map did, so that past poses know all that the map measured after them, and can be conditioned
/// on its exit. docs/math/submaps.md (C-3, C-4), auv.md, [bierman1973].
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <deque>
#include <vector>

#include "ssjs/base/archive.hpp"
#include "ssjs/filter/levelled_filter.hpp"
#include "ssjs/mapping/levelled_submap.hpp"

namespace ssjs {

class LevelledJournal final : public LevelledFilterWatcher {
 public:
  static constexpr std::size_t kMostBytes = std::size_t{256} << 20U;

  /// Without conditions, steps stay as filtered (a gain of zero on the exit) and nothing else is remembered. The same becomes of the
  /// oldest steps of a map for which `most_bytes` do not suffice: hours in one map.
  explicit LevelledJournal(bool conditions = true, std::size_t most_bytes = kMostBytes)
      : conditions_(conditions), most_bytes_(most_bytes) {}

  void clear();

  void on_predict(const VehicleMatrix& F) override;
  void on_update(const std::vector<StateRows>& rows, const Eigen::Ref<const Eigen::MatrixXd>& Y,
                 const Eigen::Ref<const Eigen::MatrixXd>& L) override;
  void on_add(const Eigen::Matrix<double, 3, VehicleLayout::kSize>& J_vehicle) override;

  /// The present pose becomes a step of the trajectory.
  void step(double time_s, const LevelledFilter& filter);

  /// Hands the steps over, smoothed, with their gain on these entries of the filter's present state. The journal is empty
  /// then.
  [[nodiscard]] std::vector<LevelledStep> take_steps(const LevelledFilter& filter, const std::vector<Eigen::Index>& exit);

 private:
  enum class Kind { kStep, kUpdate, kAdd };
  struct Entry {
    Kind kind = Kind::kStep;
    VehicleMatrix F;                                           ///< of the motion since the entry before
    Eigen::MatrixXd Y, L;                                      ///< kUpdate; kStep: Y = P(pose, all)
    std::vector<StateRows> rows;                               ///< kUpdate
    Eigen::Matrix<double, 3, VehicleLayout::kSize> J_vehicle;  ///< kAdd

    void archive(Archive& a) {
      a.choice("kind", kind, Kind::kAdd);
      a("F", F);
      if (kind != Kind::kAdd) a("Y", Y);
      if (kind == Kind::kUpdate) {
        a("L", L);
        a("rows", rows);
      }
      if (kind == Kind::kAdd) a("J_vehicle", J_vehicle);
    }
  };

  Entry& push(Kind kind);
  void limit();
  [[nodiscard]] static std::size_t bytes_of(const Entry& entry);
  [[nodiscard]] std::vector<LevelledStep> take();

  bool conditions_;
  std::size_t most_bytes_;
  std::size_t bytes_ = 0;      ///< of the entries
  std::deque<Entry> entries_;  ///< without those that were forgotten
  std::vector<LevelledStep> steps_;
  VehicleMatrix F_ = VehicleMatrix::Identity();  ///< since the last entry

 public:
  void archive(Archive& a);
};

}  // namespace ssjs
