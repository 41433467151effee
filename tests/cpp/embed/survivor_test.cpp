/// A process that is killed at random moments ends with the bytes of one that was left alone.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "base/temporary_folder.hpp"
#include "ssjs/base/whole_file.hpp"

namespace ssjs {
namespace {

using Seconds = std::chrono::duration<double>;

/// Whether `ssjs_survivor` came to its end, within `life`.
class Run {
 public:
  explicit Run(std::vector<std::string> arguments) : process_(fork()) {
    if (process_ != 0) return;
    std::vector<char*> words;
    for (std::string& argument : arguments) words.push_back(argument.data());
    words.push_back(nullptr);
    execv(words.front(), words.data());
    _exit(127);
  }
  /// Kills it after `life`; false when it ended before.
  [[nodiscard]] bool killed_after(Seconds life) const {
    std::this_thread::sleep_for(life);
    kill(process_, SIGKILL);
    int status = 0;
    EXPECT_EQ(waitpid(process_, &status, 0), process_);
    if (WIFSIGNALED(status)) return true;
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
    return false;
  }
  void wait() const {
    int status = 0;
    EXPECT_EQ(waitpid(process_, &status, 0), process_);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  }

 private:
  pid_t process_;
};

/// Kills `kills` runs in all; each survey that is done in spite of it is compared, and the next one begun.
void kill_and_compare(int kills, double mean_life_s, const std::vector<std::string>& settings) {
  const TemporaryFolder folder;
  const std::string state = folder / "state";
  const std::string result = folder / "result";
  const auto arguments = [&](const std::string& checkpoint, const std::string& out, const char* between) {
    std::vector<std::string> all{SSJS_SURVIVOR, checkpoint, out, between};
    all.insert(all.end(), settings.begin(), settings.end());
    return all;
  };
  const auto begin = std::chrono::steady_clock::now();
  Run(arguments(folder / "no state", folder / "whole", "1000000000")).wait();
  const Seconds whole_run = std::chrono::steady_clock::now() - begin;
  const std::string whole = read_whole_file(folder / "whole", 1 << 30);
  ASSERT_GT(whole.size(), 100000U);

  std::mt19937_64 random(20);
  int done = 0, restored = 0;
  const auto compare = [&] {
    EXPECT_TRUE(read_whole_file(result, 1 << 30) == whole) << "survey " << done;
    ++done;
    for (const std::string& file : {state, result}) std::filesystem::remove(file);
  };
  for (int killed = 0; killed < kills;) {
    restored += std::filesystem::exists(state) ? 1 : 0;
    const double life_s = 2.0 * mean_life_s * static_cast<double>(random() % 10000U) / 10000.0;
    if (Run(arguments(state, result, "200")).killed_after(Seconds(life_s))) {
      ++killed;
    } else {
      compare();
    }
    ASSERT_FALSE(::testing::Test::HasFailure());
  }
  Run(arguments(state, result, "200")).wait();
  compare();
  const Seconds all = std::chrono::steady_clock::now() - begin;
  std::printf("%d kills, %d of them of a restored run, %d surveys done: %.0f s; alone a survey takes %.1f s\n", kills, restored, done,
              all.count(), whole_run.count());
}

TEST(Survivor, TenKillsChangeNothing) { kill_and_compare(10, 0.5, {"split.longest_m=60"}); }

TEST(Survivor, TwoHundredKillsChangeNothingLong) { kill_and_compare(200, 0.5, {"split.longest_m=60"}); }

TEST(Survivor, NorTwoHundredOfTheRecursiveSolverLong) { kill_and_compare(200, 0.5, {"split.longest_m=60", "joining.solver=recursive"}); }

}  // namespace
}  // namespace ssjs
