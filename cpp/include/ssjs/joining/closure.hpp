/// A loop closure between two levelled maps of a survey, and how it fits to the way between them. docs/math/closures.md (C-3..C-6).
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ssjs/geometry/gaussian.hpp"
#include "ssjs/joining/levelled_chain.hpp"
#include "ssjs/joining/port_map.hpp"

namespace ssjs {

/// "Base `to` stands so to base `from`", or "these landmarks of map `from` are those of map `to`"; from < to. One of the two.
struct Closure {
  int from = 0;
  int to = 0;
  std::optional<GaussianSe2> from_T_to{};                      ///< error independent of the maps; m, rad
  std::vector<std::pair<Eigen::Index, Eigen::Index>> pairs{};  ///< landmarks of map `from`, of map `to`
  std::string source{};                                        ///< who says so, for the report

  void archive(Archive& a) {
    a("from", from);
    a("to", to);
    a("from_T_to", from_T_to);
    a("pairs", pairs);
    a("source", source);
  }
};

/// Squared distance of closures from the way without any closure, and their degrees of freedom: 3 of a pose, 2 a pair of landmarks.
struct ClosureFit {
  double chi_squared = 0.0;
  int dof = 0;
  double off_m = 0.0;  ///< by how many metres the way misses it

  void archive(Archive& a) {
    a("chi_squared", chi_squared);
    a("dof", dof);
    a("off_m", off_m);
  }
};

/// Two closures and the way between their ends: each alone, both together, and by how many metres the second misses once the first is
/// believed. Given the first, the second has both - first with its own degrees of freedom (C-6).
struct CycleFit {
  ClosureFit first, second;
  double both = 0.0;
  double off_m = 0.0;

  [[nodiscard]] double second_given_first() const { return both - first.chi_squared; }
  [[nodiscard]] double first_given_second() const { return both - second.chi_squared; }
};

/// Whether the ways that the two span have a part in common; where they have none neither says anything about the other.
[[nodiscard]] bool share_way(const Closure& a, const Closure& b);

[[nodiscard]] ClosureFit fit(const Closure& closure, const LevelledChain& chain, const std::deque<PortMap>& maps);
[[nodiscard]] CycleFit fit_cycle(const Closure& first, const Closure& second, const LevelledChain& chain, const std::deque<PortMap>& maps);

}  // namespace ssjs
