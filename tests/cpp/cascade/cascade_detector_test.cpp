#include "ssjs/cascade/cascade_detector.hpp"

#include <gtest/gtest.h>

#include <set>
#include <tuple>

#include "cascade/random_cascade.hpp"
#include "cascade/speckle.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using Place = std::tuple<int, int, double>;  // x, y in the scaled picture, score

/// The windows of one scale that pass, one at a time by judge_window.
std::set<Place> one_by_one(const HaarCascade& cascade, const LevelHits& level) {
  const IntegralImage integral(level.picture, IntegralImage::Diagonal::kWith);
  const int step = level.scale >= 2 ? 1 : 2;
  std::set<Place> places;
  for (int y = 0; y + cascade.window.height <= level.picture.rows; y += step)
    for (int x = 0; x + cascade.window.width <= level.picture.cols; x += step) {
      const WindowVerdict verdict = judge_window(cascade, integral, {x, y});
      if (verdict.stages_passed == static_cast<int>(cascade.stages.size())) places.emplace(x, y, verdict.score);
    }
  return places;
}

std::set<Place> places_of(const LevelHits& level) {
  std::set<Place> places;
  for (const auto& hit : level.hits) places.emplace(hit.top_left.x, hit.top_left.y, hit.score);
  return places;
}

CascadeDetectorConfig every_window() {
  CascadeDetectorConfig config;
  config.min_neighbours = 0;
  config.opencv_grid = false;
  return config;
}

TEST(CascadeDetectorTest, C14_ScanFindsWhatJudgingWindowsOneByOneFinds) {
  Rng rng(8);
  int found = 0;
  for (int round = 0; round < 6; ++round) {
    const HaarCascade cascade = random_cascade({12, 10}, FeatureSet::kAll, 3, round % 2 == 0 ? 1 : 3, rng);
    const cv::Mat image = speckle({97 + round, 71}, rng);
    for (const LevelHits& level : CascadeDetector(cascade, every_window()).scan({image, {}})) {
      EXPECT_EQ(places_of(level), one_by_one(cascade, level)) << "scale " << level.scale;
      found += static_cast<int>(level.hits.size());
    }
  }
  EXPECT_GT(found, 1000);
}

TEST(CascadeDetectorTest, TheGridOfOpenCvIsPartOfTheFullOne) {
  Rng rng(9);
  const HaarCascade cascade = random_cascade({12, 12}, FeatureSet::kBasic, 2, 1, rng);
  const cv::Mat image = speckle({90, 75}, rng);
  CascadeDetectorConfig config = every_window();
  const auto all = CascadeDetector(cascade, config).scan({image, {}});
  config.opencv_grid = true;
  const auto some = CascadeDetector(cascade, config).scan({image, {}});
  ASSERT_EQ(all.size(), some.size());
  std::size_t hits_of_all = 0;
  std::size_t hits_of_some = 0;
  for (std::size_t l = 0; l < all.size(); ++l) {
    const auto wide = places_of(all[l]);
    for (const Place& place : places_of(some[l])) EXPECT_TRUE(wide.count(place));
    hits_of_all += all[l].hits.size();
    hits_of_some += some[l].hits.size();
  }
  EXPECT_LT(hits_of_some, hits_of_all);
  EXPECT_GT(hits_of_some, hits_of_all / 2);
}

TEST(CascadeDetectorTest, AnyNumberOfThreadsFindsTheSame) {
  Rng rng(10);
  const HaarCascade cascade = random_cascade({12, 12}, FeatureSet::kAll, 1, 2, rng);
  const cv::Mat image = speckle({160, 200}, rng);
  CascadeDetectorConfig config;
  config.similarity = 0.05;
  config.min_neighbours = 1;
  const CascadeDetector detector(cascade, config);
  const auto expected = detector.detect({image, {}}, 1);
  ASSERT_GT(expected.size(), 2U);
  for (const int threads : {2, 5}) {
    const auto found = detector.detect({image, {}}, threads);
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_EQ(found[i].box, expected[i].box);
      EXPECT_EQ(found[i].score, expected[i].score);
    }
  }
}

