/// Independent submaps, and a joining method that places them. Thesis Algorithms 3 and 4; docs/math/submaps.md.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "ssjs/joining/mapper.hpp"

namespace ssjs {

class SubmapMapper final : public Mapper {
 public:
  SubmapMapper(const SubmapBuilderConfig& config, const ScanAssociationConfig& association, std::uint64_t seed,
               std::unique_ptr<MapJoiner> joiner);

  [[nodiscard]] const Se2& base_T_vehicle() const override { return builder_.filter().vehicle_pose(); }
  void predict(double time_s, const MotionPrediction& motion) override { builder_.predict(time_s, motion); }
  [[nodiscard]] MapperReport observe(double time_s, const Features& scan) override;
  void record_step(double time_s) override { builder_.record_step(time_s); }
  [[nodiscard]] GaussianSe2 global_T_vehicle() const override;
  [[nodiscard]] int submap() const override { return builder_.index(); }
  [[nodiscard]] JoinReport finish() override;
  [[nodiscard]] const std::vector<Submap>& submaps() const override { return submaps_; }
  [[nodiscard]] WorldEstimate world(BaseCovariance covariance) const override { return joiner_->estimate(covariance); }

 private:
  JoinReport join(Submap submap);

  SubmapBuilder builder_;
  std::unique_ptr<MapJoiner> joiner_;
  std::vector<Submap> submaps_;
  GaussianSe2 global_T_base_;
  bool finished_ = false;
};

}  // namespace ssjs
