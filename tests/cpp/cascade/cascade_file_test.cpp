#include "ssjs/cascade/cascade_file.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>

#include "base/temporary_folder.hpp"
#include "cascade/random_cascade.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/cascade/cascade_xml.hpp"

namespace ssjs {
namespace {

HaarCascade sample_cascade() {
  Rng rng(9);
  HaarCascade cascade = random_cascade({12, 10}, FeatureSet::kAll, 3, 3, rng);
  cascade.provenance = {"ssjs 0.1.0",
                        {{"seed", "7"}, {"positives", "0123456789abcdef"}},
                        {{2, 0.995, 0.25, 0.99, 0.5, 1000, 123456.0}},
                        "the plan is fulfilled"};
  std::vector<ContourSpectrum> spectra(5);
  for (ContourSpectrum& spectrum : spectra)
    for (double& harmonic : spectrum) harmonic = rng.uniform(0, 0.3);
  cascade.contour = learn_contours(spectra);
  return cascade;
}

class CascadeFileTest : public testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const { return folder_ / name; }

 private:
  TemporaryFolder folder_;
};

TEST_F(CascadeFileTest, OwnFormComesBackWhole) {
  const HaarCascade cascade = sample_cascade();
  save_cascade(cascade, path("model.json"));
  EXPECT_TRUE(load_cascade(path("model.json")) == cascade);
  EXPECT_FALSE(std::filesystem::exists(path("model.json.part")));
}

TEST_F(CascadeFileTest, OpenCvFormComesBackBitForBitButForProvenanceAndContour) {
  HaarCascade cascade = sample_cascade();
  save_cascade(cascade, path("model.xml"));
  cascade.provenance = {};
  cascade.contour.reset();
  EXPECT_TRUE(load_cascade(path("model.xml")) == cascade);
}

TEST_F(CascadeFileTest, ContoursThatContradictThemselvesAreRefused) {
  const std::string good = to_json(sample_cascade());
  const auto read_with = [&](const std::string& from, const std::string& to) {
    std::string changed = good;
    changed.replace(changed.find(from, changed.find("\"contour\"")), from.size(), to);
    return from_json(changed, "model.json");
  };
  EXPECT_THROW((void)read_with("\"mean\": [", "\"mean\": [0.5,"), FileError);              // 17 harmonics
  EXPECT_THROW((void)read_with("\"deviation\"", "\"deviations\""), FileError);             // none
  EXPECT_THROW((void)read_with("\"distances\": [", "\"distances\": [1e300,"), FileError);  // not rising
  HaarCascade without = sample_cascade();
  without.contour.reset();
  EXPECT_TRUE(from_json(to_json(without), "model.json") == without);
}

TEST_F(CascadeFileTest, AnotherVersionIsRefusedByName) {
  std::string json = to_json(sample_cascade());
  const std::string known = "\"version\": 1";
  json.replace(json.find(known), known.size(), "\"version\": 2");
  try {
    (void)from_json(json, "model.json");
    FAIL();
  } catch (const FileError& error) {
    EXPECT_NE(std::string(error.what()).find("version = 2"), std::string::npos) << error.what();
  }
}

TEST_F(CascadeFileTest, NumbersBeyondDoublePrecisionAreRefused) {
  std::string json = to_json(sample_cascade());
  const std::string known = "\"version\": 1";
  json.replace(json.find(known), known.size(), "\"version\": 1e400");
  EXPECT_THROW((void)from_json(json, "model.json"), FileError);
}

/// Cut off anywhere, or with any one byte changed, a file is read as a valid model or refused: nothing else happens.
void expect_read_or_refused(const std::string& content, const std::function<HaarCascade(const std::string&)>& read, std::size_t stride) {
  for (std::size_t length = 0; length + 2 < content.size(); ++length)
    EXPECT_THROW((void)read(content.substr(0, length)), FileError) << "length " << length;
  for (std::size_t i = 0; i < content.size(); i += stride)
    for (const char byte : {'\0', '<', '9', '-', 'x', '\xff'}) {
      std::string changed = content;
      changed[i] = byte;
      try {
        check_cascade(read(changed));
      } catch (const FileError&) {
      }
    }
}

TEST_F(CascadeFileTest, DamagedFilesAreRefusedAtEveryByte) {
  Rng rng(2);
  HaarCascade cascade = random_cascade({8, 8}, FeatureSet::kBasic, 1, 2, rng);
  cascade.contour = learn_contours({{0.1}, {0.2}, {0.4}});
  const auto json = [](const std::string& text) { return from_json(text, "model.json"); };
  const auto xml = [](const std::string& text) { return from_opencv_xml(text, "model.xml"); };
  expect_read_or_refused(to_json(cascade), json, 7);
  expect_read_or_refused(to_opencv_xml(cascade), xml, 7);
}

std::string complaint(const std::string& xml) {
  try {
    (void)from_opencv_xml(xml, "model.xml");
  } catch (const FileError& error) {
    return error.what();
  }
  return "";
}

TEST_F(CascadeFileTest, ComplaintsNameThePlaceAndTheMatter) {
  Rng rng(2);
  const std::string good = to_opencv_xml(random_cascade({8, 8}, FeatureSet::kBasic, 1, 1, rng));
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string changed = good;
    changed.replace(changed.find(from), from.size(), to);
    return complaint(changed);
  };
  EXPECT_NE(with("HAAR", "LBP").find("only HAAR is read"), std::string::npos);
  EXPECT_NE(with("<width>8", "<width>5").find("must lie in the window"), std::string::npos);
  EXPECT_NE(with("<stageType>BOOST</stageType>", "").find("older Haar form"), std::string::npos);
  EXPECT_NE(with("<width>8", "<width>eight").find("'eight' in <width> is no number"), std::string::npos);
  EXPECT_NE(complaint("<?xml version=\"1.0\"?><!DOCTYPE a [<!ENTITY b \"c\">]><opencv_storage>&b;</opencv_storage>").find("holds nothing"),
            std::string::npos);
}

TEST_F(CascadeFileTest, TreesThatDoNotEndAreRefused) {
  HaarCascade cascade = sample_cascade();
  WeakClassifier& tree = cascade.stages[0].weak[0];
  tree.nodes = {{0, 0, 1, 0}, {0, 0, 1, -2}};  // the second node leads to itself
  tree.leaves = {1, 2, 3};
  EXPECT_THROW(check_cascade(cascade), InvalidArgument);
  tree.nodes[1].left = -1;
  EXPECT_NO_THROW(check_cascade(cascade));
  tree.nodes[1].left = -3;  // no such leaf
  EXPECT_THROW(check_cascade(cascade), InvalidArgument);
}

TEST_F(CascadeFileTest, MissingFilesAndFoldersAreNamed) {
  EXPECT_THROW((void)load_cascade(path("nothing.json")), FileError);
  EXPECT_THROW((void)load_cascade(path("")), FileError);
  EXPECT_THROW(save_cascade(sample_cascade(), path("no/folder/model.json")), FileError);
}

}  // namespace
}  // namespace ssjs
