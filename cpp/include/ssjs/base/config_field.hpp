/// How a stage's configuration describes itself. Every configuration is a plain struct whose defaults are its member
/// initialisers, with one member template that names each field once:
///
///   struct GateConfig {
///     double gate_probability = 0.99;
///     template <class Visitor> void visit(Visitor& visitor) {
///       visitor.field("gate_probability", gate_probability, Rule::open(0, 1), "individual gate of a pairing");
///     }
///   };
///
/// Validation, the Python configuration models, the JSON schema and the documentation all walk the same description,
/// so a default or a rule is written in one place. Keys carry their unit (gate_heading_rad, max_range_m).
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace ssjs {

/// The interval a number has to lie in. NaN satisfies no rule; infinity only `any`-ended ones that admit it.
struct Rule {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_open = false;
  bool high_open = false;

  static Rule any() { return {}; }
  static Rule positive() { return {0.0, std::numeric_limits<double>::infinity(), true, true}; }
  static Rule not_negative() { return {0.0, std::numeric_limits<double>::infinity(), false, true}; }
  static Rule at_least(double low) { return {low, std::numeric_limits<double>::infinity(), false, true}; }
  static Rule closed(double low, double high) { return {low, high, false, false}; }
  static Rule open(double low, double high) { return {low, high, true, true}; }

  [[nodiscard]] bool holds(double value) const {
    return (low_open ? value > low : value >= low) && (high_open ? value < high : value <= high);
  }
  [[nodiscard]] std::string text() const;  ///< "must lie in (0, 1)", "must be positive", ...
};

/// An enumeration written as text: each name with its value, in the order shown to the user.
template <class Enum>
using Choices = std::vector<std::pair<std::string, Enum>>;

/// What every visitor has: nested stages, whose keys are prefixed with their name and a dot.
template <class Visitor>
class NestedVisitor {  // NOLINT(bugprone-crtp-constructor-accessibility)
 public:
  template <class Config>
  void section(std::string_view name, Config& config, std::string_view) {
    const std::string outer = prefix_;
    prefix_ += std::string(name) + ".";
    config.visit(static_cast<Visitor&>(*this));
    prefix_ = outer;
  }

 protected:
  /// With the names of the stages around it: "association.gate_probability".
  [[nodiscard]] std::string full_key(std::string_view key) const { return prefix_ + std::string(key); }

 private:
  std::string prefix_;
};

/// Collects every violation of a configuration, with its full key: "association.gate_probability = 1.2: must lie in (0, 1)".
class Validator : public NestedVisitor<Validator> {
 public:
  void field(std::string_view key, double& value, const Rule& rule, std::string_view description);
  void field(std::string_view key, int& value, const Rule& rule, std::string_view description);
  void field(std::string_view, bool&, std::string_view) {}
  void field(std::string_view key, std::optional<double>& value, const Rule& rule, std::string_view description);
  void field(std::string_view key, std::optional<int>& value, const Rule& rule, std::string_view description);
  template <class Enum>
  void choice(std::string_view, Enum&, const Choices<Enum>&, std::string_view) {}

  [[nodiscard]] const std::vector<std::string>& violations() const { return violations_; }

 private:
  void check(std::string_view key, double value, const Rule& rule);

  std::vector<std::string> violations_;
};

/// Every violation of `config`, in the order of its fields; empty when it is valid.
template <class Config>
[[nodiscard]] std::vector<std::string> violations(Config config) {
  Validator validator;
  config.visit(validator);
  return validator.violations();
}

/// Throws InvalidArgument listing every violation.
void throw_if_any(const std::vector<std::string>& violations);

}  // namespace ssjs
