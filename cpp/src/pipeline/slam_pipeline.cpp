#include "ssjs/pipeline/slam_pipeline.hpp"

#include <utility>

#include "ssjs/base/error.hpp"
#include "ssjs/pipeline/event_check.hpp"
#include "ssjs/pipeline/mapper_factory.hpp"
#include "ssjs/pipeline/scan_features.hpp"

namespace ssjs {
namespace {

const SlamConfig& valid(const SlamConfig& config) {
  throw_if_any(config.violations());
  return config;
}

}  // namespace

SlamPipeline::SlamPipeline(const SlamConfig& config, std::uint64_t seed)
    : config_(valid(config)), mapper_(make_mapper(config_, seed)), motion_(config_.vehicle), persistence_(config_.persistence) {}

StepReport SlamPipeline::feed(const Event& event) {
  if (finished_) throw InvalidArgument("event", event.time_s, "the mission is finished");
  check_event(event, time_s_, config_.vehicle);
  const std::optional<Features> scan =
      observed_features(event, config_.trees, config_.sonar_points, config_.sensor);  // nothing has changed yet if it refuses
  StepReport report;
  move(event);
  if (scan) observe(persistence_.confirmed(*scan, dead_reckoning_), report);
  mapper_->record_step(event.time_s);
  report.time_s = event.time_s;
  report.submap = mapper_->submap();
  report.global_T_vehicle = global_T_vehicle();
  return report;
}

/// The motion since the event before.
void SlamPipeline::move(const Event& event) {
  time_s_ = event.time_s;
  motion_.take(event);
  const std::optional<OdometryIncrement>& increment = motion_.increment();
  if (!increment) return;
  mapper_->predict(event.time_s, predict_increment(mapper_->base_T_vehicle(), *increment));
  dead_reckoning_ = dead_reckoning_ * increment->old_T_new.mean;
}

/// Algorithm 4: predict, associate, update, add features; Algorithm 3: a finished submap goes to the global level.
void SlamPipeline::observe(const Features& scan, StepReport& report) {
  MapperReport mapped = mapper_->observe(*time_s_, scan);
  report.association_time_s = mapped.scan.association_time_s;
  report.global_time_s = mapped.join_time_s;
  if (mapped.join) {
    report.association_time_s += mapped.join->association_time_s;
    report.global_time_s -= mapped.join->association_time_s;
  }
  report.scan = std::move(mapped.scan);
  report.join = std::move(mapped.join);
}

JoinReport SlamPipeline::finish() {
  if (finished_) throw InvalidArgument("finish", "second call", "a mission ends once");
  finished_ = true;
  if (!time_s_) return {};
  return mapper_->finish();
}

}  // namespace ssjs
