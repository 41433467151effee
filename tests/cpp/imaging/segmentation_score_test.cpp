#include "ssjs/imaging/segmentation_score.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "imaging/drawn_mask.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

LabelledRegions detected(const std::vector<std::string>& rows) {
  const cv::Mat mask = drawn(rows);
  return find_regions(mask, mask);
}

TEST(SegmentationScoreTest, R20_R21_R22_ThePapersTables) {
  struct Table {
    ConfusionMatrix matrix;
    double false_positive_rate;
    double precision;
  };
  // [yuan2016] Tables 1, 2, 4, 5, 7 and 8 with equations (12) to (23), as rounded there. Its (19) prints 1/(1 + 8) = 0.11 for Table 5,
  // where it counts 7 false positives: 1/8.
  for (const Table& table :
       {Table{{2, 4, 0, 21}, 0.16, 0.33}, Table{{2, 8, 0, 20}, 0.29, 0.20}, Table{{1, 1, 0, 13}, 0.07, 0.50},
        Table{{1, 7, 0, 11}, 0.39, 0.125}, Table{{5, 11, 0, 26}, 0.297, 0.3125}, Table{{2, 44, 3, 40}, 0.524, 0.043}}) {
    EXPECT_NEAR(table.matrix.false_positive_rate().value(), table.false_positive_rate, 0.005);
    EXPECT_NEAR(table.matrix.precision().value(), table.precision, 0.005);
  }
  EXPECT_DOUBLE_EQ((ConfusionMatrix{2, 44, 3, 40}).recall().value(), 0.4);
}

TEST(SegmentationScoreTest, R20_MatricesAddUpAndRatiosOfNothingAreNone) {
  ConfusionMatrix sum{2, 4, 0, 21};
  sum += ConfusionMatrix{1, 1, 3, 13};
  EXPECT_EQ(sum.true_positives, 3);
  EXPECT_EQ(sum.false_positives, 5);
  EXPECT_EQ(sum.false_negatives, 3);
  EXPECT_EQ(sum.true_negatives, 34);
  sum += ConfusionMatrix{};  // without known candidates
  EXPECT_FALSE(sum.true_negatives);
  EXPECT_FALSE(sum.false_positive_rate());
  const ConfusionMatrix nothing{0, 0, 0, 0};
  EXPECT_FALSE(nothing.false_positive_rate());
  EXPECT_FALSE(nothing.precision());
  EXPECT_FALSE(nothing.recall());
}

TEST(SegmentationScoreTest, AllMeasuresByHand) {
  // Objects: A 4 x 2 at the top left, B 2 x 2 at the lower right.
  const GroundTruth truth = truth_of_mask(drawn({"####......",  //
                                                 "####......",  //
                                                 "..........",  //
                                                 "........##",  //
                                                 "........##"}));
  // Regions: 1 covers the left half of A, 2 a pixel of A and one beside it, 3 is false, B is missed.
  const LabelledRegions regions = detected({"##.##.....",  //
                                            "##........",  //
                                            ".....##...",  //
                                            "..........",  //
                                            ".........."});
  // Candidates: one on A, one on region 3, two elsewhere, of which one touches B.
  const cv::Mat pool = drawn({"##........",  //
                              "..........",  //
                              ".....#....",  //
                              "........#.",  //
                              "###......."});
  const SegmentationScore score = segmentation_score(regions, truth, pool, {});
  EXPECT_EQ(score.confusion.true_positives, 1);   // region 2: centroid (3.5, 0), rounded (4, 0), is beside A
  EXPECT_EQ(score.confusion.false_positives, 2);  // regions 2 and 3
  EXPECT_EQ(score.confusion.false_negatives, 1);  // B
  EXPECT_EQ(score.confusion.true_negatives, 1);   // the lower left one
  EXPECT_DOUBLE_EQ(score.confusion.false_positive_rate().value(), 2.0 / 3.0);
  ASSERT_EQ(score.objects.size(), 2u);
  EXPECT_EQ(score.objects[0].labels, std::vector<int>{1});
  EXPECT_DOUBLE_EQ(score.objects[0].best_iou, 0.5);  // 4 of 8
  EXPECT_DOUBLE_EQ(score.objects[0].centroid_error_px.value(), 1.0);
  EXPECT_EQ(score.objects[1].best_iou, 0.0);
  EXPECT_FALSE(score.objects[1].centroid_error_px);
  EXPECT_EQ(score.hits, 1);
  EXPECT_DOUBLE_EQ(score.hit_rate().value(), 0.5);
  EXPECT_EQ(score.intersection_px, 5);
  EXPECT_EQ(score.union_px, 15);  // 12 of objects and 3 beside them
  EXPECT_DOUBLE_EQ(score.mask_iou.value(), 1.0 / 3.0);
  EXPECT_DOUBLE_EQ(score.pixel_recall.value(), 5.0 / 12.0);
  EXPECT_EQ(score.false_area_px, 3);
  EXPECT_EQ(score.background_px, 38);
  EXPECT_DOUBLE_EQ(score.false_area_fraction().value(), 3.0 / 38.0);
  EXPECT_DOUBLE_EQ(score.mean_centroid_error_px.value(), 1.0);
}

