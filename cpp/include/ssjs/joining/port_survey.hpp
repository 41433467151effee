/// The survey as ports: submaps tied by bases, compass offsets and shared landmarks; or one map alone. docs/math/ports.md.
#pragma once

#include "ssjs/joining/port_joiner.hpp"
#include "ssjs/joining/survey_joiner.hpp"

namespace ssjs {

class PortSurvey final : public SurveyJoiner {
 public:
  explicit PortSurvey(const PortJoinerConfig& config) : joiner_(config) {}

  JoinReport take(LevelledSubmap submap) override { return joiner_.take(std::move(submap)); }
  JoinReport finish() override;
  [[nodiscard]] GaussianSe2 global_T_newest_base() const override { return joiner_.global_T_newest_base(); }
  [[nodiscard]] const std::deque<PortMap>& maps() const override { return joiner_.maps(); }
  [[nodiscard]] SurveyEstimate estimate(std::size_t max_joint_bases) const override;
  [[nodiscard]] int compass_jumps() const override { return joiner_.compass_jumps(); }
  [[nodiscard]] int merged() const override { return joiner_.merged(); }

 private:
  PortJoiner joiner_;
};

}  // namespace ssjs
