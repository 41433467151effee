/// Builds one levelled map of an underwater vehicle after the other from asynchronous navigation samples and side-scan sightings.
/// docs/math/auv.md (A-15..A-19).
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ssjs/base/archive.hpp"
#include "ssjs/features/navigation_tick.hpp"
#include "ssjs/filter/levelled_filter.hpp"
#include "ssjs/mapping/base_fix.hpp"
#include "ssjs/mapping/frame_association.hpp"
#include "ssjs/mapping/levelled_config.hpp"
#include "ssjs/mapping/levelled_journal.hpp"
#include "ssjs/mapping/levelled_submap.hpp"
#include "ssjs/mapping/sighting_association.hpp"

namespace ssjs {

/// In gyro_step_s: a gyro that is silent for longer says nothing of the turn.
inline constexpr double kGyroHolds = 20.0;

enum class NavigationSensor { kAttitude, kCompass, kDepth, kAltitude, kVelocityLog, kSideScan, kFix, kGyro, kCamera };
inline constexpr std::size_t kNavigationSensors = 9;

/// Of one sensor over the mission. The normalised innovations of the used samples, each against the prediction of the filter. A gyro has
/// none: its rates are inputs. Fixes are judged by who joins the maps.
struct SensorStatistics {
  int used = 0;
  int refused = 0;  ///< outside the gate; a velocity log without bottom lock is neither
  double nis_sum = 0.0;
  int dof = 0;

  void archive(Archive& a) {
    a("used", used);
    a("refused", refused);
    a("nis_sum", nis_sum);
    a("dof", dof);
  }
};

struct TickResult {
  UpdateResult update;                   ///< of all rows of the tick together; no rows: 0 of 0
  int refused = 0;                       ///< samples outside their gates
  int paired = 0, added = 0;             ///< sightings, the camera's among them
  int wrong_pairs = 0;                   ///< pairs whose source identities differ, where both are known
  std::vector<FrameSighting> frame;      ///< of the landmarks that a camera frame showed
  bool remembered = false;               ///< the pose of this tick is a step of its map
  std::optional<LevelledSubmap> closed;  ///< the map that this tick finished; its samples are the new one's
  std::optional<UnsmoothedSteps> steps;  ///< of the closed map, where the builder does not smooth them itself
};

/// Who smooths the steps of a finished map, which takes as long as some hundred ticks.
enum class StepSmoothing {
  kAtClosing,  ///< the tick that closes a map
  kByCaller,   ///< whoever gets TickResult::steps, when there is time
};

class LevelledBuilder {
 public:
  /// Throws InvalidArgument listing every violation of the configuration.
  explicit LevelledBuilder(const LevelledBuilderConfig& config, StepSmoothing smoothing = StepSmoothing::kAtClosing);
  LevelledBuilder(const LevelledBuilder&) = delete;  // the filter reports to the journal beside it
  LevelledBuilder& operator=(const LevelledBuilder&) = delete;
  ~LevelledBuilder() = default;

  /// The first tick starts the first map. Throws InvalidArgument for a time before the last one or a sample that is not finite. Takes
  /// memory from the heap where a map ends or gains a landmark, where a map is longer than all before it, where a ping shows several
  /// points without identities, and for a camera's frame; nowhere else.
  TickResult feed(const NavigationTick& tick);

  /// The attitude may be wrong by these standard deviations (roll, pitch, yaw; rad) that the filter knows nothing of, and was for some
  /// seconds: attitude and compass are met anew. Nothing before the first tick. docs/faults.md
  void doubt_attitude(const Eigen::Vector3d& sigma_rad);

  /// Finishes the present map as it is, at the end of a mission. Nothing before the first tick.
  [[nodiscard]] std::optional<LevelledSubmap> finish(const std::string& reason);

  /// The record of a map whose steps were smoothed: its memory serves a later map.
  void reuse(LevelledRecord record) { blank_ = std::move(record); }

  [[nodiscard]] int index() const { return index_; }
  [[nodiscard]] const LevelledFilter& filter() const { return filter_; }
  [[nodiscard]] const std::vector<MapLandmark>& landmarks() const { return landmarks_; }  ///< in the order of the filter's
  [[nodiscard]] double time_s() const { return time_s_; }
  [[nodiscard]] double map_start_s() const { return start_time_s_; }
  [[nodiscard]] const std::optional<BaseFix>& start_fix() const { return start_fix_; }            ///< that base 0 came with
  [[nodiscard]] bool offset_known() const { return offset_known_; }                               ///< the compass has spoken in this map
  [[nodiscard]] const std::optional<Eigen::Vector3d>& gyro_rad_s() const { return gyro_rad_s_; }  ///< the last sample
  [[nodiscard]] const SensorStatistics& statistics(NavigationSensor sensor) const { return statistics_[static_cast<std::size_t>(sensor)]; }

 private:
  /// The samples of one tick as rows, each through its gate.
  struct GatedRows {
    std::vector<StateRows> rows;
    std::vector<NavigationSensor> sensors;  ///< of each block of rows
    std::vector<double> distances;          ///< normalised innovation squared of each block
    std::vector<NavigationSensor> refused;
    bool velocity_valid = false;
  };

