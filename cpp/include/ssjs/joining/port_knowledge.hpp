/// What is known of the unknowns of a survey. docs/math/ports.md (P-4), underwater_methods.md (U-4).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "ssjs/joining/port_map.hpp"

namespace ssjs {

/// Enough to place a map's steps and landmarks in the world, whoever estimated it.
class PortKnowledge {
 public:
  PortKnowledge() = default;
  PortKnowledge(const PortKnowledge&) = delete;
  PortKnowledge& operator=(const PortKnowledge&) = delete;
  virtual ~PortKnowledge() = default;

  [[nodiscard]] virtual const PortValues& values() const = 0;
  /// Joint covariance, rows_of(kind) rows an unknown (additive coordinates); zero where an unknown is held fixed.
  [[nodiscard]] virtual Eigen::MatrixXd covariance(const std::vector<Unknown>& unknowns) const = 0;
};

}  // namespace ssjs
