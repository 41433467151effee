#include "ssjs/cascade/contour_reference.hpp"

#include <algorithm>
#include <cmath>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

constexpr double kLeastDeviation = 0.002;  // of a harmonic, part of the mean distance: what the pixel grid alone does to it

double deviation_of(double squares, double count) { return std::max(kLeastDeviation, std::sqrt(std::max(0.0, squares) / (count - 1))); }

}  // namespace

ContourReference learn_contours(const std::vector<ContourSpectrum>& objects) {
  if (objects.size() < 3) throw InvalidArgument("contours", static_cast<double>(objects.size()), "at least three are needed");
  const auto count = static_cast<double>(objects.size());
  ContourReference reference;
  ContourSpectrum squares{};  // of the distances from the mean, summed
  for (std::size_t h = 0; h < kContourHarmonics; ++h) {
    for (const ContourSpectrum& object : objects) reference.mean[h] += object[h] / count;
    for (const ContourSpectrum& object : objects) squares[h] += std::pow(object[h] - reference.mean[h], 2);
    reference.deviation[h] = deviation_of(squares[h], count);
  }
  for (const ContourSpectrum& object : objects) {  // (C-22)
    double sum = 0;
    for (std::size_t h = 0; h < kContourHarmonics; ++h) {
      const double from_all = object[h] - reference.mean[h];
      const double from_others = from_all * count / (count - 1);
      const double deviation_of_others = deviation_of(squares[h] - from_all * from_others, count - 1);
      sum += std::pow(from_others / deviation_of_others, 2);
    }
    reference.distances.push_back(std::sqrt(sum / kContourHarmonics));
  }
  std::sort(reference.distances.begin(), reference.distances.end());
  return reference;
}

void check_contour_reference(const ContourReference& reference) {
  for (std::size_t h = 0; h < kContourHarmonics; ++h) {
    if (!std::isfinite(reference.mean[h])) throw InvalidArgument("contour.mean", reference.mean[h], "must be finite");
    if (!(reference.deviation[h] > 0 && std::isfinite(reference.deviation[h])))
      throw InvalidArgument("contour.deviation", reference.deviation[h], "must be positive and finite");
  }
  if (reference.distances.empty()) throw InvalidArgument("contour.distances", "none", "must be at least one");
  double last = 0;
  for (const double distance : reference.distances) {
    if (!(distance >= last && std::isfinite(distance)))
      throw InvalidArgument("contour.distances", distance, "must be finite, not negative, and none less than the one before it");
    last = distance;
  }
}

double contour_distance(const ContourSpectrum& spectrum, const ContourReference& reference) {
  double squares = 0;
  for (std::size_t h = 0; h < kContourHarmonics; ++h) squares += std::pow((spectrum[h] - reference.mean[h]) / reference.deviation[h], 2);
  return std::sqrt(squares / kContourHarmonics);
}

double contour_score(double distance, const ContourReference& reference) {
  const auto at_least = reference.distances.end() - std::lower_bound(reference.distances.begin(), reference.distances.end(), distance);
  return static_cast<double>(at_least + 1) / static_cast<double>(reference.distances.size() + 1);
}

}  // namespace ssjs
