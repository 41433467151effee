#include "ssjs/cascade/window_set.hpp"

#include <gtest/gtest.h>

#include <set>

#include "cascade/speckle.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/cascade/augmentation.hpp"

namespace ssjs {
namespace {

TEST(WindowSetTest, HoldsWhatWasAdded) {
  Rng rng(1);
  WindowSet windows({8, 6});
  const cv::Mat large = speckle({20, 20}, rng);
  windows.add(large(cv::Rect(3, 4, 8, 6)), 7);
  windows.add(large(cv::Rect(0, 0, 8, 6)), 9);
  EXPECT_EQ(cv::countNonZero(windows[0] != large(cv::Rect(3, 4, 8, 6))), 0);
  EXPECT_EQ(windows.recording(1), 9);
  EXPECT_EQ(windows.select({1}).size(), 1U);
  EXPECT_NE(windows.digest(), windows.select({1, 0}).digest());
  EXPECT_EQ(windows.digest(), windows.select({0, 1}).digest());
  EXPECT_THROW(windows.add(large), InvalidArgument);
  EXPECT_THROW(windows.append(WindowSet({6, 8})), InvalidArgument);
}

TEST(WindowSetTest, BoxesGrowToTheProportionsOfTheWindow) {
  cv::Mat image(100, 100, CV_8U, cv::Scalar(10));
  image(cv::Rect(40, 30, 20, 40)).setTo(200);
  const cv::Mat window = window_of(image, {40, 30, 20, 40}, {24, 24});  // grown to 40 x 40 from (30, 30)
  EXPECT_EQ(window.at<unsigned char>(12, 12), 200);
  EXPECT_EQ(window.at<unsigned char>(12, 2), 10);
  EXPECT_EQ(window.at<unsigned char>(12, 21), 10);
  EXPECT_TRUE(window_of(image, {0, 30, 20, 40}, {24, 24}).empty());  // would begin at column -10
  EXPECT_THROW((void)window_of(image, {5, 5, 0, 3}, {24, 24}), InvalidArgument);
}

TEST(WindowSetTest, SplitsKeepRecordingsTogether) {
  std::vector<int> recordings;
  for (int i = 0; i < 100; ++i) recordings.push_back(i / 7);
  const SampleSplit split = split_by_recording(recordings, 0.3, Rng(1));
  EXPECT_EQ(split.validation.size(), 30U);  // four recordings of 7 and the last, of 2
  EXPECT_EQ(split.validation.size() + split.training.size(), 100U);
  std::set<int> held;
  for (const std::size_t i : split.validation) held.insert(recordings[i]);
  for (const std::size_t i : split.training) EXPECT_EQ(held.count(recordings[i]), 0U);
  EXPECT_NE(split_by_recording(recordings, 0.3, Rng(2)).validation, split.validation);
  EXPECT_TRUE(split_by_recording(std::vector<int>(9, 4), 0.3, Rng(1)).validation.empty());
  EXPECT_THROW((void)split_by_recording(recordings, 1.0, Rng(1)), InvalidArgument);
}

TEST(WindowSetTest, HoldsBackAsNearToTheFractionAsRecordingsAllow) {
  std::vector<int> recordings(60, 0);  // one recording larger than all that is wanted, and forty of one window
  for (int i = 0; i < 40; ++i) recordings.push_back(1 + i);
  const std::vector<int> two_kinds = {1, 1, 1, 1, 1, 1, 1, 2, 2, 2};
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    EXPECT_EQ(split_by_recording(recordings, 0.2, Rng(seed)).validation.size(), 20U);
    EXPECT_EQ(split_by_recording(recordings, 0.0, Rng(seed)).validation.size(), 0U);
    EXPECT_EQ(split_by_recording(two_kinds, 0.4, Rng(seed)).validation.size(), 3U);
    EXPECT_EQ(split_by_recording(two_kinds, 0.5, Rng(seed)).validation.size(), 3U);  // 7 is as far; the training keeps more
    EXPECT_EQ(split_by_recording(two_kinds, 0.9, Rng(seed)).validation.size(), 7U);  // never all
  }
  EXPECT_EQ(split_by_recording(recordings, 0.2, Rng(5)).validation, split_by_recording(recordings, 0.2, Rng(5)).validation);
}

TEST(AugmentationTest, CopiesResembleTheirOriginalAndKeepTheDirectionOfTheShadow) {
  Rng rng(3);
  WindowSet windows({24, 24});
  for (int i = 0; i < 20; ++i) {
    cv::Mat picture(24, 24, CV_8U, cv::Scalar(70));
    draw_object(picture, {0, 0, 24, 24}, rng);
    windows.add(picture, i);
  }
  const WindowSet all = augmented(windows, {}, Rng(1));
  ASSERT_EQ(all.size(), 80U);
  for (std::size_t i = 20; i < all.size(); ++i) {
    EXPECT_EQ(all.recording(i), windows.recording(i % 20));
    EXPECT_GT(cv::countNonZero(all[i] != windows[i % 20]), 100);
    EXPECT_GT(cv::mean(all[i].colRange(5, 12))[0], cv::mean(all[i].colRange(15, 22))[0] + 20);
  }
  EXPECT_EQ(augmented(windows, {}, Rng(1)).digest(), all.digest());
  EXPECT_NE(augmented(windows, {}, Rng(2)).digest(), all.digest());
}

TEST(AugmentationTest, WithoutAnyChangeACopyIsItsOriginal) {
  Rng rng(3);
  WindowSet windows({12, 12});
  windows.add(speckle({12, 12}, rng));
  const WindowSet all = augmented(windows, {1, 0, 0, 0, 0, 0, false}, Rng(1));
  EXPECT_EQ(cv::countNonZero(all[0] != all[1]), 0);
}

}  // namespace
}  // namespace ssjs