  void begin_map(const NavigationTick& tick, TickResult& result);
  void start(const NavigationTick& tick);
  void count_refused(const std::vector<NavigationSensor>& refused, TickResult& result);
  void predict_to(double time_s);
  void add_doubt(double gap_s);
  void forget_until(double time_s);
  void level_again();
  void gate_rows(const NavigationTick& tick, bool gates);  ///< into gated_
  void associate(const NavigationTick& tick);              ///< into association_ and frame_
  void gate_frame(const CameraFrame& frame, TickResult& result);
  void add_rays(const CameraFrame& frame, TickResult& result);
  void settle_rays();
  void settle_map();
  void drop_landmark(Eigen::Index landmark);
  [[nodiscard]] bool knows_seabed() const;
  [[nodiscard]] bool is_point(Eigen::Index ray) const;
  void introduce_offset(double compass_rad, double sigma_rad);
  void add_to_mean(double time_s, double compass_rad);
  void use(const NavigationTick& tick, TickResult& result);
  [[nodiscard]] SplitPolicyConfig split_policy() const;
  [[nodiscard]] std::optional<std::string> reason_to_close_map(int new_landmarks) const;
  [[nodiscard]] LevelledSubmap close(const std::string& reason, std::optional<UnsmoothedSteps>* steps);

  LevelledBuilderConfig config_;
  LevelledFilter filter_;
  LevelledJournal journal_;
  FixKeeper fixes_;
  std::optional<BaseFix> start_fix_;  ///< of base 0
  std::optional<PinholeCamera> camera_;
  std::vector<MapLandmark> landmarks_;
  std::vector<int> missed_;  ///< frames in a row that did not show a camera's landmark
  std::int64_t tracks_ = 0;  ///< of the camera, over all maps
  struct Seen {
    Eigen::Index landmark;
    double time_s;

    void archive(Archive& a) {
      a("landmark", landmark);
      a("time_s", time_s);
    }
  };
  std::vector<Seen> seen_;  ///< in the order of time
  StepSmoothing smoothing_;
  std::optional<LevelledRecord> blank_;  ///< for the next map
  GatedRows gated_;                      ///< of the tick at hand
  SightingAssociation association_;      ///< of the tick at hand
  std::optional<FrameAssociation> frame_;
  std::array<SensorStatistics, kNavigationSensors> statistics_{};
  std::optional<Eigen::Vector3d> gyro_rad_s_;  ///< the last sample, which holds for a while
  double gyro_time_s_ = 0.0;
  std::optional<double> attitude_time_s_;
  double compass_time_s_ = -std::numeric_limits<double>::infinity();
  std::array<bool, kNavigationSensors> met_{};  ///< heard in this map
  int index_ = 0;
  bool started_ = false;
  double start_time_s_ = 0.0, time_s_ = 0.0;
  double last_step_s_ = 0.0;
  double usual_gap_s_ = 0.0;  ///< between two ticks, lately
  bool was_silent_ = false;   ///< the map ends as soon as another can begin (A-26)
  double distance_m_ = 0.0;
  double shortened_m_ = 0.0;  ///< of it that an uncertain heading may have taken (A-25)
  bool offset_known_ = false;
  // compass kept out of the filter
  int mean_samples_ = 0;
  double mean_reference_rad_ = 0.0, mean_sum_rad_ = 0.0, mean_first_s_ = 0.0, mean_last_s_ = 0.0;

 public:
  void archive(Archive& a) {
    a("filter", filter_);
    a("journal", journal_);
    a("fixes", fixes_);
    a("start_fix", start_fix_);
    a("landmarks", landmarks_);
    a("missed", missed_);
    a("tracks", tracks_);
    a("seen", seen_);
    a("statistics", statistics_);
    a("gyro_rad_s", gyro_rad_s_);
    a("gyro_time_s", gyro_time_s_);
    a("attitude_time_s", attitude_time_s_);
    a.unbounded("compass_time_s", compass_time_s_);
    a("met", met_);
    a("index", index_);
    a("started", started_);
    a("start_time_s", start_time_s_);
    a("time_s", time_s_);
    a("last_step_s", last_step_s_);
    a("usual_gap_s", usual_gap_s_);
    a("was_silent", was_silent_);
    a("distance_m", distance_m_);
    a("shortened_m", shortened_m_);
    a("offset_known", offset_known_);
    a("mean_samples", mean_samples_);
    a("mean_reference_rad", mean_reference_rad_);
    a("mean_sum_rad", mean_sum_rad_);
    a("mean_first_s", mean_first_s_);
    a("mean_last_s", mean_last_s_);
    a.require(!started_ || filter_.landmarks() == static_cast<Eigen::Index>(landmarks_.size()),
              "has another number of landmarks in its filter than beside it");
    a.require(missed_.size() == landmarks_.size(), "has another number of misses than of landmarks");
    a.require(!started_ || journal_.fits(filter_), "remembers what its filter cannot have done");
    for (const Seen& seen : seen_) {
      a.require(seen.landmark >= 0 && seen.landmark < static_cast<Eigen::Index>(landmarks_.size()), "saw a landmark that is not there");
    }
  }
};

}  // namespace ssjs
