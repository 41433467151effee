#include "ssjs/joining/submap_mapper.hpp"

#include <chrono>
#include <utility>

namespace ssjs {

SubmapMapper::SubmapMapper(const SubmapBuilderConfig& config, const ScanAssociationConfig& association, std::uint64_t seed,
                           std::unique_ptr<MapJoiner> joiner)
    : builder_(config, association, seed), joiner_(std::move(joiner)) {}

MapperReport SubmapMapper::observe(double time_s, const Features& scan) {
  MapperReport report{builder_.observe(time_s, scan), {}, 0.0};
  if (report.scan.closed) {
    const auto begin = std::chrono::steady_clock::now();
    report.join = join(*std::exchange(report.scan.closed, std::nullopt));
    report.join_time_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }
  return report;
}

JoinReport SubmapMapper::join(Submap submap) {
  JoinReport report = joiner_->take(submap);
  global_T_base_ = joiner_->global_T_newest_base();
  submaps_.push_back(std::move(submap));
  return report;
}

GaussianSe2 SubmapMapper::global_T_vehicle() const {
  return finished_ ? global_T_base_ : compose_independent(global_T_base_, builder_.base_T_vehicle());
}

JoinReport SubmapMapper::finish() {
  JoinReport report = join(builder_.finish("end of the mission"));
  report.append(joiner_->finish());
  global_T_base_ = joiner_->global_T_newest_base();
  finished_ = true;
  return report;
}

}  // namespace ssjs
