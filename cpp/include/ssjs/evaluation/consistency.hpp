/// Normalised errors and the bands they should lie in. docs/math/evaluation.md (E-8, E-9).
#pragma once

#include <Eigen/Core>
#include <vector>

namespace ssjs {

/// e' P^-1 e. Throws NotPositiveDefinite.
[[nodiscard]] double normalized_squared_error(const Eigen::Ref<const Eigen::VectorXd>& error,
                                              const Eigen::Ref<const Eigen::MatrixXd>& covariance);

struct Band {
  double lower = 0.0;
  double upper = 0.0;
};

/// Two-sided band of the MEAN of `samples` independent normalised errors of `dof` each: chi2 quantiles of samples*dof over samples.
[[nodiscard]] Band mean_band(double dof, int samples, double probability = 0.95);

struct ConsistencySummary {
  int samples = 0;
  double mean = 0.0;
  double mean_per_dof = 0.0;
  double inside_fraction = 0.0;  ///< inside the two-sided 95 % band of one sample
  double above_fraction = 0.0;   ///< above its upper bound
};

/// values[i] with dof[i]; both NIS and NEES. Empty input gives zero samples and zeros.
[[nodiscard]] ConsistencySummary summarize(const std::vector<double>& values, const std::vector<int>& dof);

}  // namespace ssjs
