#include "ssjs/optical/keypoint_tracks.hpp"

#include <gtest/gtest.h>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using Tracks = std::vector<std::vector<int>>;

TEST(KeypointTracksTest, V20_MatchesOfPairsBecomeTracks) {
  // frame 0: a b, frame 1: a c b, frame 2: b a
  const Tracks tracks = keypoint_tracks({2, 3, 2}, {{0, 1, {{0, 0}, {1, 2}}}, {1, 2, {{0, 1}, {2, 0}}}});
  EXPECT_EQ(tracks, (Tracks{{0, 1}, {0, -1, 1}, {1, 0}}));
}

TEST(KeypointTracksTest, V20_NoTrackIsTwiceInAFrame) {
  // the last link would make both keypoints of frame 0 one place
  const Tracks tracks = keypoint_tracks({2, 2, 1}, {{0, 1, {{0, 0}, {1, 1}}}, {1, 2, {{0, 0}}}, {0, 2, {{1, 0}}}});
  EXPECT_EQ(tracks, (Tracks{{0, 1}, {0, 1}, {0}}));
}

TEST(KeypointTracksTest, LinksToWhatIsNotThereAreRefused) {
  EXPECT_THROW((void)keypoint_tracks({1, 1}, {{0, 1, {{0, 1}}}}), InvalidArgument);
  EXPECT_THROW((void)keypoint_tracks({1, 1}, {{0, 2, {{0, 0}}}}), InvalidArgument);
  EXPECT_THROW((void)keypoint_tracks({1, 1}, {{0, 1, {{-1, 0}}}}), InvalidArgument);
  EXPECT_TRUE(keypoint_tracks({}, {}).empty());
}

TEST(KeypointTracksTest, V20_TheLongestAreFollowedUntilEveryFrameHasEnough) {
  // track 1 is in three frames, 0 and 2 in two; frame 2 is the only one that still wants another
  const Tracks tracks{{0, 1}, {0, 1, 2}, {1, 2}};
  EXPECT_EQ(chosen_tracks(tracks, 1), (std::vector<int>{1}));
  EXPECT_EQ(chosen_tracks(tracks, 2), (std::vector<int>{0, 1, 2}));
  EXPECT_TRUE(chosen_tracks({{-1}, {}}, 5).empty());
}

}  // namespace
}  // namespace ssjs
