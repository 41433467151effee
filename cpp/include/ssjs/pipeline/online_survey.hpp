/// The SLAM of an underwater vehicle inside the vehicle: fed sample by sample as they come, answers at any time, and never keeps its caller
/// waiting for the global level, which works in the background. docs/embedding.md
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "ssjs/joining/port_estimate.hpp"
#include "ssjs/joining/port_joiner.hpp"
#include "ssjs/joining/timed_closure.hpp"
#include "ssjs/mapping/levelled_builder.hpp"
#include "ssjs/pipeline/background_worker.hpp"
#include "ssjs/pipeline/levelled_pipeline.hpp"
#include "ssjs/pipeline/reorder_window.hpp"
#include "ssjs/pipeline/survey_health.hpp"

namespace ssjs {

struct OnlineSurveyConfig {
  LevelledConfig slam;
  ReorderConfig arrival;
  double joining_delay_s = 5.0;
  double silence_s = 10.0;
  double lost_sigma_m = 50.0;
  template <class Visitor>
  void visit(Visitor& v) {
    slam.visit(v);
    v.section("arrival", arrival, "samples that come late or out of order");
    v.field("joining_delay_s", joining_delay_s, Rule::not_negative(),
            "a finished submap is joined in the background; what that changes is taken over so much later, by the clock of the samples, so "
            "that the same samples always give the same estimate");
    v.field("silence_s", silence_s, Rule::positive(), "a sensor that was heard and says nothing for so long is reported silent");
    v.field("lost_sigma_m", lost_sigma_m, Rule::positive(), "with a larger standard deviation of the position the vehicle counts as lost");
  }
};

/// What a pilot or a supervisor acts on.
struct SurveyStatus {
  SurveyHealth health = SurveyHealth::kWaiting;
  double position_sigma_m = 0.0;                          ///< larger semi-axis of the horizontal error
  std::array<std::int64_t, 6> arrivals{};                 ///< samples by Arrival
  std::array<double, kNavigationSensors> silent_for_s{};  ///< since each sensor was last used; negative: never heard
  std::array<std::int64_t, kNavigationSensors> used{}, refused{};
  std::array<SensorState, kNavigationSensors> sensors{};
  std::string advice;         ///< what to do about the worst of it; empty when all is well
  int clock_changes = 0;      ///< times that the clock of the samples was found set
  double clock_offset_s = 0;  ///< of the poses' time beyond that of the samples, since
  int submaps = 0;            ///< finished
  int landmarks = 0;          ///< of the present submap
  int loop_closures = 0;      ///< pairs of maps tied so far
  int closures_refused = 0;   ///< by chance as likely, against others that agree, without submaps at their times, or taken back
  int compass_jumps = 0;
  int relocations = 0;   ///< times that fixes showed the estimate to be wrong, or an operator set it
  int waits = 0;         ///< times that the caller had to wait for the background
  bool joining = false;  ///< the background is at work; not a matter of the samples alone
};

class OnlineSurvey {
 public:
  /// Throws InvalidArgument listing every violation of the configuration.
  explicit OnlineSurvey(const OnlineSurveyConfig& config);
  OnlineSurvey(const OnlineSurvey&) = delete;
  OnlineSurvey& operator=(const OnlineSurvey&) = delete;
  ~OnlineSurvey() = default;  // waits for the background

  [[nodiscard]] const OnlineSurveyConfig& config() const { return config_; }

  /// Takes one sample, or several of one time. Everything that is due goes through the filter.
  Arrival feed(const NavigationTick& sample);
  /// Takes a loop closure from elsewhere: an acoustic or an optical place recogniser. It is held against the others when the submap of its
  /// later moment is joined. What is none, by its times or its covariance, is kNotFinite; when too many wait, kFlood.
  Arrival feed(const TimedClosure& closure);

  /// At the time of the newest sample: the filter's estimate predicted over the window, with the turn rates that wait in it. Nothing before
  /// the first sample has gone through.
  [[nodiscard]] std::optional<SurveyStep> global_T_vehicle() const;
  [[nodiscard]] SurveyStatus status() const;

  /// Told, in feed() and finish(), of what an operator wants to know; nothing is said otherwise.
  void set_log(SurveyLog log) { log_ = std::move(log); }
  [[nodiscard]] const SurveyLog& log() const { return log_; }

  /// All samples through, the last submap closed, the global level settled. No sample may follow.
  void finish();

  /// Why the survey is no longer joined; empty while it is. From then on its submaps follow each other by dead reckoning, landmarks() and
  /// trajectory() are empty and checkpoint() throws: the state before is in the last checkpoint.
  [[nodiscard]] const std::string& join_failure() const { return join_failure_; }

