#include "ssjs/cascade/contour_reference.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "ssjs/base/error.hpp"
#include "ssjs/base/random.hpp"

namespace ssjs {
namespace {

/// Spectra that differ in their first harmonic alone.
std::vector<ContourSpectrum> with_first(const std::vector<double>& values) {
  std::vector<ContourSpectrum> spectra;
  for (const double value : values) spectra.push_back({value});
  return spectra;
}

std::vector<ContourSpectrum> normal_spectra(int count, Rng& rng, double shift = 0) {
  std::vector<ContourSpectrum> spectra(static_cast<std::size_t>(count));
  for (ContourSpectrum& spectrum : spectra)
    for (std::size_t h = 0; h < kContourHarmonics; ++h) spectrum[h] = 0.1 + (shift + rng.normal()) * 0.01 * (1 + static_cast<double>(h));
  return spectra;
}

TEST(ContourReferenceTest, C20_DistanceByHand) {
  // mean 0.2, deviation 0.1 in the first harmonic; the others do not vary and get the least deviation, 0.002
  const ContourReference reference = learn_contours(with_first({0.1, 0.2, 0.3}));
  EXPECT_NEAR(reference.mean[0], 0.2, 1e-15);
  EXPECT_NEAR(reference.deviation[0], 0.1, 1e-15);
  EXPECT_EQ(reference.deviation[5], 0.002);
  ContourSpectrum other{};
  other[0] = 0.5;                                                     // 3 deviations
  other[1] = 0.008;                                                   // 4 deviations
  EXPECT_NEAR(contour_distance(other, reference), 5.0 / 4.0, 1e-12);  // sqrt((9 + 16) / 16)
}

TEST(ContourReferenceTest, C22_EachObjectIsMeasuredWithoutItself) {
  Rng rng(5);
  const std::vector<ContourSpectrum> objects = normal_spectra(9, rng);
  std::vector<double> expected;
  for (std::size_t left_out = 0; left_out < objects.size(); ++left_out) {
    std::vector<ContourSpectrum> others = objects;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(left_out));
    expected.push_back(contour_distance(objects[left_out], learn_contours(others)));
  }
  std::sort(expected.begin(), expected.end());
  const ContourReference reference = learn_contours(objects);
  ASSERT_EQ(reference.distances.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(reference.distances[i], expected[i], 1e-9 * expected[i]);
}

TEST(ContourReferenceTest, C23_ScoreByHand) {
  ContourReference reference;
  reference.distances = {0.5, 1, 1, 2};
  EXPECT_EQ(contour_score(0, reference), 1);          // all four are at least so unlike
  EXPECT_EQ(contour_score(1, reference), 4.0 / 5.0);  // three of four, and itself
  EXPECT_EQ(contour_score(1.5, reference), 2.0 / 5.0);
  EXPECT_EQ(contour_score(3, reference), 1.0 / 5.0);
}

TEST(ContourReferenceTest, C23_OfObjectsOfTheKindAPartPScoresPOrLess) {
  Rng rng(8);
  const ContourReference reference = learn_contours(normal_spectra(400, rng));
  int refused = 0;
  int others_refused = 0;
  constexpr int kTests = 2000;
  for (const ContourSpectrum& object : normal_spectra(kTests, rng))
    refused += contour_score(contour_distance(object, reference), reference) <= 0.1 ? 1 : 0;
  for (const ContourSpectrum& object : normal_spectra(kTests, rng, 2))
    others_refused += contour_score(contour_distance(object, reference), reference) <= 0.1 ? 1 : 0;
  // 0.1 of 2000 has a deviation of 13, the quantile of 400 known ones adds one of 30: three of 33 are 100
  EXPECT_NEAR(refused, 0.1 * kTests, 100);
  EXPECT_GT(others_refused, 0.95 * kTests);
}

TEST(ContourReferenceTest, ContradictionsAreNamed) {
  EXPECT_THROW((void)learn_contours(with_first({0.1, 0.2})), InvalidArgument);
  const ContourReference good = learn_contours(with_first({0.1, 0.2, 0.3}));
  EXPECT_NO_THROW(check_contour_reference(good));
  ContourReference bad = good;
  bad.deviation[3] = 0;
  EXPECT_THROW(check_contour_reference(bad), InvalidArgument);
  bad = good;
  bad.mean[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(check_contour_reference(bad), InvalidArgument);
  bad = good;
  bad.distances = {2, 1};
  EXPECT_THROW(check_contour_reference(bad), InvalidArgument);
  bad.distances.clear();
  EXPECT_THROW(check_contour_reference(bad), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
