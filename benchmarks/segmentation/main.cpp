// ssjs_segmentation_study: how fast and how well sonar pictures are segmented. See ../README.md.
#include <charconv>
#include <cstdio>
#include <exception>
#include <map>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>

#include "study.hpp"

namespace {

using ssjs::benchmarks::SegmentationStudyOptions;

constexpr const char* kUsage =
    "usage: ssjs_segmentation_study STUDY [--rounds N] [--seeds N] [--side-px N]\n"
    "  times   thresholds and the chain against OpenCV's pieces  --rounds\n"
    "  memory  largest memory a pixel of the picture             --side-px\n"
    "  scenes  where the improved threshold is the better one    --seeds\n"
    "  gain    uneven gain at low contrast                       --seeds\n";

SegmentationStudyOptions parse(int count, char** arguments) {
  SegmentationStudyOptions options;
  const std::map<std::string, int*> numbers{{"--rounds", &options.rounds}, {"--seeds", &options.seeds}, {"--side-px", &options.side_px}};
  for (int i = 2; i < count; i += 2) {
    const auto number = numbers.find(arguments[i]);
    if (number == numbers.end() || i + 1 == count) throw std::invalid_argument(std::string(arguments[i]) + ": unknown, or without a value");
    const std::string text = arguments[i + 1];
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *number->second);
    if (error != std::errc() || end != text.data() + text.size() || *number->second < 1)
      throw std::invalid_argument(number->first + " " + text + ": must be a whole number from 1 on");
  }
  return options;
}

}  // namespace

int main(int count, char** arguments) {
  const std::map<std::string, void (*)(const SegmentationStudyOptions&)> studies{{"times", ssjs::benchmarks::study_times},
                                                                                 {"memory", ssjs::benchmarks::study_memory},
                                                                                 {"scenes", ssjs::benchmarks::study_scenes},
                                                                                 {"gain", ssjs::benchmarks::study_gain}};
  const auto study = studies.find(count > 1 ? arguments[1] : "");
  if (study == studies.end()) {
    std::fputs(kUsage, stderr);
    return 2;
  }
  cv::setNumThreads(1);
  try {
    study->second(parse(count, arguments));
  } catch (const std::invalid_argument& error) {
    std::fprintf(stderr, "ssjs_segmentation_study: %s\n%s", error.what(), kUsage);
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "ssjs_segmentation_study: %s\n", error.what());
    return 1;
  }
  return 0;
}
