// The gate of a two-dimensional observation: a user of ssjs::base alone.
#include <cmath>
#include <cstdio>
#include <string>

#include "ssjs/base/chi_squared.hpp"
#include "ssjs/base/version.hpp"

int main() {
  const double gate = ssjs::chi_squared_quantile(0.99, 2.0);
  std::printf("ssjs %s: gate %.6f\n", std::string(ssjs::kVersion).c_str(), gate);
  return std::abs(gate + 2.0 * std::log(0.01)) < 1e-9 ? 0 : 1;  // two degrees: -2 log(1 - p)
}
