/// Position fixes at the global level of a survey: which are believed, and what follows when the estimate is not. docs/math/ports.md
/// (P-30..P-33).
#pragma once

#include <Eigen/Core>
#include <deque>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/joining/map_joiner.hpp"
#include "ssjs/joining/port_level.hpp"
#include "ssjs/mapping/base_fix.hpp"

namespace ssjs {

struct FixConfig {
  double gate_probability = 0.999;
  int relocate_after = 3;
  double start_heading_sigma_rad = 0.1;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("gate_probability", gate_probability, Rule::open(0, 1), "a fix less likely than this, given all else, is refused");
    v.field("relocate_after", relocate_after, Rule::at_least(2),
            "so many refused fixes in a row that agree with each other are believed: the estimate was wrong");
    v.field(
        "start_heading_sigma_rad", start_heading_sigma_rad, Rule{0, 0.7, false, true},
        "the frame of the fixes has its x axis ahead at the start, give or take this; of no account where the world is aligned to north");
  }
};

class PortFixes {
 public:
  explicit PortFixes(const FixConfig& config) : config_(config) {}

  /// The fix of a base that the level knows; the level is settled before, and afterwards where the fix was used. Where the estimate is
  /// found wrong, the map that ends at the first of the refused fixes is loosened (P-33).
  FixAttempt take(const BaseFix& fix, int base, PortLevel& level, std::deque<PortMap>& maps);

  /// All that were used, into a level that is made anew and knows their bases.
  void put_into(PortLevel& level) const;

 private:
  void use(const FixFactor& fix, PortLevel& level);
  [[nodiscard]] bool agrees_with_suspects(const FixFactor& fix, const PortLevel& level) const;
  void relocate(PortLevel& level, std::deque<PortMap>& maps);

  FixConfig config_;
  std::vector<FixFactor> used_;      ///< with the first one the world is that of the fixes
  std::vector<FixFactor> suspects_;  ///< refused, the last ones in a row, in agreement with each other

 public:
  void archive(Archive& a) {
    a("used", used_);
    a("suspects", suspects_);
  }
};

/// The exit of the map may lie `variance` (m^2) farther off, in either direction, than the map says: its covariance, and its steps, which
/// follow what is left of the exit's correction. (P-33)
void loosen_exit(LevelledSubmap& submap, double variance);

/// The least variance v >= 0 with which r'(S + v I)^-1 r is no more than its mean, 2. (P-33)
[[nodiscard]] double missing_variance(const Eigen::Vector2d& residual, const Eigen::Matrix2d& S);

}  // namespace ssjs