TEST(CascadeDetectorTest, DetectionsMoveWithThePictureByWholeSteps) {
  Rng rng(11);
  const HaarCascade cascade = random_cascade({12, 12}, FeatureSet::kAll, 3, 1, rng);
  const cv::Mat wide = speckle({120, 100}, rng);
  CascadeDetectorConfig config = every_window();
  config.max_width_px = 12;  // the first scale alone
  const CascadeDetector detector(cascade, config);
  const auto all = detector.scan({wide, {}}).at(0);
  const auto moved = detector.scan({wide(cv::Rect(6, 4, 114, 96)), {}}).at(0);
  std::set<Place> expected;
  for (const auto& hit : all.hits)
    if (hit.top_left.x >= 6 && hit.top_left.y >= 4) expected.emplace(hit.top_left.x - 6, hit.top_left.y - 4, hit.score);
  EXPECT_GT(expected.size(), 20U);
  EXPECT_EQ(places_of(moved), expected);
}

TEST(CascadeDetectorTest, TheOtherSideIsTheMirroredPicture) {
  Rng rng(12);
  const HaarCascade cascade = random_cascade({12, 12}, FeatureSet::kSideScanBasic, 2, 1, rng);
  const cv::Mat image = speckle({73, 60}, rng);
  cv::Mat flipped;
  cv::flip(image, flipped, 1);
  CascadeDetectorConfig config = every_window();
  config.max_width_px = 12;
  const auto port = CascadeDetector(cascade, config).detect({image, {}});
  config.side = CascadeSide::kMirrored;
  const auto starboard = CascadeDetector(cascade, config).detect({flipped, {}});
  std::set<std::tuple<int, int, double>> expected;
  std::set<std::tuple<int, int, double>> found;
  for (const Detection& d : port) expected.emplace(73 - d.box.x - d.box.width, d.box.y, d.score);
  for (const Detection& d : starboard) found.emplace(d.box.x, d.box.y, d.score);
  EXPECT_GT(expected.size(), 20U);
  EXPECT_EQ(found, expected);
  // and the mirrored model on the mirrored picture, where the grid of odd and even columns is the same one: 73 - 12 is odd, so on 72
  const cv::Mat even = flipped.colRange(0, 72);
  cv::Mat even_back;
  cv::flip(even, even_back, 1);
  config.side = CascadeSide::kAsTrained;
  const auto mirror_model = CascadeDetector(mirrored(cascade), config).detect({even, {}});
  const auto model = CascadeDetector(cascade, config).detect({even_back, {}});
  EXPECT_EQ(mirror_model.size(), model.size());
}

/// Boxes, scores and contours in an order that does not depend on the side.
std::set<std::tuple<int, int, int, int, double, int, double>> described(const std::vector<Detection>& detections, int mirrored_in = 0) {
  std::set<std::tuple<int, int, int, int, double, int, double>> result;
  for (const Detection& d : detections)
    result.emplace(mirrored_in > 0 ? mirrored_in - d.box.x - d.box.width : d.box.x, d.box.y, d.box.width, d.box.height, d.score,
                   d.neighbours, d.contour ? d.contour->score : -1);
  return result;
}

/// What the contours of `count` echoes with shadows look like.
ContourReference contours_of_objects(int count, Rng& rng) {
  std::vector<ContourSpectrum> spectra;
  for (int i = 0; i < count; ++i) {
    cv::Mat window = speckle({36, 36}, rng, 40);
    draw_object(window, {0, 0, 36, 36}, rng);
    if (const auto signature = echo_signature({window, {}}, {0, 0, 36, 36})) spectra.push_back(signature->spectrum);
  }
  return learn_contours(spectra);
}

TEST(CascadeDetectorTest, GroupsAndContoursOfTheOtherSideAreMirroredToTheLastPixel) {
  Rng rng(21);
  HaarCascade cascade = random_cascade({12, 12}, FeatureSet::kSideScanBasic, 1, 1, rng);
  cascade.contour = contours_of_objects(30, rng);
  const cv::Mat image = speckle({173, 160}, rng);
  cv::Mat flipped;
  cv::flip(image, flipped, 1);
  CascadeDetectorConfig config;
  config.similarity = 0.05;
  config.min_neighbours = 1;
  config.verify = DetectionVerifier::kContour;
  config.min_contour_score = 0.03;
  const auto starboard = CascadeDetector(cascade, config).detect({image, {}});
  config.side = CascadeSide::kMirrored;
  const auto port = CascadeDetector(cascade, config).detect({flipped, {}});
  EXPECT_GT(starboard.size(), 2U);
  EXPECT_EQ(described(port), described(starboard, 173));
}

