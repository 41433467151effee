#include "ssjs/base/config_field.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

enum class Shade { kLight, kDark };

struct GateConfig {
  double gate_probability = 0.99;
  int nearest = 3;
  std::optional<double> max_range_m;
  std::optional<int> max_pairs;

  template <class Visitor>
  void visit(Visitor& visitor) {
    visitor.field("gate_probability", gate_probability, Rule::open(0, 1), "individual gate of a pairing");
    visitor.field("nearest", nearest, Rule::at_least(1), "how many candidates are tried");
    visitor.field("max_range_m", max_range_m, Rule::positive(), "farther features are left out");
    visitor.field("max_pairs", max_pairs, Rule::closed(1, 100), "pairs kept");
  }
};

struct StageConfig {
  bool enabled = true;
  Shade shade = Shade::kLight;
  GateConfig gate;
  double sigma_m = 0.1;

  template <class Visitor>
  void visit(Visitor& visitor) {
    visitor.field("enabled", enabled, "whether the stage runs");
    visitor.choice("shade", shade, Choices<Shade>{{"light", Shade::kLight}, {"dark", Shade::kDark}}, "colour of the stage");
    visitor.section("gate", gate, "the gate");
    visitor.field("sigma_m", sigma_m, Rule::not_negative(), "noise");
  }
};

TEST(Rule, HoldsExactlyInsideItsInterval) {
  EXPECT_FALSE(Rule::open(0, 1).holds(0.0));
  EXPECT_TRUE(Rule::open(0, 1).holds(0.5));
  EXPECT_FALSE(Rule::open(0, 1).holds(1.0));
  EXPECT_TRUE(Rule::closed(0, 1).holds(0.0));
  EXPECT_TRUE(Rule::closed(0, 1).holds(1.0));
  EXPECT_FALSE(Rule::closed(0, 1).holds(1.0 + 1e-15));
  EXPECT_FALSE(Rule::positive().holds(0.0));
  EXPECT_TRUE(Rule::positive().holds(std::numeric_limits<double>::denorm_min()));
  EXPECT_TRUE(Rule::not_negative().holds(0.0));
  EXPECT_FALSE(Rule::not_negative().holds(-1e-300));
  EXPECT_TRUE(Rule::at_least(2).holds(2.0));
  EXPECT_FALSE(Rule::at_least(2).holds(1.0));
}

TEST(Rule, InfinityOnlyWhereEveryNumberIsAllowed) {
  EXPECT_TRUE(Rule::any().holds(kInfinity));
  EXPECT_FALSE(Rule::positive().holds(kInfinity));
  EXPECT_FALSE(Rule::not_negative().holds(kInfinity));
  EXPECT_FALSE(Rule::at_least(0).holds(kInfinity));
}

TEST(Rule, NotANumberNeverHolds) {
  for (const Rule& rule : {Rule::any(), Rule::positive(), Rule::not_negative(), Rule::at_least(0), Rule::closed(0, 1), Rule::open(0, 1)}) {
    EXPECT_FALSE(rule.holds(kNaN)) << rule.text();
  }
}

TEST(Rule, SaysWhatItAsksFor) {
  EXPECT_EQ(Rule::open(0, 1).text(), "must lie in (0, 1)");
  EXPECT_EQ(Rule::closed(-0.5, 2).text(), "must lie in [-0.5, 2]");
  EXPECT_EQ(Rule::positive().text(), "must be positive and finite");
  EXPECT_EQ(Rule::not_negative().text(), "must be zero or positive, and finite");
  EXPECT_EQ(Rule::at_least(3).text(), "must be at least 3");
  EXPECT_EQ(Rule::any().text(), "must be a number");
  EXPECT_EQ((Rule{-kInfinity, 5.0, false, true}.text()), "must be below 5");
  EXPECT_EQ((Rule{-kInfinity, 5.0, false, false}.text()), "must be at most 5");
  EXPECT_EQ((Rule{2.0, kInfinity, true, true}.text()), "must be above 2");
}

TEST(Violations, NoneForTheDefaults) { EXPECT_TRUE(violations(StageConfig{}).empty()); }

TEST(Violations, ListsEveryOneWithItsFullKeyInFieldOrder) {
  StageConfig config;
  config.sigma_m = -1.0;
  config.gate.gate_probability = 1.2;
  config.gate.nearest = 0;
  config.gate.max_range_m = 0.0;
  config.gate.max_pairs = 101;
  const std::vector<std::string> expected = {
      "gate.gate_probability = 1.2: must lie in (0, 1)",    "gate.nearest = 0: must be at least 1",
      "gate.max_range_m = 0: must be positive and finite",  "gate.max_pairs = 101: must lie in [1, 100]",
      "sigma_m = -1: must be zero or positive, and finite",  // after a section the prefix is gone again
  };
  EXPECT_EQ(violations(config), expected);
}

TEST(Violations, AbsentOptionalsAreNotChecked) {
  GateConfig config;
  config.max_range_m = std::nullopt;
  EXPECT_TRUE(violations(config).empty());
}

TEST(Violations, NotANumberIsOne) {
  GateConfig config;
  config.gate_probability = kNaN;
  EXPECT_EQ(violations(config), std::vector<std::string>{"gate_probability = nan: must lie in (0, 1)"});
}

TEST(ThrowIfAny, PassesSilentlyOrListsAll) {
  EXPECT_NO_THROW(throw_if_any({}));
  try {
    throw_if_any({"a = 1: must lie in (2, 3)", "b = -1: must be positive and finite"});
    FAIL() << "nothing was thrown";
  } catch (const InvalidArgument& error) {
    EXPECT_STREQ(error.what(), "configuration = 2 violation(s): a = 1: must lie in (2, 3); b = -1: must be positive and finite");
  }
}

}  // namespace
}  // namespace ssjs
