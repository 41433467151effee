#include "ssjs/cascade/negative_miner.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "ssjs/cascade/cascade_detector.hpp"
#include "ssjs/cascade/parallel_blocks.hpp"

namespace ssjs {
namespace {

constexpr std::size_t kImagesAtOnce = 16;  // in memory, and the unit of parallel work: fixed, so that results are, too
constexpr double kShareAtFirst = 1.5;      // of a fair share for each picture

struct Candidate {
  std::size_t level;
  cv::Point top_left;
};

/// What one picture contributes.
struct Offer {
  WindowSet windows;
  double looked_at = 0;
  double passed = 0;
};

void shuffle(std::vector<Candidate>& candidates, Rng& rng) {
  for (std::size_t i = candidates.size(); i > 1; --i) std::swap(candidates[i - 1], candidates[rng.below(i)]);
}

/// Candidates [from, to) of those that pass, in an order drawn for the picture.
Offer passed_windows(const CascadeDetector& detector, const SonarImage& image, std::size_t from, std::size_t to, int recording, Rng rng) {
  const cv::Size window = detector.cascade().window;
  const std::vector<LevelHits> levels = detector.scan(image);
  Offer offer{WindowSet(window)};
  std::vector<Candidate> candidates;
  for (std::size_t l = 0; l < levels.size(); ++l) {
    for (const auto& hit : levels[l].hits) candidates.push_back({l, hit.top_left});
    offer.looked_at += levels[l].windows;
  }
  offer.passed = static_cast<double>(candidates.size());
  shuffle(candidates, rng);
  for (std::size_t c = from; c < std::min(to, candidates.size()); ++c)
    offer.windows.add(levels[candidates[c].level].picture(cv::Rect(candidates[c].top_left, window)), recording);
  return offer;
}

/// Windows at random places, their sizes evenly spread on a logarithmic scale; none that is flat or holds an invalid pixel.
Offer random_windows(cv::Size window, const SonarImage& image, std::size_t from, std::size_t to, int recording, Rng rng) {
  const SonarImage grey = in_8_bits(image);
  const cv::Size size = grey.intensity.size();
  Offer offer{WindowSet(window)};
  const double largest = std::min(static_cast<double>(size.width) / window.width, static_cast<double>(size.height) / window.height);
  if (largest < 1) return offer;
  for (std::size_t draw = 0; draw < to; ++draw) {
    const double scale = std::pow(largest, rng.uniform());
    const cv::Size box_size(std::min(size.width, cvRound(window.width * scale)), std::min(size.height, cvRound(window.height * scale)));
    const cv::Point place(static_cast<int>(rng.below(static_cast<std::uint64_t>(size.width - box_size.width) + 1)),
                          static_cast<int>(rng.below(static_cast<std::uint64_t>(size.height - box_size.height) + 1)));
    const cv::Rect box(place, box_size);
    if (draw < from) continue;
    offer.looked_at += 1;
    if (!grey.valid.empty() && cv::countNonZero(grey.valid(box)) < box.area()) continue;
    cv::Mat picture;
    cv::resize(grey.intensity(box), picture, window, 0, 0, cv::INTER_LINEAR_EXACT);
    if (!normalisation(IntegralImage(picture), {0, 0}, window)) continue;
    offer.passed += 1;
    offer.windows.add(picture, recording);
  }
  return offer;
}

}  // namespace

MinedNegatives mine_negatives(const HaarCascade& cascade, const NegativeImages& images, std::size_t wanted, double scale_factor,
                              const Rng& rng, const std::string& name, int threads) {
  MinedNegatives mined{WindowSet(cascade.window), 0, 0, 0};
  if (images.count == 0 || wanted == 0) return mined;
  CascadeDetectorConfig config;
  config.scale_factor = scale_factor;
  std::optional<CascadeDetector> detector;
  if (!cascade.stages.empty()) detector.emplace(cascade, config);

  std::vector<std::size_t> order(images.count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  Rng draw = rng.stream(name);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[draw.below(i)]);

  const auto fair_share =
      static_cast<std::size_t>(std::ceil(kShareAtFirst * static_cast<double>(wanted) / static_cast<double>(images.count)));
  for (const bool first_pass : {true, false}) {
    for (std::size_t begin = 0; begin < order.size() && mined.windows.size() < wanted; begin += kImagesAtOnce) {
      const std::size_t end = std::min(order.size(), begin + kImagesAtOnce);
      std::vector<std::optional<SonarImage>> pictures;
      for (std::size_t k = begin; k < end; ++k) pictures.push_back(images.read(order[k]));
      const std::size_t from = first_pass ? 0 : fair_share;
      const std::size_t to = first_pass ? fair_share : fair_share + wanted;
      std::vector<Offer> offers(pictures.size(), Offer{WindowSet(cascade.window)});
      parallel_blocks(pictures.size(), threads, [&](std::size_t k) {
        if (!pictures[k]) return;
        const std::size_t index = order[begin + k];
        const Rng own = rng.stream(name + ", image " + std::to_string(index));
        const int recording = static_cast<int>(index);
        offers[k] = detector ? passed_windows(*detector, *pictures[k], from, to, recording, own)
                             : random_windows(cascade.window, *pictures[k], from, to, recording, own);
      });
      for (std::size_t k = 0; k < offers.size(); ++k) {
        const Offer& offer = offers[k];
        if (first_pass) {
          mined.windows_looked_at += offer.looked_at;
          mined.windows_passed += offer.passed;
          mined.images_missing += pictures[k] ? 0 : 1;
        }
        for (std::size_t i = 0; i < offer.windows.size() && mined.windows.size() < wanted; ++i)
          mined.windows.add(offer.windows[i], offer.windows.recording(i));
      }
    }
  }
  return mined;
}

}  // namespace ssjs
