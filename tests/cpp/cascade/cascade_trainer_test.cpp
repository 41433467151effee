#include "ssjs/cascade/cascade_trainer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "base/temporary_folder.hpp"
#include "cascade/speckle.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/cascade/cascade_detector.hpp"
#include "ssjs/cascade/cascade_file.hpp"
#include "ssjs/cascade/feature_table.hpp"

namespace ssjs {
namespace {

const cv::Size kWindow(12, 12);

WindowSet objects(int count, std::uint64_t seed, cv::Size window = kWindow) {
  Rng rng(seed);
  WindowSet windows(window);
  for (int i = 0; i < count; ++i) {
    cv::Mat picture = speckle(window, rng);
    draw_object(picture, {0, 0, window.width, window.height}, rng);
    windows.add(picture, i / 10);
  }
  return windows;
}

/// Seafloor with objects seen from the wrong side: an echo whose shadow lies before it.
cv::Mat seafloor(std::size_t index) {
  Rng rng(1000 + index);
  cv::Mat image = speckle({160, 120}, rng);
  for (int i = 0; i < 12; ++i) {
    const int side = 12 + static_cast<int>(rng.below(16));
    draw_object(image,
                {static_cast<int>(rng.below(160U - static_cast<unsigned>(side))),
                 static_cast<int>(rng.below(120U - static_cast<unsigned>(side))), side, side},
                rng);
  }
  cv::Mat flipped;
  cv::flip(image, flipped, 1);
  return flipped;
}

NegativeImages seafloors(std::size_t count) {
  return {count, [](std::size_t index) { return std::optional<SonarImage>({seafloor(index), {}}); }};
}

CascadeTrainingData sample_data() {
  const Rng rng(5);
  CascadeTrainingData data{objects(150, 1), objects(100, 2), WindowSet(kWindow), WindowSet(kWindow), seafloors(12), "test"};
  HaarCascade nothing;
  nothing.window = kWindow;
  data.validation_negatives = mine_negatives(nothing,
                                             {8,
                                              [](std::size_t i) {
                                                return std::optional<SonarImage>({seafloor(100 + i), {}});
                                              }},
                                             1500, 1.25, rng, "validation", 1)
                                  .windows;
  return data;
}

CascadeTrainerConfig sample_config() {
  CascadeTrainerConfig config;
  config.feature_set = FeatureSet::kSideScan;
  config.negatives_per_layer = 200;
  return config;
}

TEST(CascadeTrainerTest, C17_LayersReachTheirTargetsOnValidationWindows) {
  const CascadeTrainingData data = sample_data();
  ASSERT_EQ(data.validation_negatives.size(), 1500U);
  const TrainingPlan plan = {{0.98, 0.4, 4}, {0.96, 0.1, 8}, {0.94, 0.03, 20}};
  const HaarCascade cascade = train_cascade(data, plan, sample_config(), 2);
  ASSERT_EQ(cascade.stages.size(), 3U) << cascade.provenance.stopped_because;
  // the record is what the model does
  for (std::size_t k = 0; k < plan.size(); ++k) {
    const LayerRecord& layer = cascade.provenance.layers[k];
    const auto rate = [&](const WindowSet& windows) {
      int passed = 0;
      for (std::size_t i = 0; i < windows.size(); ++i)
        passed += judge_window(cascade, IntegralImage(windows[i]), {0, 0}).stages_passed > static_cast<int>(k) ? 1 : 0;
      return passed / static_cast<double>(windows.size());
    };
    EXPECT_EQ(layer.detection_rate, rate(data.validation_positives));
    EXPECT_EQ(layer.false_positive_rate, rate(data.validation_negatives));
    EXPECT_GE(layer.detection_rate, plan[k].detection_rate);
    EXPECT_LE(layer.features, plan[k].max_features);
    EXPECT_EQ(static_cast<int>(cascade.stages[k].weak.size()), layer.features);
  }
  EXPECT_LT(cascade.provenance.layers.back().false_positive_rate, 0.1);
}

/// AdaBoost as in the textbook: every feature, every threshold, no histogram, no weights in whole units.
std::vector<TreeNode> textbook_stage(const FeatureTable& table, int rounds, BoostType type, std::vector<std::pair<float, float>>& leaves) {
  std::vector<double> w(table.samples());
  const std::size_t p = table.positives();
  for (std::size_t i = 0; i < w.size(); ++i) w[i] = i < p ? 0.5 / static_cast<double>(p) : 0.5 / static_cast<double>(w.size() - p);
  std::vector<TreeNode> chosen;
  for (int round = 0; round < rounds; ++round) {
    double least = std::numeric_limits<double>::infinity();
    TreeNode best;
    std::pair<float, float> best_leaves;
    for (std::size_t f = 0; f < table.features(); ++f) {
      std::vector<float> v(table.samples());
      table.values(f, v.data());
      std::vector<float> sorted = v;
      std::sort(sorted.begin(), sorted.end());
      sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
      for (std::size_t k = 0; k + 1 < sorted.size(); ++k) {
        const float threshold = sorted[k] + (sorted[k + 1] - sorted[k]) / 2;
        double mass[2][2] = {{0, 0}, {0, 0}};
        for (std::size_t i = 0; i < v.size(); ++i) mass[v[i] < threshold ? 0 : 1][i < p ? 1 : 0] += w[i];
        double loss = 0;
        double leaf[2];
        if (type == BoostType::kGentle) {
          for (int side = 0; side < 2; ++side) {
            leaf[side] = (mass[side][1] - mass[side][0]) / (mass[side][1] + mass[side][0]);
            loss += mass[side][1] * std::pow(1 - leaf[side], 2) + mass[side][0] * std::pow(1 + leaf[side], 2);
          }
        } else {
          const double error = mass[0][1] + mass[1][0];
          loss = std::min(error, 1 - error);
          leaf[1] = (error <= 0.5 ? 0.5 : -0.5) * std::log((1 - loss) / loss);
          leaf[0] = -leaf[1];
        }
        if (loss < least - 1e-9) {
          least = loss;
          best = {static_cast<int>(f), threshold, 0, -1};
          best_leaves = {static_cast<float>(leaf[0]), static_cast<float>(leaf[1])};
        }
      }
    }
    std::vector<float> v(table.samples());
    table.values(static_cast<std::size_t>(best.feature), v.data());
    double sum = 0;
    for (std::size_t i = 0; i < w.size(); ++i) {
      const double answer = static_cast<double>(v[i] < best.threshold ? best_leaves.first : best_leaves.second);
      sum += w[i] *= std::exp(i < p ? -answer : answer);
    }
    for (double& weight : w) weight /= sum;
    chosen.push_back(best);
    leaves.push_back(best_leaves);
  }
  return chosen;
}

TEST(CascadeTrainerTest, C16_AStageIsThatOfTextbookAdaBoost) {
  const cv::Size window(9, 9);
  for (const BoostType type : {BoostType::kGentle, BoostType::kDiscrete}) {
    CascadeTrainingData data{objects(40, 1, window), WindowSet(window), WindowSet(window), WindowSet(window), {}, ""};
    Rng rng(3);
    for (int i = 0; i < 50; ++i) {
      cv::Mat picture = speckle(window, rng);
      if (i % 2 == 0) draw_object(picture, {0, 0, 9, 9}, rng);
      cv::Mat flipped;
      cv::flip(picture, flipped, i % 4 == 0 ? 1 : 0);
      data.negatives.add(flipped);
    }
    CascadeTrainerConfig config = sample_config();
    config.boost = type;
    config.rejecting_features = 0;
    config.max_shift = 0;
    config.negatives_per_layer = 50;
    const HaarCascade cascade = train_cascade(data, {{1, 1e-9, 4}}, config, 1);
    const auto features = enumerate_features(FeatureSet::kSideScan, window);
    const FeatureTable table(features, data.positives, data.negatives, 1U << 20U, 1);
    std::vector<std::pair<float, float>> leaves;
    const auto expected = textbook_stage(table, 4, type, leaves);
    ASSERT_EQ(cascade.stages.at(0).weak.size(), 4U);
    for (std::size_t k = 0; k < expected.size(); ++k) {
      const WeakClassifier& stump = cascade.stages[0].weak[k];
      EXPECT_EQ(cascade.features[static_cast<std::size_t>(stump.nodes[0].feature)], features[static_cast<std::size_t>(expected[k].feature)])
          << "stump " << k;
      EXPECT_FLOAT_EQ(stump.nodes[0].threshold, expected[k].threshold);
      EXPECT_NEAR(stump.leaves[0], leaves[k].first, 1e-5);
      EXPECT_NEAR(stump.leaves[1], leaves[k].second, 1e-5);
    }
  }
}

TEST(CascadeTrainerTest, SameBytesTwiceOnAnyNumberOfThreadsWithAnyMemory) {
  const CascadeTrainingData data = sample_data();
  const TrainingPlan plan = {{0.98, 0.4, 3}, {0.96, 0.1, 5}};
  CascadeTrainerConfig config = sample_config();
  const std::string expected = to_json(train_cascade(data, plan, config, 1));
  EXPECT_EQ(to_json(train_cascade(data, plan, config, 1)), expected);
  EXPECT_EQ(to_json(train_cascade(data, plan, config, 2)), expected);
  EXPECT_EQ(to_json(train_cascade(data, plan, config, 5)), expected);
  config.memory_mb = 1;
  EXPECT_EQ(to_json(train_cascade(data, plan, config, 2)), expected);
}

class CheckpointTest : public testing::Test {
 protected:
  TemporaryFolder folder_;
  std::string path_ = folder_ / "checkpoint.json";
  CascadeTrainingData data_ = sample_data();
  TrainingPlan plan_ = {{0.98, 0.4, 3}, {0.96, 0.1, 5}, {0.94, 0.05, 8}};
};

TEST_F(CheckpointTest, ABrokenTrainingCarriesOnToTheSameBytes) {
  const std::string expected = to_json(train_cascade(data_, plan_, sample_config(), 2));
  for (int stop_in_layer = 1; stop_in_layer <= 3; ++stop_in_layer) {
    std::filesystem::remove(path_);
    const auto stop = [&](const TrainingProgress& progress) { return progress.layer < stop_in_layer || progress.doing != "boosting"; };
    EXPECT_THROW((void)train_cascade(data_, plan_, sample_config(), 2, path_, true, stop), Cancelled);
    EXPECT_EQ(std::filesystem::exists(path_), stop_in_layer > 1);
    EXPECT_EQ(to_json(train_cascade(data_, plan_, sample_config(), 1, path_, true)), expected);
    EXPECT_EQ(to_json(load_cascade(path_)), expected);
    EXPECT_EQ(to_json(train_cascade(data_, plan_, sample_config(), 1, path_, true)), expected);  // nothing left to do
  }
}

TEST_F(CheckpointTest, AnotherTrainingIsNotCarriedOn) {
  (void)train_cascade(data_, {plan_[0]}, sample_config(), 1, path_);
  CascadeTrainerConfig other = sample_config();
  other.seed = 2;
  try {
    (void)train_cascade(data_, {plan_[0]}, other, 1, path_, true);
    FAIL();
  } catch (const FileError& error) {
    EXPECT_NE(std::string(error.what()).find("seed = 1, not 2"), std::string::npos) << error.what();
  }
  data_.positives.add(data_.positives[0], 0);
  EXPECT_THROW((void)train_cascade(data_, {plan_[0]}, sample_config(), 1, path_, true), FileError);
}

TEST(CascadeTrainerTest, C18_StopsAndSaysSoWhenALayerNoLongerHelps) {
  // Objects and the rest drawn alike: nothing can be learnt that holds for other windows.
  Rng rng(1);
  const auto noise = [&](int count) {
    WindowSet windows(kWindow);
    for (int i = 0; i < count; ++i) windows.add(speckle(kWindow, rng));
    return windows;
  };
  const CascadeTrainingData data{noise(100), noise(200), noise(200), noise(400), {}, ""};
  const TrainingPlan plan(6, {0.99, 0.01, 3});
  const HaarCascade cascade = train_cascade(data, plan, sample_config(), 1);
  EXPECT_LT(cascade.stages.size(), 6U);
  EXPECT_NE(cascade.provenance.stopped_because.find("does not help"), std::string::npos) << cascade.provenance.stopped_because;
}

TEST(CascadeTrainerTest, EqualObjectsAndPicturesThatCannotBeReadDoNoHarm) {
  WindowSet same(kWindow);
  const WindowSet one = objects(1, 1);
  for (int i = 0; i < 20; ++i) same.add(one[0]);
  NegativeImages images = seafloors(6);
  const auto read = images.read;
  images.read = [read](std::size_t index) { return index == 3 ? std::nullopt : read(index); };
  const CascadeTrainingData data{same, WindowSet(kWindow), WindowSet(kWindow), WindowSet(kWindow), images, ""};
  const HaarCascade cascade = train_cascade(data, {{1, 0.5, 2}}, sample_config(), 1);
  EXPECT_EQ(judge_window(cascade, IntegralImage(one[0]), {0, 0}).stages_passed, 1);
  HaarCascade nothing;
  nothing.window = kWindow;
  EXPECT_EQ(mine_negatives(nothing, images, 50, 1.25, Rng(1), "test", 1).images_missing, 1U);
}

TEST(CascadeTrainerTest, C21_FewStumpsRejectMoreThanBoostingDoesAtTheSameDetectionRate) {
  const CascadeTrainingData data = sample_data();
  int better = 0;
  for (const double detection_rate : {0.99, 0.97, 0.94, 0.9})
    for (const int features : {1, 3}) {
      const TrainingPlan plan = {{detection_rate, 1e-3, features}};
      CascadeTrainerConfig config = sample_config();
      const LayerRecord rejecting = train_cascade(data, plan, config, 2).provenance.layers.at(0);
      config.rejecting_features = 0;
      const LayerRecord boosted = train_cascade(data, plan, config, 2).provenance.layers.at(0);
      EXPECT_GE(rejecting.detection_rate, detection_rate);
      EXPECT_LE(rejecting.false_positive_rate, boosted.false_positive_rate);
      better += rejecting.false_positive_rate < boosted.false_positive_rate ? 1 : 0;
    }
  EXPECT_GE(better, 2);
}

TEST(CascadeTrainerTest, IdenticalObjectsAreLearntAndFound) {
  CascadeTrainingData data{WindowSet(kWindow), WindowSet(kWindow), WindowSet(kWindow), WindowSet(kWindow), seafloors(4), "test"};
  const WindowSet one = objects(1, 3);
  for (int i = 0; i < 40; ++i) data.positives.add(one[0]);
  for (const int rejecting_features : {0, 8}) {
    CascadeTrainerConfig config = sample_config();
    config.rejecting_features = rejecting_features;
    const HaarCascade cascade = train_cascade(data, {{1, 0.01, 2}, {1, 1e-4, 3}}, config, 2);
    EXPECT_GE(cascade.stages.size(), 1U);
    EXPECT_EQ(judge_window(cascade, IntegralImage(one[0]), {0, 0}).stages_passed, static_cast<int>(cascade.stages.size()));
  }
}

TEST(CascadeTrainerTest, OfTheWindowsGivenNoMoreThanWantedTrainALayer) {
  CascadeTrainingData data = sample_data();
  data.negatives = data.validation_negatives;
  CascadeTrainerConfig config = sample_config();
  config.negatives_per_layer = 333;
  EXPECT_EQ(train_cascade(data, {{0.98, 0.4, 3}}, config, 2).provenance.layers.at(0).negatives, 333);
}

TEST(CascadeTrainerTest, PicturesWithoutFurtherFalseAlarmsEndTheTraining) {
  CascadeTrainingData data{objects(60, 1), WindowSet(kWindow), WindowSet(kWindow), WindowSet(kWindow), {}, ""};
  data.negative_images = {2, [](std::size_t) { return std::optional<SonarImage>({seafloor(1)(cv::Rect(0, 0, 30, 30)), {}}); }};
  CascadeTrainerConfig config = sample_config();
  config.negatives_per_layer = 300;
  const HaarCascade cascade = train_cascade(data, TrainingPlan(5, {0.9, 1e-6, 6}), config, 1);
  EXPECT_NE(cascade.provenance.stopped_because.find("used up"), std::string::npos) << cascade.provenance.stopped_because;
}

TEST(CascadeTrainerTest, ContradictionsAreRefused) {
  const CascadeTrainingData data = sample_data();
  EXPECT_THROW((void)train_cascade(data, {}, sample_config(), 1), InvalidArgument);
  EXPECT_THROW((void)train_cascade(data, {{0.9, 0.5, 0}}, sample_config(), 1), InvalidArgument);
  EXPECT_THROW((void)train_cascade(data, {{0.9, 0.5, 1}, {0.95, 0.5, 1}}, sample_config(), 1), InvalidArgument);
  CascadeTrainingData empty{WindowSet(kWindow), WindowSet(kWindow), WindowSet(kWindow), WindowSet(kWindow), {}, ""};
  EXPECT_THROW((void)train_cascade(empty, thesis_plan(), sample_config(), 1), InvalidArgument);
  empty.positives = objects(3, 1);
  EXPECT_THROW((void)train_cascade(empty, thesis_plan(), sample_config(), 1), InvalidArgument);
  EXPECT_THROW((void)train_cascade(data, thesis_plan(), sample_config(), 0), InvalidArgument);
}

TEST(TrainingPlanTest, TheThesisPlanIsItsTable) {
  const TrainingPlan plan = thesis_plan();
  ASSERT_EQ(plan.size(), 7U);
  EXPECT_NO_THROW(check_plan(plan));
  EXPECT_EQ(plan[0].max_features, 1);
  EXPECT_EQ(plan[6].false_positive_rate, 0.0005);
  EXPECT_NEAR(uniform_plan(5, 0.995, 0.5, 100)[4].false_positive_rate, 0.03125, 1e-12);
}

}  // namespace
}  // namespace ssjs
