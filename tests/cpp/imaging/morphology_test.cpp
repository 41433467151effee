#include "ssjs/imaging/morphology.hpp"

#include <gtest/gtest.h>

#include <set>
#include <utility>
#include <vector>

#include "imaging/drawn_mask.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/base/random.hpp"

namespace ssjs {
namespace {

cv::Mat speckle(int rows, int columns, double density, std::uint64_t seed) {
  Rng rng(seed);
  cv::Mat mask(rows, columns, CV_8U);
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x)
      mask.at<unsigned char>(y, x) = static_cast<unsigned char>(rng.uniform(0, 1) < density ? rng.uniform(1, 256) : 0);
  }
  return mask;
}

bool is_set(const cv::Mat& mask, int y, int x) {
  return y >= 0 && y < mask.rows && x >= 0 && x < mask.cols && mask.at<unsigned char>(y, x) != 0;
}

/// The pixels that a walk over set (or clear) pixels reaches from one of them; the slow and plain way.
std::vector<cv::Point> reached(const cv::Mat& mask, cv::Point from, bool over_set, bool diagonally, cv::Mat& seen) {
  std::vector<cv::Point> pixels{from};
  seen.at<unsigned char>(from) = 1;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const cv::Point next(pixels[i].x + dx, pixels[i].y + dy);
        if ((!diagonally && dx != 0 && dy != 0) || !next.inside({0, 0, mask.cols, mask.rows})) continue;
        if (seen.at<unsigned char>(next) != 0 || is_set(mask, next.y, next.x) != over_set) continue;
        seen.at<unsigned char>(next) = 1;
        pixels.push_back(next);
      }
    }
  }
  return pixels;
}

/// The rule of 'bridge' in words: the set neighbours fall into two or more components under 8-adjacency among themselves, except
/// that exactly two corners of one side do not count.
bool bridged_by_the_rule(const cv::Mat& mask, int y, int x) {
  if (is_set(mask, y, x)) return true;
  std::vector<cv::Point> neighbours;
  bool edge = false;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if ((dx == 0 && dy == 0) || !is_set(mask, y + dy, x + dx)) continue;
      neighbours.emplace_back(dx, dy);
      edge = edge || dx == 0 || dy == 0;
    }
  }
  std::vector<std::size_t> component(neighbours.size());
  for (std::size_t i = 0; i < neighbours.size(); ++i) component[i] = i;
  for (std::size_t i = 0; i < neighbours.size(); ++i) {
    for (std::size_t j = 0; j < neighbours.size(); ++j) {
      const cv::Point step = neighbours[i] - neighbours[j];
      if (std::abs(step.x) > 1 || std::abs(step.y) > 1 || component[i] == component[j]) continue;
      const std::size_t old = component[j];
      for (std::size_t& c : component) c = c == old ? component[i] : c;
    }
  }
  const std::size_t components = std::set<std::size_t>(component.begin(), component.end()).size();
  const bool two_corners_of_one_side =
      !edge && neighbours.size() == 2 && (neighbours[0].x == neighbours[1].x || neighbours[0].y == neighbours[1].y);
  return components >= 2 && !two_corners_of_one_side;
}

TEST(MorphologyTest, R2_ComponentsAreKeptFromTheSmallestAreaOn) {
  const cv::Mat mask = drawn({"##..#",  //
                              "....#",  //
                              "...#.",  //
                              "#....",  //
                              ".#.##"},
                             3);
  expect_mask(remove_small_components(mask, 3), {"....#",  //
                                                 "....#",  //
                                                 "...#.",  //
                                                 ".....",  //
                                                 "....."});
  expect_mask(remove_small_components(mask, 2), {"##..#",  //
                                                 "....#",  //
                                                 "...#.",  //
                                                 "#....",  //
                                                 ".#.##"});
  EXPECT_EQ(cv::countNonZero(remove_small_components(mask, 4)), 0);
  EXPECT_EQ(text(remove_small_components(mask, 0)), text(mask != 0));
}

