/// The chi-squared distribution: gates, consistency bands.
#pragma once

namespace ssjs {

/// P(X <= x) for X ~ chi-squared with `dof` > 0 degrees of freedom. x < 0 gives 0.
[[nodiscard]] double chi_squared_cdf(double x, double dof);

/// The x with P(X <= x) = probability, 0 < probability < 1, dof > 0; relative accuracy 1e-10. Throws InvalidArgument.
[[nodiscard]] double chi_squared_quantile(double probability, double dof);

}  // namespace ssjs