  /// Of the maps that are joined. After finish(): all.
  [[nodiscard]] std::vector<SurveyLandmark> landmarks();
  [[nodiscard]] std::vector<SurveyStep> trajectory();

  /// The whole state, whatever the background is doing: see restored(). Nothing that follows is changed by it.
  [[nodiscard]] std::string checkpoint();
  /// The same into a file, which appears as a whole or not at all. The state is taken now; a thread writes it. False, and nothing is done,
  /// while the file before is still being written. Throws FileError when that one could not be.
  [[nodiscard]] bool checkpoint(const std::string& path);
  /// Waits for that file. Throws FileError when it could not be written.
  void wait_for_checkpoint();

  /// The survey as it was at its checkpoint: fed with what came after it, it ends with the same bytes. Throws FileError, with `source` as
  /// its path, saying what is wrong with the bytes, or which setting differs.
  [[nodiscard]] static std::unique_ptr<OnlineSurvey> restored(const OnlineSurveyConfig& config, std::string_view bytes,
                                                              const std::string& source);
  [[nodiscard]] static std::unique_ptr<OnlineSurvey> restored_from(const OnlineSurveyConfig& config, const std::string& path);

 private:
  void archive_joiner(Archive& a, bool joining);
  void read(Archive& a);
  void step(const NavigationTick& tick);
  void close(TickResult& finished);
  void take_over();
  void count(const JoinReport& report);
  [[nodiscard]] JoinReport propose(const std::vector<TimedClosure>& claimed);
  void fail_to_join(const std::string& problem);
  void finish_once();
  [[nodiscard]] bool is_joined();  ///< when the background rests: whether all it did went well
  void tell(NoteKind kind, const std::string& text) const;
  void tell_of_arrival(Arrival arrival, const NavigationTick& sample);
  void tell_of_sensors();
  [[nodiscard]] SensorState state_of(NavigationSensor sensor) const;
  void rest();
  [[nodiscard]] bool started() const { return steps_ > 0; }
  OnlineSurveyConfig config_;
  ReorderWindow window_;
  LevelledBuilder builder_;
  PortJoiner joiner_;          ///< the background's while it has a job
  GaussianSe2 global_T_base_;  ///< of the map that is being built
  double take_over_s_ = 0.0;
  std::array<std::int64_t, 6> arrivals_{};
  SensorGuard guard_;
  SensorWatch watch_;
  SurveyLog log_;
  std::array<SensorState, kNavigationSensors> told_{};  ///< to the log
  int told_clock_changes_ = 0;
  Arrival told_arrival_ = Arrival::kTaken;
  bool fixes_contradict_ = false;  ///< the last one was refused
  std::string join_failure_;
  std::deque<TimedClosure> closures_;  ///< that wait for the submap of their later moment
  int loop_closures_ = 0;
  int closures_refused_ = 0;
  int compass_jumps_ = 0;
  int relocations_ = 0;
  int fixes_used_ = 0, fixes_refused_ = 0;
  int submaps_ = 0;
  int waits_ = 0;
  std::int64_t steps_ = 0;
  bool finished_ = false;
  /// What the background works on, and what came of it.
  struct Joining {
    LevelledSubmap submap;
    std::optional<UnsmoothedSteps> steps;
    JoinReport report;
    GaussianSe2 global_T_newest_base;

    /// Once the background is done.
    void archive(Archive& a) {
      a("report", report);
      a("global_T_newest_base", global_T_newest_base);
    }
  };
  Joining joining_;
  // Who reads the joiner's state waits for the join before it, a join for who reads.
  std::shared_future<void> is_joined_, is_read_;
  // last: their destructors wait before anything else goes
  BackgroundWorker background_;
  std::future<void> writing_;     ///< a checkpoint
  std::size_t bytes_before_ = 0;  ///< of the one before, without the joiner

 public:
  /// All but the joiner; waits_ is of this process.
  void archive(Archive& a) {
    a("window", window_);
    a("builder", builder_);
    a("global_T_base", global_T_base_);
    a("take_over_s", take_over_s_);
    a("arrivals", arrivals_);
    a("watch", watch_);
    a("guard", guard_);
    a("relocations", relocations_);
    a("fixes_used", fixes_used_);
    a("fixes_refused", fixes_refused_);
    a("fixes_contradict", fixes_contradict_);
    a("closures", closures_);
    a("loop_closures", loop_closures_);
    a("closures_refused", closures_refused_);
    a("compass_jumps", compass_jumps_);
    a("submaps", submaps_);
    a("steps", steps_);
    a("finished", finished_);
  }
};

}  // namespace ssjs
