// ssjs_study: how the method behaves over whole missions. See README.md beside this file.
#include <charconv>
#include <cstdio>
#include <exception>
#include <map>
#include <stdexcept>

#include "study.hpp"

namespace {

using ssjs::benchmarks::StudyOptions;

constexpr const char* kUsage =
    "usage: ssjs_study STUDY [--rounds N] [--seeds N] [--laps N] [--columns N] [--rows N] [--association known|jcbb] [--limit-s N] "
    "[--method NAME] [--seed N] [--csv FILE]\n"
    "  grid-survey  bare EKF loop, ekf, ssjs on scenario S     --rounds --seeds --seed\n"
    "  methods      every joining method on scenario S         --seeds --association --seed\n"
    "  growth       every method over the number of landmarks  --limit-s --method --seed\n"
    "  revisit      global level, a fixed area                 --laps --rounds --association --seed --csv\n"
    "  exploration  global level, a growing field              --columns --rows --rounds --association --seed --csv\n"
    "  crossover    dense against sparse global level          --columns --rows --rounds --association --seed\n"
    "  faults       everything that can go wrong under water   --seeds --method --seed\n";

int whole_number(const std::string& flag, const std::string& text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < 0) {
    throw std::invalid_argument(flag + " " + text + ": must be a whole number, not negative");
  }
  return value;
}

StudyOptions parse(int count, char** arguments) {
  StudyOptions options;
  const std::map<std::string, int*> numbers{{"--rounds", &options.rounds},   {"--seeds", &options.seeds}, {"--laps", &options.laps},
                                            {"--columns", &options.columns}, {"--rows", &options.rows},   {"--limit-s", &options.limit_s}};
  for (int i = 2; i < count; i += 2) {
    const std::string flag = arguments[i];
    if (i + 1 == count) throw std::invalid_argument(flag + ": needs a value");
    const std::string value = arguments[i + 1];
    if (const auto number = numbers.find(flag); number != numbers.end()) {
      *number->second = whole_number(flag, value);
      if (*number->second == 0) throw std::invalid_argument(flag + " 0: must be at least 1");
    } else if (flag == "--seed") {
      options.seed = static_cast<std::uint64_t>(whole_number(flag, value));
    } else if (flag == "--association" && (value == "known" || value == "jcbb")) {
      options.association = value;
    } else if (flag == "--method") {
      options.method = value;
    } else if (flag == "--csv") {
      options.csv = value;
    } else {
      throw std::invalid_argument(flag + " " + value + ": unknown");
    }
  }
  return options;
}

}  // namespace

int main(int count, char** arguments) {
  const std::map<std::string, void (*)(const StudyOptions&)> studies{{"grid-survey", ssjs::benchmarks::study_grid_survey},
                                                                     {"methods", ssjs::benchmarks::study_methods},
                                                                     {"growth", ssjs::benchmarks::study_growth},
                                                                     {"revisit", ssjs::benchmarks::study_revisit},
                                                                     {"exploration", ssjs::benchmarks::study_exploration},
                                                                     {"crossover", ssjs::benchmarks::study_crossover},
                                                                     {"faults", ssjs::benchmarks::study_faults}};
  const auto study = studies.find(count > 1 ? arguments[1] : "");
  if (study == studies.end()) {
    std::fputs(kUsage, stderr);
    return 2;
  }
  try {
    study->second(parse(count, arguments));
  } catch (const std::invalid_argument& error) {
    std::fprintf(stderr, "ssjs_study: %s\n%s", error.what(), kUsage);
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "ssjs_study: %s\n", error.what());
    return 1;
  }
  return 0;
}