TEST(CascadeDetectorTest, C24_BoxesUnlikeTheKnownContoursAreDropped) {
  Rng rng(21);
  HaarCascade cascade = random_cascade({12, 12}, FeatureSet::kSideScanBasic, 1, 1, rng);
  const cv::Mat image = speckle({52, 44}, rng);
  CascadeDetectorConfig config;
  config.min_neighbours = 0;
  const auto all = CascadeDetector(cascade, config).detect({image, {}});
  ASSERT_GT(all.size(), 20U);
  for (const Detection& d : all) EXPECT_FALSE(d.contour);

  config.verify = DetectionVerifier::kContour;
  EXPECT_THROW(CascadeDetector(cascade, config), InvalidArgument);  // it knows no contour
  cascade.contour = contours_of_objects(40, rng);
  config.min_contour_score = 0;
  const auto looked_at = CascadeDetector(cascade, config).detect({image, {}});
  ASSERT_EQ(looked_at.size(), all.size());
  std::size_t expected = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(looked_at[i].box, all[i].box);
    const auto signature = echo_signature({image, {}}, all[i].box);
    ASSERT_TRUE(signature && looked_at[i].contour);
    const double distance = contour_distance(signature->spectrum, *cascade.contour);
    EXPECT_EQ(looked_at[i].contour->distance, distance);
    EXPECT_EQ(looked_at[i].contour->score, contour_score(distance, *cascade.contour));
    expected += looked_at[i].contour->score >= 0.3 ? 1 : 0;
  }
  config.min_contour_score = 0.3;
  EXPECT_EQ(CascadeDetector(cascade, config).detect({image, {}}).size(), expected);
  EXPECT_LT(expected, all.size());
}

TEST(CascadeDetectorTest, WindowsOnInvalidPixelsAreNotLookedAt) {
  Rng rng(13);
  const HaarCascade cascade = random_cascade({12, 12}, FeatureSet::kBasic, 1, 1, rng);
  const cv::Mat image = speckle({90, 70}, rng);
  cv::Mat valid(image.size(), CV_8U, cv::Scalar(255));
  const cv::Rect padding(0, 0, 40, 70);
  valid(padding).setTo(0);
  CascadeDetectorConfig config = every_window();
  config.max_width_px = 12;
  const auto unmasked = CascadeDetector(cascade, config).detect({image, {}});
  const auto masked = CascadeDetector(cascade, config).detect({image, valid});
  std::size_t expected = 0;
  for (const Detection& d : unmasked) expected += (d.box & padding).empty() ? 1 : 0;
  EXPECT_GT(expected, 20U);
  EXPECT_LT(expected, unmasked.size());
  EXPECT_EQ(masked.size(), expected);
  for (const Detection& d : masked) EXPECT_TRUE((d.box & padding).empty());

  config.max_invalid_fraction = 0.5;
  bool reaches_in = false;
  for (const Detection& d : CascadeDetector(cascade, config).detect({image, valid})) {
    EXPECT_LE((d.box & padding).area(), 72);
    reaches_in = reaches_in || !(d.box & padding).empty();
  }
  EXPECT_TRUE(reaches_in);
}

TEST(CascadeDetectorTest, SizesAreKeptAndSmallPicturesHoldNothing) {
  Rng rng(14);
  const HaarCascade cascade = random_cascade({12, 12}, FeatureSet::kBasic, 1, 1, rng);
  const cv::Mat image = speckle({90, 70}, rng);
  CascadeDetectorConfig config = every_window();
  config.min_width_px = 20;
  config.max_height_px = 40;
  const auto found = CascadeDetector(cascade, config).detect({image, {}});
  EXPECT_GT(found.size(), 5U);
  for (const Detection& d : found) {
    EXPECT_GE(d.box.width, 19);  // clipped at the border by rounding
    EXPECT_LE(d.box.height, 40);
    EXPECT_EQ(d.box & cv::Rect({0, 0}, image.size()), d.box);
  }
  EXPECT_TRUE(CascadeDetector(cascade, every_window()).detect({image(cv::Rect(0, 0, 11, 70)), {}}).empty());
  EXPECT_TRUE(CascadeDetector(cascade, every_window()).detect({cv::Mat(70, 90, CV_8U, cv::Scalar(77)), {}}).empty());
}

TEST(CascadeDetectorTest, ContradictionsAreRefused) {
  Rng rng(15);
  const HaarCascade cascade = random_cascade({12, 12}, FeatureSet::kBasic, 1, 1, rng);
  CascadeDetectorConfig config;
  config.scale_factor = 1;
  EXPECT_THROW(CascadeDetector(cascade, config), InvalidArgument);
  EXPECT_THROW(CascadeDetector(HaarCascade{}, {}), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