TEST(MorphologyTest, R2_ArmsThatMeetLateAreOneComponent) {
  // a U, a spiral of 17 pixels and a lone pixel: the arms are separate until their last row
  const cv::Mat mask = drawn({"#.#.#####",  //
                              "#.#.#...#",  //
                              "#.#.#.#.#",  //
                              "###.#.#.#",  //
                              "....#.###",  //
                              "##..#...."});
  EXPECT_EQ(text(remove_small_components(mask, 3)), text(drawn({"#.#.#####",  //
                                                                "#.#.#...#",  //
                                                                "#.#.#.#.#",  //
                                                                "###.#.#.#",  //
                                                                "....#.###",  //
                                                                "....#...."})));
  expect_mask(remove_small_components(mask, 10), {"....#####",  //
                                                  "....#...#",  //
                                                  "....#.#.#",  //
                                                  "....#.#.#",  //
                                                  "....#.###",  //
                                                  "....#...."});
}

TEST(MorphologyTest, R3_BridgeFollowsTheRuleOnAll512Neighbourhoods) {
  int set_by_bridge = 0;
  for (int code = 0; code < 512; ++code) {
    cv::Mat mask = cv::Mat::zeros(3, 3, CV_8U);
    for (int bit = 0; bit < 9; ++bit) mask.at<unsigned char>(bit % 3, bit / 3) = static_cast<unsigned char>(code >> bit & 1);
    const bool set = is_set(bridge(mask), 1, 1);
    ASSERT_EQ(set, bridged_by_the_rule(mask, 1, 1)) << "neighbourhood " << code;
    if (set && !is_set(mask, 1, 1)) ++set_by_bridge;
  }
  EXPECT_EQ(set_by_bridge, 119);  // of the 256 clear centres
}

TEST(MorphologyTest, R3_BridgeByHand) {
  // Between the ends of the line; between the two diagonal pixels; not between two corners of one side.
  expect_mask(bridge(drawn({"#.##.",  //
                            ".....",  //
                            "#...#",  //
                            ".....",  //
                            "#.#.."},
                           1)),
              {"####.",  //
               "##.##",  //
               "#...#",  //
               "##.#.",  //
               "###.."});
}

TEST(MorphologyTest, R3_BridgeIsOnePassAtOnce) {
  // Were new pixels seen by later ones, the middle of the ring would be joined to its sides.
  expect_mask(bridge(drawn({"#...#",  //
                            ".....",  //
                            "..#..",  //
                            ".....",  //
                            "#...#"})),
              {"#...#",  //
               ".#.#.",  //
               "..#..",  //
               ".#.#.",  //
               "#...#"});
}

TEST(MorphologyTest, R3_BridgeFollowsTheRuleAtBordersOfSpeckle) {
  for (const auto& [rows, columns] : std::vector<std::pair<int, int>>{{1, 1}, {1, 40}, {40, 1}, {2, 17}, {37, 53}}) {
    for (const double density : {0.1, 0.5, 0.9}) {
      const cv::Mat mask = speckle(rows, columns, density, 5);
      const cv::Mat bridged = bridge(mask);
      for (int y = 0; y < rows; ++y) {
        for (int x = 0; x < columns; ++x) ASSERT_EQ(is_set(bridged, y, x), bridged_by_the_rule(mask, y, x)) << y << ", " << x;
      }
      EXPECT_EQ(cv::countNonZero(bridged == 255), cv::countNonZero(bridged));
    }
  }
}

TEST(MorphologyTest, R4_DilationsAddASquareEach) {
  const cv::Mat mask = drawn({"#....",  //
                              ".....",  //
                              ".....",  //
                              ".....",  //
                              "....#"},
                             7);
  expect_mask(dilate(mask, 0), {"#....", ".....", ".....", ".....", "....#"});
  expect_mask(dilate(mask, 1), {"##...",  //
                                "##...",  //
                                ".....",  //
                                "...##",  //
                                "...##"});
  expect_mask(dilate(mask, 2), {"###..",  //
                                "###..",  //
                                "#####",  //
                                "..###",  //
                                "..###"});
  EXPECT_EQ(cv::countNonZero(dilate(mask, 1'000'000)), 25);
  EXPECT_EQ(cv::countNonZero(dilate(cv::Mat::zeros(5, 5, CV_8U), 1'000'000)), 0);
}

TEST(MorphologyTest, R5_HolesAreClosedAgainstFourNeighbours) {
  // The hole of the upper ring touches the outside only at a corner, which no 4-connected path uses; the lower right one is open.
  expect_mask(fill_holes(drawn({".###....",  //
                                "#...#...",  //
                                "#...#...",  //
                                ".###....",  //
                                "........",  //
                                "....####",  //
                                "#...#...",  //
                                ".#..####"},
                               1)),
              {".###....",  //
               "#####...",  //
               "#####...",  //
               ".###....",  //
               "........",  //
               "....####",  //
               "#...#...",  //
               ".#..####"});
}

