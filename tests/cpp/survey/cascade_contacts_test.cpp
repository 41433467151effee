#include "ssjs/survey/cascade_contacts.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "ssjs/base/error.hpp"
#include "ssjs/survey/side_scan_survey.hpp"
#include "survey/survey_pings.hpp"

namespace ssjs {
namespace {

/// One stump: the left half of a window of 12 x 6 pixels brighter than the right one, as an echo before its shadow is to starboard.
HaarCascade echo_before_shadow() {
  HaarCascade cascade;
  cascade.window = {12, 6};
  HaarFeature feature;
  feature.rects[0] = {{0, 0, 12, 6}, -1.0F};
  feature.rects[1] = {{0, 0, 6, 6}, 2.0F};
  cascade.features = {feature};
  WeakClassifier stump;
  stump.nodes = {{0, 0.3F, 0, -1}};
  stump.leaves = {-1.0F, 1.0F};
  cascade.stages = {{{stump}, 0.5F}};
  cascade.provenance.settings = {{"window.margin", "0"}};
  return cascade;
}

/// Seabed of one level with an echo of 6 x 4 pixels and the shadow behind it, away from the nadir.
SonarImage seabed_with(int echo_column, int nadir_column, int columns) {
  SonarImage picture{cv::Mat(40, columns, CV_8U, cv::Scalar(64)), cv::Mat(40, columns, CV_8U, cv::Scalar(255))};
  const bool starboard = echo_column >= nadir_column;
  picture.intensity(cv::Rect(echo_column, 18, 6, 4)).setTo(200);
  picture.intensity(cv::Rect(starboard ? echo_column + 6 : echo_column - 6, 18, 6, 4)).setTo(5);
  return picture;
}

CascadeContactsConfig any_window() {
  CascadeContactsConfig config;
  config.min_neighbours = 0;
  return config;
}

TEST(CascadeContactsTest, EchoesOfBothSidesAreCutOutOfTheirDetections) {
  const CascadeContacts contacts(echo_before_shadow(), any_window());
  for (const int column : {70, 20}) {
    const std::vector<ContactBox> boxes = contacts.boxes(seabed_with(column, 50, 100), 50);
    ASSERT_FALSE(boxes.empty()) << column;
    EXPECT_EQ(boxes.front().side, column > 50 ? SonarSide::kStarboard : SonarSide::kPort);
    EXPECT_GE((boxes.front().box & cv::Rect(column, 18, 6, 4)).area(), 16) << boxes.front().box;
    EXPECT_LE(boxes.front().box.area(), 24);
  }
}

TEST(CascadeContactsTest, AnEmptySeabedHasNone) {
  const CascadeContacts contacts(echo_before_shadow(), any_window());
  const SonarImage empty{cv::Mat(40, 100, CV_8U, cv::Scalar(64)), cv::Mat(40, 100, CV_8U, cv::Scalar(255))};
  EXPECT_TRUE(contacts.boxes(empty, 50).empty());
}

TEST(CascadeContactsTest, ScoresAndEchoesBelowTheirLimitsAreDropped) {
  const SonarImage picture = seabed_with(70, 50, 100);
  CascadeContactsConfig config = any_window();
  config.min_score = 100;
  EXPECT_TRUE(CascadeContacts(echo_before_shadow(), config).boxes(picture, 50).empty());
  config = any_window();
  config.smallest_echo_px = 25;
  EXPECT_TRUE(CascadeContacts(echo_before_shadow(), config).boxes(picture, 50).empty());
  config = any_window();
  config.echo_level = 220;
  EXPECT_TRUE(CascadeContacts(echo_before_shadow(), config).boxes(picture, 50).empty());
}

TEST(CascadeContactsTest, TheObjectLiesInTheMiddleOfItsWindow) {
  // A window of 13 x 7 px with a margin of 0.25: 13 / 1.5 = 8.67, 7 / 1.5 = 4.67
  EXPECT_EQ(object_in_window({10, 20, 13, 7}, 0.25, CascadeSide::kAsTrained), cv::Rect(12, 21, 9, 5));
  EXPECT_EQ(object_in_window({10, 20, 14, 7}, 0.25, CascadeSide::kAsTrained), cv::Rect(12, 21, 9, 5));
  EXPECT_EQ(object_in_window({10, 20, 14, 7}, 0.25, CascadeSide::kMirrored), cv::Rect(13, 21, 9, 5));
}

TEST(CascadeContactsTest, ModelsThatDoNotFitAreRefused) {
  HaarCascade smoothed = echo_before_shadow();
  smoothed.provenance.settings = {{"image.smoothing_px", "3"}};
  EXPECT_THROW(CascadeContacts(smoothed, {}), InvalidArgument);
  HaarCascade damaged = echo_before_shadow();
  damaged.provenance.settings = {{"window.margin", "wide"}};
  EXPECT_THROW(CascadeContacts(damaged, {}), InvalidArgument);
  CascadeContactsConfig verifying;
  verifying.verify = DetectionVerifier::kContour;
  EXPECT_THROW(CascadeContacts(echo_before_shadow(), verifying), InvalidArgument);
}

TEST(CascadeContactsTest, ASurveyNeedsTheModelOfItsDetector) {
  SideScanSurveyConfig config;
  config.detector = ContactDetector::kCascade;
  EXPECT_THROW(SideScanSurvey{config}, InvalidArgument);
  SideScanSurvey survey(config, echo_before_shadow());
  EXPECT_TRUE(survey.finish().empty());
}

}  // namespace
}  // namespace ssjs
