/// Randomised joint compatibility (RJC) for large maps. [paz2007], thesis 4.2.2, docs/math/association.md.
#pragma once

#include "ssjs/association/hypothesis.hpp"
#include "ssjs/association/joint_compatibility.hpp"
#include "ssjs/base/random.hpp"

namespace ssjs {

struct RandomizedJointCompatibilityConfig {
  JointCompatibilityConfig joint;
  int sample_size = 4;                ///< b, observations of one random sample
  double failure_probability = 0.01;  ///< of missing the answer, with the inlier fraction below
  double inlier_fraction = 0.5;       ///< w: T = log(failure) / log(1 - w^b) samples
};

/// Random samples of b observations are paired by JCBB; the joint covariance is conditioned on those pairs (an update of
/// the relative pose), the other observations are paired by nearest neighbour with the shrunk covariance while the joint
/// gate holds. The best sample wins (most pairs, then smallest joint distance). Once a sample pairs more than the assumed
/// inlier fraction, T is computed from what it paired and the loop ends sooner.
/// Only observations with candidates are sampled; with sample_size or fewer of them this is plain JCBB.
[[nodiscard]] Hypothesis randomized_joint_compatibility(const PairingProblem& problem, const RandomizedJointCompatibilityConfig& config,
                                                        Rng& rng);

}  // namespace ssjs
