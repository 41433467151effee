#include "ssjs/pipeline/levelled_pipeline.hpp"

#include <chrono>
#include <utility>

#include "ssjs/base/error.hpp"
#include "ssjs/pipeline/survey_factory.hpp"
#include "ssjs/pipeline/vehicle_in_world.hpp"

namespace ssjs {
namespace {

using Clock = std::chrono::steady_clock;

}  // namespace

std::vector<std::string> LevelledConfig::violations() const {
  std::vector<std::string> found = ssjs::violations(*this);
  const CompassUse use = local.compass_use;
  const bool is_naive = method == LevelledMethod::kNaiveHeading;
  if (joining.north_offset_rad && (is_naive || use == CompassUse::kFirstReading || use == CompassUse::kNone)) {
    const std::string setting = is_naive ? "method = ssjs-naive-heading" : "compass_use = first_reading or none";
    const std::string mend = is_naive ? "another method" : "compass_use = filter or mean";
    found.push_back("joining.north_offset_rad: with " + setting +
                    " the maps hold no compass that could tell where north is: leave it out (none), or set " + mend);
  }
  return found;
}

LevelledPipeline::LevelledPipeline(const LevelledConfig& config, std::uint64_t seed)
    : guard_(config.guard),
      builder_(local_config(config)),
      joiner_(make_survey_joiner(config, seed)),
      dead_reckoning_(config.local.velocity_log, config.joining.north_offset_rad),
      joining_(config.joining) {}

SensorStatistics LevelledPipeline::statistics(NavigationSensor sensor) const {
  SensorStatistics statistics = builder_.statistics(sensor);
  statistics.refused += static_cast<int>(guard_.refused(sensor));
  return statistics;
}

LevelledReport LevelledPipeline::feed(const NavigationTick& arrived) {
  if (finished_) throw InvalidArgument("tick", arrived.time_s, "the mission is finished");
  const NavigationTick& tick = guard_.pass(arrived);
  if (guard_.astray_rad()) builder_.doubt_attitude(*guard_.astray_rad());
  LevelledReport report;
  TickResult local = builder_.feed(tick);
  dead_reckoning_.feed(tick);
  if (local.closed) {
    const auto begin = Clock::now();
    report.join = joiner_->take(std::move(*local.closed));
    global_T_base_ = joiner_->global_T_newest_base();
    report.association_time_s = report.join->association_time_s;
    report.global_time_s = std::chrono::duration<double>(Clock::now() - begin).count() - report.association_time_s;
  }
  if (builder_.index() == 0 && builder_.offset_known() && joining_.north_offset_rad) {
    global_T_base_ = base_facing_north(builder_.filter(), *joining_.north_offset_rad, joining_.north_offset_sigma_rad);
  }
  if (builder_.index() == 0 && builder_.start_fix()) {
    global_T_base_ = base_at_fix(global_T_base_, builder_.start_fix()->fix, joining_.fixes.start_heading_sigma_rad);
  }
  report.submap = builder_.index();
  report.remembered = local.remembered;
  report.update = local.update;
  report.refused = local.refused;
  report.observations = static_cast<int>(tick.sightings.size() + (tick.frame ? tick.frame->sightings.size() : 0));
  report.frame = std::move(local.frame);
  report.wrong_pairs = local.wrong_pairs;
  report.vehicle = global_T_vehicle();
  return report;
}

SurveyStep LevelledPipeline::global_T_vehicle() const {
  const LevelledFilter& filter = builder_.filter();
  return vehicle_in_world(global_T_base_, filter.vehicle(), filter.vehicle_covariance().topLeftCorner<6, 6>(), builder_.time_s());
}

JoinReport LevelledPipeline::finish() {
  if (finished_) throw InvalidArgument("finish", "second call", "a mission ends once");
  finished_ = true;
  JoinReport report;
  if (std::optional<LevelledSubmap> last = builder_.finish("end")) report = joiner_->take(std::move(*last));
  report.append(joiner_->finish());
  return report;
}

}  // namespace ssjs
