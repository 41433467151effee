#include "ssjs/base/config_text.hpp"

#include <gtest/gtest.h>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

enum class Colour { kRed, kBlue };

struct Inner {
  std::optional<int> most;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("most", most, Rule::at_least(2), "");
  }
};

struct Outer {
  double length_m = 1.0;
  int count = 3;
  bool bold = false;
  Colour colour = Colour::kRed;
  Inner inner;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("length_m", length_m, Rule::positive(), "");
    v.field("count", count, Rule::any(), "");
    v.field("bold", bold, "");
    v.choice("colour", colour, Choices<Colour>{{"red", Colour::kRed}, {"blue", Colour::kBlue}}, "");
    v.section("inner", inner, "");
  }
};

std::string complaint(const std::string& key, const std::string& text) {
  Outer outer;
  try {
    set_field(outer, key, text);
  } catch (const InvalidArgument& error) {
    return error.what();
  }
  return "";
}

TEST(ConfigText, SetsEveryKindOfField) {
  Outer outer;
  set_field(outer, "length_m", "2.5e-1");
  set_field(outer, "count", "-7");
  set_field(outer, "bold", "true");
  set_field(outer, "colour", "blue");
  set_field(outer, "inner.most", "12");
  EXPECT_EQ(outer.length_m, 0.25);
  EXPECT_EQ(outer.count, -7);
  EXPECT_TRUE(outer.bold);
  EXPECT_EQ(outer.colour, Colour::kBlue);
  EXPECT_EQ(outer.inner.most, 12);
  set_field(outer, "inner.most", "none");
  EXPECT_FALSE(outer.inner.most.has_value());
}

TEST(ConfigText, ComplaintsNameKeyValueAndRule) {
  EXPECT_NE(complaint("lenght_m", "1").find("nearest is length_m"), std::string::npos);
  EXPECT_NE(complaint("most", "3").find("nearest is "), std::string::npos);
  EXPECT_NE(complaint("length_m", "0").find("must be positive"), std::string::npos);
  EXPECT_NE(complaint("length_m", "nan").find("length_m"), std::string::npos);
  EXPECT_NE(complaint("length_m", "1e999").find("length_m"), std::string::npos);
  EXPECT_NE(complaint("length_m", "1,5").find("must be a number"), std::string::npos);
  EXPECT_NE(complaint("length_m", "").find("must be a number"), std::string::npos);
  EXPECT_NE(complaint("count", "1.5").find("whole number"), std::string::npos);
  EXPECT_NE(complaint("bold", "yes").find("true or false"), std::string::npos);
  EXPECT_NE(complaint("colour", "green").find("red, blue"), std::string::npos);
  EXPECT_NE(complaint("inner.most", "1").find("at least 2"), std::string::npos);
}

}  // namespace
}  // namespace ssjs
