#include "ssjs/base/chi_squared.hpp"

#include <cmath>
#include <limits>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kHalfLogTwoPi = 0.91893853320467274178;

/// log Gamma(a) - [(a - 1/2) log a - a + log(2 pi) / 2] for a >= kStirlingFrom. Abramowitz and Stegun 6.1.41; the first
/// omitted term is below 3e-16. std::lgamma writes a global variable and is not safe from several threads.
constexpr double kStirlingFrom = 15.0;
double stirling_correction(double a) {
  const double inverse_square = 1.0 / (a * a);
  return (1.0 / 12.0 -
          inverse_square * (1.0 / 360.0 - inverse_square * (1.0 / 1260.0 - inverse_square * (1.0 / 1680.0 - inverse_square / 1188.0)))) /
         a;
}

/// log Gamma(a), a > 0.
double log_gamma(double a) {
  double product = 1.0;  // Gamma(a) = Gamma(a + n) / (a (a + 1) ... (a + n - 1))
  for (; a < kStirlingFrom; a += 1.0) product *= a;
  return (a - 0.5) * std::log(a) - a + kHalfLogTwoPi + stirling_correction(a) - std::log(product);
}

/// log of x^a e^-x / Gamma(a + 1), x > 0.
double log_power_term(double a, double x) {
  if (a < kStirlingFrom) return a * std::log(x) - x - log_gamma(a + 1.0);
  const double excess = (x - a) / a;  // the large parts of a log x, x and log Gamma cancel here on paper, not in rounding
  const double deviance = excess > -0.5 ? excess - std::log1p(excess) : x / a - 1.0 - std::log(x / a);
  return -a * deviance - kHalfLogTwoPi - 0.5 * std::log(a) - stirling_correction(a);
}

/// Logarithms of the regularised incomplete gamma functions P(a, x) and Q(a, x) = 1 - P(a, x), x > 0.
struct LogTails {
  double lower;
  double upper;
};

LogTails log_tails(double a, double x) {
  if (x < a + 1.0) {  // Abramowitz and Stegun 6.5.29: P = x^a e^-x / Gamma(a + 1) * sum x^n / ((a + 1) ... (a + n))
    double term = 1.0;
    double sum = 1.0;
    for (double n = 1.0; term > kEpsilon * sum; n += 1.0) {
      term *= x / (a + n);
      sum += term;
    }
    const double lower = log_power_term(a, x) + std::log(sum);
    return {lower, std::log(-std::expm1(lower))};
  }
  // Abramowitz and Stegun 6.5.31 contracted to its even part, evaluated by the modified Lentz method.
  double b = x + 1.0 - a;
  double d = 1.0 / b;
  double c = std::numeric_limits<double>::max();
  double fraction = d;
  for (double n = 1.0; true; n += 1.0) {
    const double numerator = -n * (n - a);
    b += 2.0;
    d = 1.0 / (numerator * d + b);
    c = b + numerator / c;
    const double factor = c * d;
    fraction *= factor;
    if (std::abs(factor - 1.0) <= 2.0 * kEpsilon) break;
  }
  const double upper = log_power_term(a, x) + std::log(a) + std::log(fraction);
  return {std::log(-std::expm1(upper)), upper};
}

void require_degrees_of_freedom(double dof) {
  if (!(dof > 0.0) || !std::isfinite(dof)) throw InvalidArgument("chi-squared dof", dof, "must be positive and finite");
}

/// A starting point for the quantile, right to a few percent: Wilson and Hilferty (1931) with the normal quantile of
/// Abramowitz and Stegun 26.2.23, or the first term of the series where the cube fails (far lower tail, few degrees).
double quantile_start(double probability, double dof) {
  const double tail = probability < 0.5 ? probability : 1.0 - probability;
  const double t = std::sqrt(-2.0 * std::log(tail));
  const double z = t - (2.515517 + t * (0.802853 + t * 0.010328)) / (1.0 + t * (1.432788 + t * (0.189269 + t * 0.001308)));
  const double root = 1.0 - 2.0 / (9.0 * dof) + (probability < 0.5 ? -z : z) * std::sqrt(2.0 / (9.0 * dof));
  if (root > 0.2) return dof * root * root * root;
  const double a = 0.5 * dof;
  return 2.0 * std::exp((std::log(probability) + log_gamma(a + 1.0)) / a);
}

}  // namespace

double chi_squared_cdf(double x, double dof) {
  require_degrees_of_freedom(dof);
  if (std::isnan(x)) throw InvalidArgument("chi_squared_cdf x", x, "must be a number");
  if (x <= 0.0) return 0.0;
  if (std::isinf(x)) return 1.0;
  return std::exp(log_tails(0.5 * dof, 0.5 * x).lower);
}

double chi_squared_quantile(double probability, double dof) {
  require_degrees_of_freedom(dof);
  if (!(probability > 0.0 && probability < 1.0))
    throw InvalidArgument("chi_squared_quantile probability", probability, "must lie in (0, 1)");

  // Newton on the logarithm of the smaller tail as a function of u = log x, where both tails are concave. Steps that leave
  // the bracket known so far are replaced by its middle. Taking the smaller tail keeps 1 - probability exact.
  const bool in_lower_tail = probability < 0.5;
  const double a = 0.5 * dof;
  const double log_target = std::log(in_lower_tail ? probability : 1.0 - probability);
  double u = std::log(quantile_start(probability, dof));
  double u_low = -std::numeric_limits<double>::infinity();
  double u_high = std::numeric_limits<double>::infinity();
  constexpr int kMaximumSteps = 200;
  for (int step = 0; step < kMaximumSteps; ++step) {
    const double half_x = 0.5 * std::exp(u);
    if (half_x == 0.0) return 0.0;  // the quantile lies below the smallest number
    const LogTails tails = log_tails(a, half_x);
    const double log_tail = in_lower_tail ? tails.lower : tails.upper;
    const double residual = log_tail - log_target;
    const bool too_high = in_lower_tail ? residual > 0.0 : residual < 0.0;
    (too_high ? u_high : u_low) = u;
    // d log P / du = x f(x) / P(x), d log Q / du = -x f(x) / Q(x), with x f(x) = a * power term
    const double slope = (in_lower_tail ? 1.0 : -1.0) * a * std::exp(log_power_term(a, half_x) - log_tail);
    double u_next = u - residual / slope;
    if (!(u_next > u_low && u_next < u_high) && std::isfinite(u_low) && std::isfinite(u_high)) u_next = 0.5 * (u_low + u_high);
    if (std::abs(u_next - u) <= 4.0 * kEpsilon * (1.0 + std::abs(u))) return std::exp(u_next);
    u = u_next;
  }
  throw Error("chi_squared_quantile did not converge; please report the arguments to the authors");
}

}  // namespace ssjs
