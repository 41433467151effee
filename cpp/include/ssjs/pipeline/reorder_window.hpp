/// Puts samples that arrive late or out of order back into the order in which they were taken, before the filter sees them.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "ssjs/base/archive.hpp"
#include "ssjs/features/navigation_tick.hpp"

namespace ssjs {

/// What became of a sample on its arrival.
enum class Arrival {
  kTaken,
  kLate,       ///< older than the window: what was done with the samples around it is not undone
  kDuplicate,  ///< this sensor has spoken at that very time
  kNotFinite,  ///< NaN or infinity in it, or a covariance that is not symmetric and positive definite
  kClockJump,  ///< so far ahead of all before that its clock is doubted; believed once `jump_samples` in a row agree
  kFlood,      ///< more than the window holds
};

struct ReorderConfig {
  double window_s = 1.0;
  double max_gap_s = 60.0;
  int jump_samples = 5;
  bool gaps_are_silence = true;
  int capacity = 4096;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("window_s", window_s, Rule::not_negative(), "samples that come so much later than others are sorted in; the filter lags by it");
    v.field("max_gap_s", max_gap_s, Rule::positive(),
            "a sample farther ahead of all before is a clock that jumped, until others follow it");
    v.field("jump_samples", jump_samples, Rule::at_least(1), "so many samples in a row after a gap make it a true one");
    v.field("gaps_are_silence", gaps_are_silence,
            "a gap that samples follow is a silence, in which the vehicle went somewhere; false: its clock was set, and time goes on as "
            "before");
    v.field("capacity", capacity, Rule::at_least(16), "times held in the window, and sightings; more is a flood and is refused");
  }
};

/// Time here goes on as it began: where the clock of the samples is set back, or ahead with gaps_are_silence = false, what it was set by is
/// added to all later stamps. Samples of one time are one tick. A tick is due when a sample has arrived that was taken more than the window
/// later.
class ReorderWindow {
 public:
  explicit ReorderWindow(const ReorderConfig& config);

  /// One tick, as a rule of a single sensor; what it holds is merged with the samples of the same time.
  Arrival put(const NavigationTick& tick);

  /// The oldest tick, once it is due; with `all` also when it is not (the end of a mission). Samples of its time or before are kLate from
  /// now on.
  /// Valid until the next call; nullptr when nothing is due.
  [[nodiscard]] const NavigationTick* take(bool all = false);

  [[nodiscard]] const std::map<double, NavigationTick>& waiting() const { return waiting_; }  ///< by time
  [[nodiscard]] std::optional<double> newest_s() const { return newest_s_; }
  [[nodiscard]] double clock_offset_s() const { return offset_s_; }  ///< added to the stamps of samples that arrive now
  [[nodiscard]] int clock_changes() const { return clock_changes_; }

 private:
  [[nodiscard]] bool is_jump(double time_s);
  [[nodiscard]] bool was_set_back(double time_s, unsigned kinds);
  void set_clock(double by_s);

  ReorderConfig config_;
  using Ticks = std::map<double, NavigationTick>;
  Ticks waiting_;
  std::vector<Ticks::node_type> spare_;  ///< what was taken gives its memory to what comes
  Ticks::node_type taken_;               ///< the last one
  std::optional<double> newest_s_;       ///< of all samples believed
  std::optional<double> given_out_s_;    ///< of the last tick taken
  std::optional<double> suspect_s_;      ///< of the last sample beyond the gap
  int suspects_ = 0;
  double offset_s_ = 0.0;
  int clock_changes_ = 0;
  std::size_t sightings_ = 0;  ///< that wait
  // navigation samples too late, one after the other with none in time between
  int late_in_a_row_ = 0;
  unsigned late_kinds_ = 0, heard_kinds_ = 0;  ///< a bit a sensor
  double first_late_s_ = 0.0, last_late_s_ = 0.0;

 public:
  void archive(Archive& a) {
    a("waiting", waiting_);
    a("newest_s", newest_s_);
    a("given_out_s", given_out_s_);
    a("suspect_s", suspect_s_);
    a("suspects", suspects_);
    a("offset_s", offset_s_);
    a("clock_changes", clock_changes_);
    a("sightings", sightings_);
    a("late_in_a_row", late_in_a_row_);
    a("late_kinds", late_kinds_);
    a("heard_kinds", heard_kinds_);
    a("first_late_s", first_late_s_);
    a("last_late_s", last_late_s_);
    for (const auto& [time_s, tick] : waiting_) a.require(time_s == tick.time_s, "holds a sample at another time than its own");
    a.require(waiting_.empty() || newest_s_.has_value(), "holds samples but no newest one");
  }
};

}  // namespace ssjs
