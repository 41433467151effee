// Speed and memory of the thresholds and of the whole chain.
#include <cstdio>
#include <functional>
#include <map>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "../cpu_clock.hpp"
#include "../quantiles.hpp"
#include "ssjs/imaging/contours.hpp"
#include "ssjs/imaging/histogram.hpp"
#include "ssjs/imaging/segmentation.hpp"
#include "ssjs/imaging/sonar_scene.hpp"
#include "study.hpp"

namespace ssjs::benchmarks {
namespace {

struct Work {
  std::string name;
  std::function<void()> run;
};

/// Median processor times, ms, each piece of work once a round.
std::map<std::string, double> medians_ms(const std::vector<Work>& works, int rounds) {
  std::map<std::string, std::vector<double>> times_ms;
  for (const Work& work : works) work.run();
  for (int round = 0; round < rounds; ++round) {
    for (const Work& work : works) times_ms[work.name].push_back(1e3 * cpu_time_s(work.run));
  }
  std::map<std::string, double> medians;
  for (const auto& [name, all] : times_ms) medians[name] = median(all);
  return medians;
}

void print_times(const char* name, const SpottedSceneConfig& scene_config, SegmentationPreset preset, bool with_spots, int rounds) {
  SpottedSceneConfig spotted = scene_config;
  if (!with_spots) spotted.spots = 0;
  spotted.fan = false;  // OpenCV's pieces know of no invalid pixels
  const cv::Mat raw = simulate_spotted_scene(spotted, Rng(1)).image.intensity;
  SegmentationConfig config = segmentation_preset(preset);
  config.improved_otsu.canny_high = 0.33;
  const SonarImage image{power_law({raw, {}}, config.power_law), {}};
  cv::Mat dx, dy, magnitude, binary, edges;
  cv::Sobel(image.intensity, dx, CV_32F, 1, 0);
  cv::Sobel(image.intensity, dy, CV_32F, 0, 1);
  cv::magnitude(dx, dy, magnitude);
  double largest = 0;
  cv::minMaxLoc(magnitude, nullptr, &largest);
  const double high = *config.improved_otsu.canny_high * largest;
  std::vector<std::vector<cv::Point>> contours;
  const auto ms = medians_ms({{"cv otsu", [&] { cv::threshold(image.intensity, binary, 0, 255, cv::THRESH_OTSU); }},
                              {"cv canny", [&] { cv::Canny(image.intensity, edges, 0.4 * high, high, 3, true); }},
                              {"cv contours", [&] { cv::findContours(edges, contours, cv::RETR_LIST, cv::CHAIN_APPROX_NONE); }},
                              {"cv outer", [&] { cv::findContours(edges, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE); }},
                              {"otsu", [&] { (void)otsu_threshold(histogram(image)); }},
                              {"iterative", [&] { (void)iterative_threshold(histogram(image)); }},
                              {"entropy", [&] { (void)maximum_entropy_threshold(histogram(image)); }},
                              {"local", [&] { (void)local_foreground(image, config.local); }},
                              {"improved", [&] { (void)improved_otsu(image, config.improved_otsu); }},
                              {"chain",
                               [&] {
                                 (void)segment({raw, {}}, config);
                               }}},
                             rounds);
  const double sum = ms.at("cv otsu") + ms.at("cv canny") + ms.at("cv contours");
  const double outer_sum = ms.at("cv otsu") + ms.at("cv canny") + ms.at("cv outer");
  const auto found = improved_otsu(image, config.improved_otsu);
  std::printf(
      "| %s | %lld%s | %.2f | %.2f | %.2f (%.2f) | %.2f (%.2f) | %.2f | %.2f | %.2f | %.2f | %.2f | %.2f | %.2f (%.2f) | %.2f (%.2f) |\n",
      name, static_cast<long long>(found->spots), found->second_pass_fired ? ", fired" : "", ms.at("cv otsu"), ms.at("cv canny"),
      ms.at("cv contours"), ms.at("cv outer"), sum, outer_sum, ms.at("otsu"), ms.at("iterative"), ms.at("entropy"), ms.at("local"),
      ms.at("improved"), ms.at("chain"), ms.at("improved") / sum, ms.at("improved") / outer_sum, ms.at("chain") / sum,
      ms.at("chain") / outer_sum);
}

}  // namespace

void study_times(const SegmentationStudyOptions& options) {
  std::printf(
      "Median processor ms of %d interleaved rounds, one thread. OpenCV's pieces on the picture after the power law; contours RETR_LIST\n"
      "(in brackets RETR_EXTERNAL), CHAIN_APPROX_NONE. The chain goes from the raw picture to the objects.\n\n",
      options.rounds);
  std::printf(
      "| picture | N_a | cv Otsu | cv Canny | cv findContours | sum | Otsu | iterative | entropy | local | improved | chain | improved / "
      "sum | chain / sum |\n");
  std::printf("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const bool spots : {true, false}) {
    print_times(spots ? "417x228" : "417x228, no spots", branch_scene(), SegmentationPreset::kSideScanLow, spots, options.rounds);
    print_times(spots ? "800x800" : "800x800, no spots", ship_scene(), SegmentationPreset::kSideScanHigh, spots, options.rounds);
    print_times(spots ? "1920x932" : "1920x932, no spots", body_scene(), SegmentationPreset::kForwardLooking, spots, options.rounds);
  }
}

void study_memory(const SegmentationStudyOptions& options) {
  const double pixels = static_cast<double>(options.side_px) * options.side_px;
  cv::Mat image(options.side_px, options.side_px, CV_8U);
  {
    SpottedSceneConfig tile_config = ship_scene();
    const cv::Mat tile = simulate_spotted_scene(tile_config, Rng(1)).image.intensity;
    for (int r = 0; r < image.rows; ++r) {
      for (int c = 0; c < image.cols; ++c) image.at<unsigned char>(r, c) = tile.at<unsigned char>(r % tile.rows, c % tile.cols);
    }
  }
  const double before_mb = peak_memory_mb();
  ImprovedOtsuConfig config;
  const auto found = improved_otsu({image, {}}, config);
  const double threshold_mb = peak_memory_mb();
  std::printf("%d x %d: N_a %lld, limit %.0f, T %d, T* %d\n", image.cols, image.rows, static_cast<long long>(found->spots),
              found->spot_limit, found->first_threshold, found->threshold);
  std::printf("improved Otsu: %.2f bytes a pixel beyond the picture\n", 1e6 * (threshold_mb - before_mb) / pixels);
  const double begin = process_cpu_s();
  const SegmentationResult result = segment({image, {}}, {});
  std::printf("whole chain:   %.2f bytes a pixel, of which the result keeps 5 (mask and labels); %zu regions, %.1f s\n",
              1e6 * (peak_memory_mb() - before_mb) / pixels, result.regions.regions.size(), process_cpu_s() - begin);
}

}  // namespace ssjs::benchmarks
