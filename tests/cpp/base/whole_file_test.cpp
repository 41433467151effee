#include "ssjs/base/whole_file.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "base/temporary_folder.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

TEST(WholeFile, ComesBackByteForByteAndLeavesNothingBesideIt) {
  const TemporaryFolder folder;
  const std::string path = folder / "state";
  const std::string content("a\0b\n\xff", 5);
  write_whole_file(path, "what was there before, and longer");
  write_whole_file(path, content);
  EXPECT_EQ(read_whole_file(path, 5), content);
  EXPECT_FALSE(std::filesystem::exists(path + ".part"));
}

TEST(WholeFile, SaysWhichFileAndWhy) {
  const TemporaryFolder folder;
  const auto complaint = [](const auto& action) -> std::string {
    try {
      action();
    } catch (const FileError& problem) {
      return problem.what();
    }
    return "";
  };
  const std::string inside_nothing = folder / "nowhere/state";
  EXPECT_NE(complaint([&] { write_whole_file(inside_nothing, "x"); }).find("state.part: cannot be written: No such file"),
            std::string::npos);
  EXPECT_NE(complaint([&] { static_cast<void>(read_whole_file(inside_nothing, 10)); }).find("no file"), std::string::npos);
  const std::string path = folder / "state";
  write_whole_file(path, "12345");
  EXPECT_NE(complaint([&] { static_cast<void>(read_whole_file(path, 4)); }).find("larger than 4 bytes"), std::string::npos);
}

}  // namespace
}  // namespace ssjs