TEST(MorphologyTest, SpeckleAgreesWithThePlainWay) {
  for (const double density : {0.05, 0.3, 0.41, 0.6, 0.9}) {
    const cv::Mat mask = speckle(61, 83, density, 11);
    cv::Mat large = cv::Mat::zeros(mask.size(), CV_8U);
    cv::Mat filled = mask != 0;
    cv::Mat seen = cv::Mat::zeros(mask.size(), CV_8U);
    for (int y = 0; y < mask.rows; ++y) {
      for (int x = 0; x < mask.cols; ++x) {
        if (seen.at<unsigned char>(y, x) != 0) continue;
        const bool set = is_set(mask, y, x);
        const std::vector<cv::Point> pixels = reached(mask, {x, y}, set, set, seen);
        bool at_border = false;
        for (const cv::Point& p : pixels) at_border = at_border || p.x == 0 || p.y == 0 || p.x == mask.cols - 1 || p.y == mask.rows - 1;
        for (const cv::Point& p : pixels) {
          if (set && pixels.size() >= 9) large.at<unsigned char>(p) = 255;
          if (!set && !at_border) filled.at<unsigned char>(p) = 255;
        }
      }
    }
    EXPECT_EQ(text(remove_small_components(mask, 9)), text(large)) << density;
    EXPECT_EQ(text(fill_holes(mask)), text(filled)) << density;
  }
}

TEST(MorphologyTest, PartsOfLargerImagesAreSeenAlone) {
  const cv::Mat image = speckle(40, 40, 0.4, 3);
  const cv::Mat part = image(cv::Rect(7, 9, 21, 19));
  const cv::Mat alone = part.clone();
  EXPECT_EQ(text(remove_small_components(part, 5)), text(remove_small_components(alone, 5)));
  EXPECT_EQ(text(bridge(part)), text(bridge(alone)));
  EXPECT_EQ(text(dilate(part, 2)), text(dilate(alone, 2)));
  EXPECT_EQ(text(fill_holes(part)), text(fill_holes(alone)));
}

TEST(MorphologyTest, ImagesWithoutPixelsAndWithOne) {
  for (const cv::Mat& none : {cv::Mat(), cv::Mat(0, 5, CV_8U), cv::Mat(5, 0, CV_8U)}) {
    for (const cv::Mat& result : {remove_small_components(none, 3), bridge(none), dilate(none, 2), fill_holes(none)})
      EXPECT_EQ(result.size(), none.size());
  }
  const cv::Mat set(1, 1, CV_8U, cv::Scalar(9));
  const cv::Mat clear = cv::Mat::zeros(1, 1, CV_8U);
  EXPECT_EQ(remove_small_components(set, 1).at<unsigned char>(0), 255);
  EXPECT_EQ(remove_small_components(set, 2).at<unsigned char>(0), 0);
  for (const cv::Mat& result : {bridge(set), dilate(set, 2), fill_holes(set)}) EXPECT_EQ(result.at<unsigned char>(0), 255);
  for (const cv::Mat& result : {bridge(clear), dilate(clear, 2), fill_holes(clear)}) EXPECT_EQ(result.at<unsigned char>(0), 0);
}

TEST(MorphologyTest, WhatIsNoMaskIsRefused) {
  const cv::Mat wide(3, 3, CV_16U, cv::Scalar(1));
  EXPECT_THROW(static_cast<void>(remove_small_components(wide, 1)), InvalidArgument);
  EXPECT_THROW(static_cast<void>(bridge(cv::Mat(3, 3, CV_8UC3))), InvalidArgument);
  EXPECT_THROW(static_cast<void>(dilate(wide, 1)), InvalidArgument);
  EXPECT_THROW(static_cast<void>(fill_holes(wide)), InvalidArgument);
  const cv::Mat good(3, 3, CV_8U, cv::Scalar(1));
  EXPECT_THROW(static_cast<void>(dilate(good, -1)), InvalidArgument);
  EXPECT_THROW(static_cast<void>(remove_small_components(good, -1)), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
