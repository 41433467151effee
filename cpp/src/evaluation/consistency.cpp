#include "ssjs/evaluation/consistency.hpp"

#include <cmath>
#include <map>
#include <string>

#include "ssjs/base/chi_squared.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/geometry/gaussian.hpp"

namespace ssjs {

double normalized_squared_error(const Eigen::Ref<const Eigen::VectorXd>& error, const Eigen::Ref<const Eigen::MatrixXd>& covariance) {
  const Eigen::Index n = error.size();
  if (covariance.rows() != n || covariance.cols() != n) {
    throw InvalidArgument("normalized_squared_error covariance",
                          std::to_string(covariance.rows()) + " x " + std::to_string(covariance.cols()),
                          "must be " + std::to_string(n) + " x " + std::to_string(n) + ", as the error");
  }
  if (n == 0) return 0.0;
  const std::string size = std::to_string(n) + " x " + std::to_string(n);
  const Eigen::MatrixXd L = cholesky_lower(covariance, "covariance of a normalised error", size.c_str());
  return L.triangularView<Eigen::Lower>().solve(error).squaredNorm();  // (E-8)
}

Band mean_band(double dof, int samples, double probability) {
  if (!(dof > 0.0) || !std::isfinite(dof)) throw InvalidArgument("mean_band dof", dof, "must be positive and finite");
  if (samples < 1) throw InvalidArgument("mean_band samples", samples, "must be at least 1");
  if (!(probability > 0.0 && probability < 1.0)) throw InvalidArgument("mean_band probability", probability, "must lie in (0, 1)");
  const double tail = 0.5 * (1.0 - probability);
  return {chi_squared_quantile(tail, dof * samples) / samples, chi_squared_quantile(1.0 - tail, dof * samples) / samples};  // (E-9)
}

ConsistencySummary summarize(const std::vector<double>& values, const std::vector<int>& dof) {
  if (values.size() != dof.size()) {
    throw InvalidArgument("summarize dof", std::to_string(dof.size()) + " entries",
                          "must have one per value (" + std::to_string(values.size()) + ")");
  }
  ConsistencySummary summary;
  if (values.empty()) return summary;
  std::map<int, Band> band_of_dof;
  double sum = 0.0;
  double dof_sum = 0.0;
  int inside = 0;
  int above = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (dof[i] < 1) throw InvalidArgument("summarize dof[" + std::to_string(i) + "]", dof[i], "must be at least 1");
    if (!std::isfinite(values[i])) throw InvalidArgument("summarize values[" + std::to_string(i) + "]", values[i], "must be finite");
    const auto known = band_of_dof.find(dof[i]);
    const Band band = known != band_of_dof.end() ? known->second : band_of_dof.emplace(dof[i], mean_band(dof[i], 1)).first->second;
    sum += values[i];
    dof_sum += dof[i];
    if (values[i] > band.upper) ++above;
    if (values[i] >= band.lower && values[i] <= band.upper) ++inside;
  }
  const double count = static_cast<double>(values.size());
  summary.samples = static_cast<int>(values.size());
  summary.mean = sum / count;
  summary.mean_per_dof = sum / dof_sum;
  summary.inside_fraction = inside / count;
  summary.above_fraction = above / count;
  return summary;
}

}  // namespace ssjs
