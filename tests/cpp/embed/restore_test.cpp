/// Checkpoints through the interface of the shared library.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "base/temporary_folder.hpp"
#include "embed/samples.hpp"
#include "ssjs/base/whole_file.hpp"

namespace ssjs {
namespace {

using testing::Arriving;

constexpr online::Setting kSettings[] = {{"split.longest_m", "60"}};
constexpr std::size_t kBefore = 20000, kAfter = 1000;

class Restore : public ::testing::Test {
 protected:
  void feed(online::Estimator& fed, std::size_t begin, std::size_t end) const {
    for (std::size_t i = begin; i < end; ++i) ASSERT_EQ(testing::feed(fed, samples[i].sample), online::Arrival::kTaken);
  }
  [[nodiscard]] static std::string bytes_of(online::Estimator& asked) {
    std::string bytes(asked.checkpoint(nullptr, 0), '\0');
    EXPECT_EQ(asked.checkpoint(bytes.data(), bytes.size()), bytes.size());
    return bytes;
  }

  std::vector<Arriving> samples = testing::samples_of(testing::survey(3).ticks);
  online::Estimator estimator{kSettings, 1};
};

TEST_F(Restore, AnotherEstimatorGoesOnFromTheFileAsFromTheBytes) {
  const TemporaryFolder folder;
  const std::string path = folder / "vehicle.state";
  ASSERT_GT(samples.size(), kBefore + kAfter);
  feed(estimator, 0, kBefore);
  ASSERT_TRUE(estimator.checkpoint(path.c_str()));
  ASSERT_TRUE(estimator.wait_for_checkpoint());
  const std::string bytes = bytes_of(estimator);
  EXPECT_TRUE(read_whole_file(path, 1 << 30) == bytes);
  feed(estimator, kBefore, kBefore + kAfter);

  online::Estimator from_file(kSettings, 1), from_bytes(kSettings, 1);
  feed(from_file, 0, 10);  // what it was before is forgotten
  ASSERT_TRUE(from_file.restore(path.c_str())) << from_file.last_error();
  ASSERT_TRUE(from_bytes.restore(bytes.data(), bytes.size())) << from_bytes.last_error();
  for (online::Estimator* const restored : {&from_file, &from_bytes}) {
    feed(*restored, kBefore, kBefore + kAfter);
    EXPECT_TRUE(bytes_of(*restored) == bytes_of(estimator));
  }
}

TEST_F(Restore, ThatFailsLeavesTheEstimatorAsItWasAndSaysWhy) {
  const TemporaryFolder folder;
  feed(estimator, 0, kBefore);
  const std::string before = bytes_of(estimator);
  EXPECT_FALSE(estimator.restore((folder / "nothing").c_str()));
  EXPECT_NE(std::string(estimator.last_error()).find("nothing: is no file that can be read"), std::string::npos);
  std::string damaged = before;
  damaged[damaged.size() / 2] = static_cast<char>(damaged[damaged.size() / 2] ^ 1);
  EXPECT_FALSE(estimator.restore(damaged.data(), damaged.size()));
  EXPECT_EQ(std::string(estimator.last_error()), "checkpoint: is damaged: its checksum is another");
  online::Estimator other;  // of other settings
  EXPECT_FALSE(other.restore(before.data(), before.size()));
  EXPECT_NE(std::string(other.last_error()).find("split.longest_m = 60, here it is 200"), std::string::npos) << other.last_error();
  EXPECT_TRUE(bytes_of(estimator) == before);
  feed(estimator, kBefore, kBefore + kAfter);
}

TEST_F(Restore, AFileThatCannotBeWrittenIsToldAndChangesNothing) {
  const TemporaryFolder folder;
  feed(estimator, 0, 1000);
  ASSERT_TRUE(estimator.checkpoint((folder / "no folder/state").c_str()));
  EXPECT_FALSE(estimator.wait_for_checkpoint());
  EXPECT_NE(std::string(estimator.last_error()).find("no folder/state.part: cannot be written"), std::string::npos);
  feed(estimator, 1000, 2000);
  ASSERT_TRUE(estimator.checkpoint((folder / "state").c_str()));
  EXPECT_TRUE(estimator.wait_for_checkpoint());
}

}  // namespace
}  // namespace ssjs
