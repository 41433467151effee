#include "ssjs/base/archive.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <functional>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

enum class Colour { kRed, kGreen, kBlue };

struct Inner {
  std::optional<double> value;
  std::vector<int> list;
  void archive(Archive& a) {
    a("value", value);
    a("list", list);
  }
};

struct Outer {
  double number = 0.0, edge = 0.0;
  bool flag = false;
  Colour colour = Colour::kRed;
  std::string text;
  std::vector<double> doubles;
  std::deque<Inner> inners;
  std::map<std::int64_t, Inner> by_id;
  std::set<int> numbers;
  std::array<bool, 3> flags{};
  Eigen::Vector3d vector = Eigen::Vector3d::Zero();
  Eigen::MatrixXd matrix;
  Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 3, 3> rows;
  void archive(Archive& a) {
    a("number", number);
    a.unbounded("edge", edge);
    a("flag", flag);
    a.choice("colour", colour, Colour::kBlue);
    a("text", text);
    a("doubles", doubles);
    a("inners", inners);
    a("by_id", by_id);
    a("numbers", numbers);
    a("flags", flags);
    a("vector", vector);
    a("matrix", matrix);
    a("rows", rows);
  }
};

Outer example() {
  Outer outer;
  outer.number = 0.1 + 0.2;
  outer.edge = -std::numeric_limits<double>::infinity();
  outer.flag = true;
  outer.colour = Colour::kBlue;
  outer.text = "a b";
  outer.doubles = {1.0, -0.0, std::numeric_limits<double>::denorm_min()};
  outer.inners = {{3.0, {1, -2}}, {std::nullopt, {}}};
  outer.by_id = {{-7, {1.0, {}}}, {9, {std::nullopt, {4}}}};
  outer.numbers = {3, 1};
  outer.flags = {true, false, true};
  outer.vector << 1, 2, 3;
  outer.matrix = Eigen::MatrixXd::Random(4, 2);
  outer.rows = Eigen::MatrixXd::Random(2, 3);
  return outer;
}

template <class T>
std::string bytes_of(T value) {
  Archive a;
  a("it", value);
  return a.take_bytes();
}

template <class T>
T read_back(const std::string& bytes) {
  T value{};
  Archive a(bytes, "file");
  a("it", value);
  a.end();
  return value;
}

std::string complaint(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& problem) {
    return problem.what();
  }
  return "";
}

TEST(Archive, EverythingComesBackToTheBit) {
  const Outer outer = example();
  const std::string bytes = bytes_of(outer);
  const Outer back = read_back<Outer>(bytes);
  EXPECT_EQ(back.number, 0.1 + 0.2);
  EXPECT_TRUE(std::signbit(back.doubles.at(1)));
  EXPECT_EQ(back.inners.at(0).list, (std::vector<int>{1, -2}));
  EXPECT_EQ(back.by_id.at(9).list, std::vector<int>{4});
  EXPECT_EQ(back.matrix, outer.matrix);
  EXPECT_EQ(back.rows.rows(), 2);
  EXPECT_EQ(bytes_of(back), bytes);
}

TEST(Archive, IsLittleEndianWithAMarkOfTheNameBeforeEachField) {
  const std::string bytes = bytes_of(1.0);
  EXPECT_EQ(bytes.substr(2), std::string("\0\0\0\0\0\0\xf0\x3f", 8));
  EXPECT_EQ(bytes_of(std::vector<double>{1.0}).substr(2, 8), std::string("\1\0\0\0\0\0\0\0", 8));
}

TEST(Archive, BytesThatAreCutOffAreRefusedWhereverTheyEnd) {
  const std::string bytes = bytes_of(example());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_NE(complaint([&] { static_cast<void>(read_back<Outer>(bytes.substr(0, size))); }).find("file: it"), std::string::npos) << size;
  }
  EXPECT_NE(complaint([&] { static_cast<void>(read_back<Outer>(bytes + "x")); }).find("1 bytes too many"), std::string::npos);
}

TEST(Archive, NamesTheFieldThatIsWrong) {
  Outer outer = example();
  outer.matrix(1, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(complaint([&] { bytes_of(outer); }), "state = it.matrix: is not finite");
  std::string bytes = bytes_of(std::vector<Inner>{{1.0, {}}, {2.0, {5}}});
  const std::size_t second = 2 + 8 + (2 + 1 + 8) + (2 + 8) + (2 + 1);
  bytes.replace(second, 8, std::string(8, '\xff'));
  EXPECT_EQ(complaint([&] { static_cast<void>(read_back<std::vector<Inner>>(bytes)); }), "file: it[1].value is not finite");
}

TEST(Archive, BelievesNoCountThatTheBytesCannotHold) {
  std::string bytes = bytes_of(std::vector<double>{1.0, 2.0});
  bytes[2 + 7] = 0x10;
  EXPECT_NE(complaint([&] { static_cast<void>(read_back<std::vector<double>>(bytes)); }).find("more than the bytes that are left"),
            std::string::npos);
  bytes = bytes_of(Eigen::MatrixXd(Eigen::MatrixXd::Zero(2, 2)));
  bytes[2 + 3] = 0x7f;
  bytes[2 + 8 + 3] = 0x7f;
  EXPECT_NE(complaint([&] { static_cast<void>(read_back<Eigen::MatrixXd>(bytes)); }).find("larger than the bytes"), std::string::npos);
}

struct Other {
  double value = 0.0;
  void archive(Archive& a) { a("worth", value); }
};
struct One {
  double value = 0.0;
  void archive(Archive& a) { a("value", value); }
};

TEST(Archive, RefusesTheBytesOfOtherMembers) {
  EXPECT_NE(complaint([&] { static_cast<void>(read_back<One>(bytes_of(Other{}))); }).find("it.value is not where it should be"),
            std::string::npos);
}

}  // namespace
}  // namespace ssjs