TEST(SegmentationScoreTest, R18_CentroidAndMajorityDiffer) {
  const GroundTruth truth = truth_of_mask(drawn({"....#....", "....#....", "........."}));
  // The U has its centroid on the object and not a pixel; the other way round for the bar below.
  const LabelledRegions around = detected({"...#.#...", "...#.#...", "...###..."});
  SegmentationScoreConfig config;
  EXPECT_EQ(segmentation_score(around, truth, {}, config).confusion.true_positives, 1);  // centroid (4, 8/7)
  config.match = RegionMatch::kMajority;
  EXPECT_EQ(segmentation_score(around, truth, {}, config).confusion.true_positives, 0);
  EXPECT_EQ(segmentation_score(around, truth, {}, config).confusion.false_negatives, 1);
  const LabelledRegions half = detected({"....##...", ".........", "........."});
  EXPECT_EQ(segmentation_score(half, truth, {}, config).confusion.true_positives, 0);  // a half is no majority
  const LabelledRegions most = detected({"....#....", "....##...", "........."});
  EXPECT_EQ(segmentation_score(most, truth, {}, config).confusion.true_positives, 1);
}

TEST(SegmentationScoreTest, R24_AHitNeedsMoreThanTheLimit) {
  const GroundTruth truth = truth_of_mask(drawn({"##########"}));
  SegmentationScoreConfig config;
  EXPECT_EQ(segmentation_score(detected({"###......."}), truth, {}, config).hits, 0);  // exactly 0.3
  EXPECT_EQ(segmentation_score(detected({"####......"}), truth, {}, config).hits, 1);
  // Two pieces of 0.3 are no hit: a single region has to do it.
  EXPECT_EQ(segmentation_score(detected({"###....###"}), truth, {}, config).hits, 0);
}

TEST(SegmentationScoreTest, R26_TheCentroidOfAnObjectIsThatOfItsRegions) {
  const GroundTruth truth = truth_of_mask(drawn({"########"}));  // centroid 3.5
  const LabelledRegions pieces = detected({"###...#."});         // centroids 1 and 6
  SegmentationScoreConfig config;
  EXPECT_DOUBLE_EQ(segmentation_score(pieces, truth, {}, config).mean_centroid_error_px.value(), 0.0);
  config.weighting = CentroidWeighting::kArea;  // (0 + 1 + 2 + 6) / 4 = 2.25
  EXPECT_DOUBLE_EQ(segmentation_score(pieces, truth, {}, config).mean_centroid_error_px.value(), 1.25);
}

TEST(SegmentationScoreTest, R23_BoxesMeetBoundingBoxes) {
  const LabelledRegions ring = detected({".####..",  //
                                         ".#..#..",  //
                                         ".####..",  //
                                         "......."});
  const GroundTruth truth = truth_of_boxes({7, 4}, {{1, 0, 4, 4}, {3, 0, 4, 3}});
  const SegmentationScore score = segmentation_score(ring, truth, {}, {});
  EXPECT_DOUBLE_EQ(score.objects[0].best_iou, 12.0 / 16.0);
  EXPECT_DOUBLE_EQ(score.objects[1].best_iou, 6.0 / 18.0);
  EXPECT_EQ(score.hits, 2);
  // The centroid (2.5, 1), rounded (3, 1), lies in both boxes: one region, two objects found.
  EXPECT_EQ(score.confusion.true_positives, 1);
  EXPECT_EQ(score.confusion.false_negatives, 0);
  EXPECT_DOUBLE_EQ(score.objects[0].centroid_error_px.value(), 0.5);  // (2.5, 1.5)
  EXPECT_FALSE(score.mask_iou);
  EXPECT_FALSE(score.pixel_recall);
  EXPECT_EQ(score.false_area_px, 0);
  EXPECT_EQ(score.background_px, 28 - 22);  // 16 + 12 - 6 in common
}

TEST(SegmentationScoreTest, PicturesWithoutObjectsOrRegions) {
  const GroundTruth nothing = truth_of_mask(cv::Mat::zeros(2, 5, CV_8U));
  const SegmentationScore clean = segmentation_score(detected({".....", "....."}), nothing, drawn({"#...#", "....."}), {});
  EXPECT_EQ(clean.confusion.true_negatives, 2);
  EXPECT_EQ(clean.confusion.false_positive_rate().value(), 0.0);
  EXPECT_FALSE(clean.hit_rate());
  EXPECT_FALSE(clean.mask_iou);
  EXPECT_EQ(clean.false_area_fraction().value(), 0.0);
  const SegmentationScore noisy = segmentation_score(detected({"##...", "....."}), nothing, {}, {});
  EXPECT_EQ(noisy.confusion.false_positives, 1);
  EXPECT_FALSE(noisy.confusion.false_positive_rate());
  EXPECT_EQ(noisy.mask_iou.value(), 0.0);
  EXPECT_DOUBLE_EQ(noisy.false_area_fraction().value(), 0.2);
  const SegmentationScore empty = segmentation_score(find_regions({}, {}), truth_of_mask({}), {}, {});
  EXPECT_FALSE(empty.false_area_fraction());
}

TEST(SegmentationScoreTest, SizesHaveToAgree) {
  const GroundTruth truth = truth_of_mask(drawn({"##", ".."}));
  EXPECT_THROW(static_cast<void>(segmentation_score(detected({"##."}), truth, {}, {})), InvalidArgument);
  EXPECT_THROW(static_cast<void>(segmentation_score(detected({"##", ".."}), truth, drawn({"#"}), {})), InvalidArgument);
  SegmentationScoreConfig config;
  config.hit_iou = 1.1;
  EXPECT_THROW(static_cast<void>(segmentation_score(detected({"##", ".."}), truth, {}, config)), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
