#include "ssjs/base/config_field.hpp"

#include <cmath>
#include <sstream>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

std::string number(double value) {
  std::ostringstream out;
  out.precision(12);
  out << value;
  return out.str();
}

}  // namespace

std::string Rule::text() const {
  const bool has_low = std::isfinite(low);
  const bool has_high = std::isfinite(high);
  if (has_low && has_high) {
    return "must lie in " + std::string(low_open ? "(" : "[") + number(low) + ", " + number(high) + (high_open ? ")" : "]");
  }
  if (has_low && low == 0.0) return low_open ? "must be positive and finite" : "must be zero or positive, and finite";
  if (has_low) return std::string(low_open ? "must be above " : "must be at least ") + number(low);
  if (has_high) return std::string(high_open ? "must be below " : "must be at most ") + number(high);
  return "must be a number";
}

void Validator::check(std::string_view key, double value, const Rule& rule) {
  if (!rule.holds(value)) violations_.push_back(full_key(key) + " = " + number(value) + ": " + rule.text());
}

void Validator::field(std::string_view key, double& value, const Rule& rule, std::string_view) { check(key, value, rule); }
void Validator::field(std::string_view key, int& value, const Rule& rule, std::string_view) { check(key, value, rule); }
void Validator::field(std::string_view key, std::optional<double>& value, const Rule& rule, std::string_view) {
  if (value) check(key, *value, rule);
}
void Validator::field(std::string_view key, std::optional<int>& value, const Rule& rule, std::string_view) {
  if (value) check(key, *value, rule);
}

void throw_if_any(const std::vector<std::string>& violations) {
  if (violations.empty()) return;
  std::string all;
  for (const std::string& violation : violations) all += (all.empty() ? "" : "; ") + violation;
  throw InvalidArgument("configuration", std::to_string(violations.size()) + " violation(s)", all);
}

}  // namespace ssjs
