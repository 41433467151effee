/// What the filter of one levelled map did, on record: enough to smooth its steps afterwards, at leisure and on any thread.
/// docs/math/submaps.md (C-3, C-4), auv.md, camera.md (I-10), [bierman1973].
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string_view>
#include <vector>

#include "ssjs/base/archive.hpp"
#include "ssjs/filter/levelled_filter.hpp"
#include "ssjs/mapping/levelled_submap.hpp"
#include "ssjs/mapping/tape.hpp"

namespace ssjs {

/// One block of an update, with where its landmark began in the state then.
struct RecordedRows {
  StateRows rows;
  Eigen::Index offset = 0;

  void archive(Archive& a) {
    a("rows", rows);
    a("offset", offset);
  }
};

class LevelledRecord {
 public:
  /// The oldest entries are forgotten where `most_bytes` do not suffice: hours in one map.
  explicit LevelledRecord(std::size_t most_bytes);

  void clear();                             ///< keeps the memory
  void match(const LevelledRecord& other);  ///< memory for as much as `other` has come to
  void predict(const VehicleMatrix& F);
  void update(const std::vector<StateRows>& rows, const std::vector<Eigen::Index>& offsets, const Eigen::Ref<const Eigen::MatrixXd>& Y,
              const Eigen::Ref<const Eigen::MatrixXd>& L);
  void add(const Eigen::Ref<const Eigen::MatrixXd>& J_vehicle);
  void convert(Eigen::Index offset, const Eigen::Matrix<double, 3, 6>& J);
  void drop(Eigen::Index offset, Eigen::Index rows);
  /// The present pose is a step of the trajectory; `conditioned`: to be smoothed.
  void step(double time_s, const LevelledFilter& filter, bool conditioned);

  /// The steps, smoothed, with their gain on these entries of the filter's last state: of `size` entries, these of them with
  /// covariance P_exit. Steps that were forgotten or not to be smoothed stay as filtered, with a gain of zero.
  [[nodiscard]] std::vector<LevelledStep> smoothed(Eigen::Index size, const std::vector<Eigen::Index>& exit,
                                                   const Eigen::MatrixXd& P_exit) const;

 private:
  enum class Kind { kStep, kUpdate, kAdd, kConvert, kDrop };
  using Matrix = Eigen::Map<const Eigen::MatrixXd>;
  struct Entry {
    Kind kind = Kind::kStep;
    std::size_t bytes = 0;
    Tape<double>::Piece F;     ///< 20 x 20, of the motion since the entry before
    Tape<double>::Piece Y, L;  ///< n x k and k x k of kUpdate; Y: 6 x n, P(pose, all), of kStep; J_vehicle of kAdd; J, 3 x 6, of kConvert
    Eigen::Index Y_rows = 0, Y_columns = 0;
    Eigen::Index offset = 0, dropped = 0;  ///< where rows changed, kConvert and kDrop, and how many are gone, kDrop
    Tape<RecordedRows>::Piece rows;        ///< kUpdate
    std::size_t row_blocks = 0;
  };
  struct FilteredStep {
    double time_s;
    Eigen::Matrix<double, 6, 1> pose;
    Matrix6d covariance;

    void archive(Archive& a) {
      a("time_s", time_s);
      a("pose", pose);
      a("covariance", covariance);
    }
  };

  Entry& push(Kind kind);
  [[nodiscard]] Tape<double>::Piece copy(const Eigen::Ref<const Eigen::MatrixXd>& matrix);
  void limit();

  std::size_t most_bytes_;
  std::size_t bytes_ = 0;  ///< of the entries from oldest_ on
  std::size_t oldest_ = 0;
  std::vector<Entry> entries_;
  std::vector<FilteredStep> steps_;
  Tape<double> numbers_;
  Tape<RecordedRows> rows_;
  VehicleMatrix F_ = VehicleMatrix::Identity();  ///< since the last entry

 public:
  /// What was not forgotten; reads into an empty record.
  void archive(Archive& a);
  /// Whether a filter that has `size` entries by now can have done this.
  [[nodiscard]] bool fits(Eigen::Index size) const;

 private:
  [[nodiscard]] static bool update_fits(const Entry& entry, Eigen::Index size);
  void archive_entry(Archive& a, Entry& entry);
  void archive_motion(Archive& a, Tape<double>::Piece& piece);
  void archive_numbers(Archive& a, std::string_view name, Tape<double>::Piece& piece, Eigen::Index rows, Eigen::Index columns);
};

/// The steps of a map that were not smoothed yet.
struct UnsmoothedSteps {
  LevelledRecord record;
  Eigen::Index size = 0;
  std::vector<Eigen::Index> exit;
  Eigen::MatrixXd P_exit;

  [[nodiscard]] std::vector<LevelledStep> smoothed() const { return record.smoothed(size, exit, P_exit); }
};

}  // namespace ssjs
