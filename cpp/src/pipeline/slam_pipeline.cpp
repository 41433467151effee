#include "ssjs/pipeline/slam_pipeline.hpp"

#include <chrono>
#include <cmath>
#include <utility>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

const SlamConfig& valid(const SlamConfig& config) {
  throw_if_any(config.violations());
  return config;
}

SubmapBuilderConfig builder_config(const SlamConfig& config) {
  SubmapBuilderConfig submap = config.submap;
  if (config.method == Method::kEkf) {  // one endless map, whose answer is what it filtered at the time
    submap.split = {std::nullopt, std::nullopt, std::nullopt, std::nullopt, std::nullopt, 0};
    submap.condition_trajectory = false;
  }
  return submap;
}

}  // namespace

SlamPipeline::SlamPipeline(const SlamConfig& config, std::uint64_t seed)
    : config_(valid(config)),
      builder_(builder_config(config), config.association, seed),
      joiner_(std::make_unique<SelectiveJoiner>(config.joining, config.association.method, config.submap.split.max_landmarks, seed)) {}

StepReport SlamPipeline::feed(const Event& event) {
  check(event);
  const auto begin = Clock::now();
  StepReport report;
  advance(event.time_s);
  if (const auto* scan = std::get_if<LaserScan>(&event.record)) {
    observe(detect(*scan), report);
  } else if (const auto* features = std::get_if<Features>(&event.record)) {
    observe(usable(*features), report);
  } else {
    move(event);
  }
  builder_.record_step(event.time_s);
  report.time_s = event.time_s;
  report.submap = builder_.index();
  report.global_T_vehicle = global_T_vehicle();
  report.local_time_s = seconds_since(begin) - report.global_time_s - report.association_time_s;
  return report;
}

/// Algorithm 4: predict, associate, update, add features; Algorithm 3: a finished submap goes to the global level.
void SlamPipeline::observe(const Features& scan, StepReport& report) {
  report.scan = builder_.observe(*time_s_, scan);
  report.association_time_s = report.scan->association_time_s;
  if (report.scan->closed) {
    const auto begin = Clock::now();
    report.join = join(*std::exchange(report.scan->closed, std::nullopt));
    report.association_time_s += report.join->association_time_s;
    report.global_time_s = seconds_since(begin) - report.join->association_time_s;
  }
}

JoinReport SlamPipeline::join(Submap submap) {
  JoinReport report = joiner_->take(submap);
  global_T_base_ = joiner_->global_T_newest_base();
  submaps_.push_back(std::move(submap));
  return report;
}

GaussianSe2 SlamPipeline::global_T_vehicle() const {
  return finished_ ? global_T_base_ : compose_independent(global_T_base_, builder_.base_T_vehicle());
}

JoinReport SlamPipeline::finish() {
  if (finished_) throw InvalidArgument("finish", "second call", "a mission ends once");
  finished_ = true;
  if (!time_s_) return {};
  JoinReport report = join(builder_.finish("end of the mission"));
  joiner_->finish();
  global_T_base_ = joiner_->global_T_newest_base();
  return report;
}

}  // namespace ssjs
