#include "ssjs/base/error.hpp"

#include <gtest/gtest.h>

#include <string>

namespace ssjs {
namespace {

TEST(InvalidArgument, NamesArgumentValueAndRule) {
  EXPECT_STREQ(InvalidArgument("gate_probability", 1.2, "must lie in (0, 1)").what(), "gate_probability = 1.2: must lie in (0, 1)");
  EXPECT_STREQ(InvalidArgument("method", "fast", "must be one of ssjs, ekf").what(), "method = fast: must be one of ssjs, ekf");
}

TEST(InvalidArgument, ShowsEnoughDigitsToTellValuesApart) {
  EXPECT_STREQ(InvalidArgument("time_s", 1234567.25, "must not go back").what(), "time_s = 1234567.25: must not go back");
}

TEST(NotPositiveDefinite, NamesMatrixAndPlace) {
  EXPECT_STREQ(NotPositiveDefinite("S", "landmark 7").what(), "S is not positive definite (landmark 7)");
}

TEST(FileError, KeepsPathAndOffset) {
  const FileError error("odometry.csv", 12, "line 12: time_s goes back; sort the rows");
  EXPECT_STREQ(error.what(), "odometry.csv: line 12: time_s goes back; sort the rows");
  EXPECT_EQ(error.path(), "odometry.csv");
  EXPECT_EQ(error.offset(), 12);
}

TEST(Error, IsTheRootOfAll) {
  EXPECT_THROW(throw InvalidArgument("a", 0.0, "b"), Error);
  EXPECT_THROW(throw NotPositiveDefinite("P", "map 1"), Error);
  EXPECT_THROW(throw FileError("a", 0, "b"), Error);
  EXPECT_THROW(throw Cancelled(), Error);
}

}  // namespace
}  // namespace ssjs
