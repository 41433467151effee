#include "ssjs/imaging/segmentation.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "ssjs/base/error.hpp"
#include "ssjs/base/random.hpp"
#include "ssjs/imaging/histogram.hpp"
#include "ssjs/imaging/morphology.hpp"
#include "ssjs/imaging/sonar_scene.hpp"

namespace ssjs {
namespace {

constexpr ThresholdMethod kMethods[] = {ThresholdMethod::kImprovedOtsu, ThresholdMethod::kOtsu, ThresholdMethod::kLocal,
                                        ThresholdMethod::kIterative, ThresholdMethod::kMaximumEntropy};

SegmentationConfig with(ThresholdMethod method) {
  SegmentationConfig config;
  config.method = method;
  return config;
}

bool same(const cv::Mat& a, const cv::Mat& b) { return a.size() == b.size() && a.type() == b.type() && cv::countNonZero(a != b) == 0; }

TEST(SegmentationTest, DrawnRectanglesBecomeRegionsWithTheirMeasures) {
  // Two rectangles of 20 x 10 pixels, one with a hole of 2 x 2, ten pixels apart, and a spot of 3 pixels; without dilation their own
  // pixels.
  cv::Mat image(100, 120, CV_8U, cv::Scalar(40));
  image(cv::Rect(20, 30, 20, 10)) = 200;
  image(cv::Rect(25, 34, 2, 2)) = 40;
  image(cv::Rect(50, 30, 20, 10)) = 220;
  image(cv::Rect(90, 90, 3, 1)) = 230;
  SegmentationConfig config;
  config.dilations = 0;
  config.object_gap_px = 12;
  const SegmentationResult result = segment({image, {}}, config, KeepSteps::kYes);
  ASSERT_EQ(result.regions.regions.size(), 2U);
  EXPECT_EQ(result.smallest_area_px, 10);
  const Region& first = result.regions.regions[0];
  EXPECT_EQ(first.area_px, 200);
  EXPECT_EQ(first.centroid_px, cv::Point2d(29.5, 34.5));
  EXPECT_EQ(first.bounding_box, cv::Rect(20, 30, 20, 10));
  EXPECT_DOUBLE_EQ(first.mean_intensity, (196 * 200 + 4 * 40) / 200.0);  // of the image as it was given, the filled hole with it
  ASSERT_EQ(result.objects.size(), 1U);
  EXPECT_EQ(result.objects[0].centroid_px, cv::Point2d(44.5, 34.5));
  // 0.1 x 40^1.415 = 18.5, 200 -> 180.3, 220 -> 206.3, 230 -> 219.7: Otsu splits above the seabed.
  EXPECT_EQ(result.threshold, 18);
  ASSERT_TRUE(result.improved_otsu);
  EXPECT_FALSE(result.improved_otsu->second_pass_fired);
  ASSERT_TRUE(result.steps);
  EXPECT_EQ(cv::countNonZero(result.steps->thresholded), 396 + 3);
  EXPECT_EQ(cv::countNonZero(result.steps->cleaned), 396);
  EXPECT_EQ(cv::countNonZero(result.mask), 400);
  EXPECT_FALSE(segment({image, {}}, config).steps);
}

TEST(SegmentationTest, StagesAreThoseOfTheirOwnFunctions) {
  const SonarScene scene = simulate_spotted_scene(branch_scene(), Rng(3));
  SegmentationConfig config = segmentation_preset(SegmentationPreset::kSideScanLow);
  config.filter.kind = SpeckleFilter::kGaussian;
  config.filter.sigma_px = 1;
  config.gain.kind = GainNormalisation::kLocalMean;
  const SegmentationResult result = segment(scene.image, config, KeepSteps::kYes);
  const SegmentationSteps& steps = *result.steps;
  EXPECT_TRUE(same(steps.filtered, smooth_speckle(scene.image, config.filter)));
  EXPECT_TRUE(same(steps.normalised, normalise_gain({steps.filtered, {}}, config.gain)));
  EXPECT_TRUE(same(steps.contrasted, power_law({steps.normalised, {}}, config.power_law)));
  EXPECT_EQ(result.threshold, improved_otsu({steps.contrasted, {}}, config.improved_otsu)->threshold);
  EXPECT_TRUE(same(steps.thresholded, steps.contrasted > *result.threshold));
  EXPECT_TRUE(same(steps.cleaned, remove_small_components(steps.thresholded, 15)));
  EXPECT_TRUE(same(steps.bridged, bridge(steps.cleaned)));
  EXPECT_TRUE(same(steps.dilated, dilate(steps.bridged, 1)));
  EXPECT_TRUE(same(result.mask, fill_holes(steps.dilated)));
}

TEST(SegmentationTest, EachMethodSetsTheThresholdOfItsOwn) {
  const SonarScene scene = simulate_spotted_scene(branch_scene(), Rng(4));
  const SonarImage contrasted{power_law(scene.image, {}), {}};
  const Histogram levels = histogram(contrasted);
  EXPECT_EQ(segment(scene.image, with(ThresholdMethod::kOtsu)).threshold, otsu_threshold(levels));
  EXPECT_EQ(segment(scene.image, with(ThresholdMethod::kIterative)).threshold, iterative_threshold(levels));
  EXPECT_EQ(segment(scene.image, with(ThresholdMethod::kMaximumEntropy)).threshold, maximum_entropy_threshold(levels));
  const SegmentationResult local = segment(scene.image, with(ThresholdMethod::kLocal), KeepSteps::kYes);
  EXPECT_FALSE(local.threshold);
  EXPECT_TRUE(same(local.steps->thresholded, local_foreground(contrasted, {})));
  EXPECT_FALSE(local.improved_otsu);
}

TEST(SegmentationTest, PresetsAreThePapers) {
  const SegmentationConfig ship = segmentation_preset(SegmentationPreset::kSideScanHigh);
  EXPECT_EQ(ship.improved_otsu.spot_px, 30);
  EXPECT_EQ(ship.improved_otsu.spot_limit, 300);
  EXPECT_EQ(ship.improved_otsu.canny_high, 0.33);
  EXPECT_EQ(ship.dilations, 1);
  const SegmentationConfig branch = segmentation_preset(SegmentationPreset::kSideScanLow);
  EXPECT_EQ(branch.improved_otsu.spot_px, 15);
  EXPECT_EQ(branch.improved_otsu.spot_limit, 100);
  EXPECT_EQ(branch.improved_otsu.canny_high, 0.1255);
  EXPECT_EQ(branch.dilations, 1);
  const SegmentationConfig body = segmentation_preset(SegmentationPreset::kForwardLooking);
  EXPECT_EQ(body.improved_otsu.spot_px, 40);
  EXPECT_EQ(body.improved_otsu.spot_limit, 600);
  EXPECT_EQ(body.improved_otsu.canny_high, 0.13);
  EXPECT_EQ(body.dilations, 2);
  EXPECT_FALSE(segmentation_preset(SegmentationPreset::kAutomatic).improved_otsu.spot_px);
  EXPECT_EQ(segmentation_preset(SegmentationPreset::kBest).method, ThresholdMethod::kLocal);
  for (const auto& [name, preset] : kSegmentationPresets) EXPECT_TRUE(segmentation_preset(preset).violations().empty()) << name;
}

TEST(SegmentationTest, ConfigurationsSayAllThatIsWrongWithThem) {
  SegmentationConfig config;
  config.filter.median_px = 4;
  config.gain.window_px = 100;
  config.local.window_px = 1;
  config.power_law.exponent = -1;
  config.improved_otsu.spot_px = 0;
  config.improved_otsu.canny_high = 1.5;
  config.dilations = -1;
  EXPECT_EQ(config.violations(), (std::vector<std::string>{
                                     "power_law.exponent = -1: must be positive and finite",
                                     "improved_otsu.spot_px = 0: must be at least 1",
                                     "improved_otsu.canny_high = 1.5: must lie in [0, 1]",
                                     "local.window_px = 1: must be at least 3",
                                     "dilations = -1: must lie in [0, 50]",
                                     "filter.median_px = 4: must be odd",
                                     "gain.window_px = 100: must be odd",
                                 }));
  EXPECT_THROW((void)segment({cv::Mat(5, 5, CV_8U, cv::Scalar(1)), {}}, config), InvalidArgument);
}

TEST(SegmentationTest, InvalidPixelsHaveNoSayAndAreNeverForeground) {
  SpottedSceneConfig fan = branch_scene();
  fan.fan = true;
  const SonarScene scene = simulate_spotted_scene(fan, Rng(5));
  for (const ThresholdMethod method : kMethods) {
    SegmentationConfig config = with(method);
    config.filter.kind = SpeckleFilter::kMedian;
    config.gain.kind = GainNormalisation::kColumnMedian;
    const SegmentationResult expected = segment(scene.image, config);
    EXPECT_GT(cv::countNonZero(expected.mask), 0);
    EXPECT_EQ(cv::countNonZero(expected.mask & (scene.image.valid == 0)), 0);
    SonarImage disturbed = scene.image;
    disturbed.intensity = scene.image.intensity.clone();
    disturbed.intensity.setTo(255, scene.image.valid == 0);
    const SegmentationResult found = segment(disturbed, config);
    EXPECT_TRUE(same(found.mask, expected.mask));
    EXPECT_EQ(found.threshold, expected.threshold);
  }
}

TEST(SegmentationTest, SixteenBitsOfTheSamePictureGiveTheSameMask) {
  // 16-bit levels are 257 times those of 8 bits and span the same range.
  const SonarScene scene = simulate_spotted_scene(ship_scene(), Rng(6));
  cv::Mat narrow = scene.image.intensity.clone();
  narrow.at<unsigned char>(0, 0) = 0;
  narrow.at<unsigned char>(0, 1) = 255;
  cv::Mat wide;
  narrow.convertTo(wide, CV_16U, 257);
  const SegmentationResult eight = segment({narrow, {}}, {});
  const SegmentationResult sixteen = segment({wide, {}}, {});
  EXPECT_EQ(sixteen.threshold, eight.threshold);
  EXPECT_TRUE(same(sixteen.mask, eight.mask));
  EXPECT_NEAR(sixteen.regions.regions.at(0).mean_intensity, 257 * eight.regions.regions.at(0).mean_intensity, 1e-6);
}

TEST(SegmentationTest, PicturesWithoutTwoClassesHaveNoForeground) {
  for (const ThresholdMethod method : kMethods) {
    const auto expect_nothing = [&](const SonarImage& image) {
      const SegmentationResult result = segment(image, with(method));
      EXPECT_FALSE(result.threshold);
      EXPECT_FALSE(result.improved_otsu);
      EXPECT_EQ(result.mask.size(), image.intensity.size());
      EXPECT_EQ(cv::countNonZero(result.mask), 0);
      EXPECT_TRUE(result.regions.regions.empty());
      EXPECT_TRUE(result.objects.empty());
    };
    expect_nothing({cv::Mat(30, 40, CV_8U, cv::Scalar(120)), {}});
    expect_nothing({cv::Mat(30, 40, CV_16U, cv::Scalar(1200)), {}});
    expect_nothing({cv::Mat(1, 1, CV_8U, cv::Scalar(255)), {}});
    expect_nothing({cv::Mat(5, 5, CV_8U, cv::Scalar(9)), cv::Mat::zeros(5, 5, CV_8U)});
  }
  EXPECT_THROW((void)segment({}, {}), InvalidArgument);
}

TEST(SegmentationTest, TheInputIsLeftAlone) {
  const SonarScene scene = simulate_spotted_scene(branch_scene(), Rng(8));
  const cv::Mat before = scene.image.intensity.clone();
  (void)segment(scene.image, {}, KeepSteps::kYes);
  EXPECT_TRUE(same(scene.image.intensity, before));
}

TEST(SegmentationTest, ThreadsChangeNothing) {
  const SonarScene scene = simulate_spotted_scene(ship_scene(), Rng(2));
  SegmentationConfig config;
  config.filter.kind = SpeckleFilter::kMedian;
  config.gain.kind = GainNormalisation::kLocalMean;
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const SegmentationResult alone = segment(scene.image, config);
  cv::setNumThreads(4);
  const SegmentationResult together = segment(scene.image, config);
  cv::setNumThreads(threads);
  EXPECT_EQ(together.threshold, alone.threshold);
  EXPECT_EQ(together.improved_otsu->spots, alone.improved_otsu->spots);
  EXPECT_TRUE(same(together.regions.labels, alone.regions.labels));
}

}  // namespace
}  // namespace ssjs
