#include "ssjs/base/version.hpp"

#include <gtest/gtest.h>

#include <string>

namespace ssjs {
namespace {

TEST(Version, TextAndNumbersAgree) {
  EXPECT_EQ(std::string(kVersion),
            std::to_string(kVersionMajor) + "." + std::to_string(kVersionMinor) + "." + std::to_string(kVersionPatch));
}

}  // namespace
}  // namespace ssjs
