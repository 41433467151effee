// ssjs_contact_study: found, false, bias, scatter and consistency of the contacts of simulated surveys. See ../README.md.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "../quantiles.hpp"
#include "study.hpp"

constexpr const char* kUsage = "usage: ssjs_contact_study lines|survey|large FIRST_SEED LAST_SEED [improved_otsu]\n";

namespace ssjs::benchmarks {
namespace {

/// The contacts of all seeds; they point into the runs.
struct Everything {
  std::vector<SurveyRun> runs;
  std::vector<JudgedContact> contacts;
  std::vector<JudgedPass> passes;
};

double root_mean_square(const std::vector<double>& values) {
  std::vector<double> squares;
  for (const double value : values) squares.push_back(value * value);
  return std::sqrt(mean(squares));
}

template <class OfContact, class OfPass>
void print_row(const std::string& name, const Everything& all, const OfContact& is_wanted, const OfPass& is_pass) {
  std::vector<double> along;
  std::vector<double> across;
  std::vector<double> nis;
  std::vector<double> along_sigmas;
  std::vector<double> across_sigmas;
  for (const JudgedContact& judged : all.contacts) {
    if (!judged.object || judged.in_turn || judged.is_second || !is_wanted(judged)) continue;
    along.push_back(judged.error_m.x());
    across.push_back(judged.error_m.y());
    nis.push_back(judged.nis);
    along_sigmas.push_back(judged.normalised.x());
    across_sigmas.push_back(judged.normalised.y());
  }
  int wanted = 0;
  int found = 0;
  for (const JudgedPass& pass : all.passes) {
    if (!is_pass(pass)) continue;
    ++wanted;
    found += pass.found ? 1 : 0;
  }
  if (nis.empty()) return;
  const auto square = [](double x) { return x * x; };
  std::printf("| %s | %d of %d (%.0f %%) | %+.3f, %.3f | %+.3f, %.3f | %.2f | %.2f | %.2f, %.2f, %.1f |\n", name.c_str(), found, wanted,
              100.0 * found / std::max(wanted, 1), mean(along), root_mean_square(along), mean(across), root_mean_square(across),
              square(root_mean_square(along_sigmas)), square(root_mean_square(across_sigmas)), mean(nis), median(nis), quantile(nis, 0.99));
}

void print_places(const Everything& all) {
  std::printf(
      "| | found | along: bias, RMS m | across: bias, RMS m | NIS along | across | both: mean, median, 99 %% "
      "|\n|---|---|---|---|---|---|---|\n");
  const auto every = [](const auto&) { return true; };
  print_row("all", all, every, every);
  for (const auto& [name, shape] : kObjectShapes) {
    const auto of_shape = [kind = shape](const auto& judged) { return judged.object->shape == kind; };
    print_row(name, all, of_shape, of_shape);
  }
  const std::vector<double> edges{kLeastGroundRange_m, 4, 8, 12, 16, 20, 24, kMostGroundRange_m};
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    const auto inside = [&](double range_m) { return range_m >= edges[i] && range_m < edges[i + 1]; };
    char name[40];
    std::snprintf(name, sizeof name, "%.1f to %.0f m", edges[i], edges[i + 1]);
    print_row(
        name, all, [&](const JudgedContact& judged) { return inside(judged.contact->ground_range_m); },
        [&](const JudgedPass& pass) { return inside(pass.ground_range_m); });
  }
}

void print_false(const Everything& all) {
  std::vector<JudgedContact> ranked;
  int second = 0;
  int wrong = 0;
  for (const JudgedContact& judged : all.contacts) {
    if (judged.in_turn && judged.object) continue;
    ranked.push_back(judged);
    second += judged.is_second ? 1 : 0;
    wrong += judged.object ? 0 : 1;
  }
  if (ranked.empty()) return;
  const double percent = 100.0 / static_cast<double>(ranked.size());
  std::printf("\n%zu contacts, %d false (%.1f %%), %d second ones of a pass (%.1f %%)\n\n", ranked.size(), wrong, percent * wrong, second,
              percent * second);
  std::sort(ranked.begin(), ranked.end(),
            [](const JudgedContact& a, const JudgedContact& b) { return a.contact->confidence > b.contact->confidence; });
  std::printf("| confidence from | to | contacts | of objects |\n|---|---|---|---|\n");
  constexpr std::size_t kTenths = 10;
  for (std::size_t tenth = 0; tenth < kTenths; ++tenth) {
    const std::size_t first = tenth * ranked.size() / kTenths;
    const std::size_t end = (tenth + 1) * ranked.size() / kTenths;
    if (first == end) continue;
    const auto good = std::count_if(ranked.begin() + static_cast<std::ptrdiff_t>(first), ranked.begin() + static_cast<std::ptrdiff_t>(end),
                                    [](const JudgedContact& judged) { return judged.object != nullptr; });
    std::printf("| %.2f | %.2f | %zu | %.0f %% |\n", ranked[end - 1].contact->confidence, ranked[first].contact->confidence, end - first,
                100.0 * static_cast<double>(good) / static_cast<double>(end - first));
  }
}

void run(const std::string& scenario, int first_seed, int last_seed, const SideScanSurveyConfig& config) {
  Everything all;
  for (int seed = first_seed; seed <= last_seed; ++seed)
    all.runs.push_back(run_scenario(scenario, config, static_cast<std::uint64_t>(seed)));
  for (const SurveyRun& one : all.runs) {
    const Judgement judgement = judge(one, config);
    all.contacts.insert(all.contacts.end(), judgement.contacts.begin(), judgement.contacts.end());
    all.passes.insert(all.passes.end(), judgement.passes.begin(), judgement.passes.end());
  }
  print_places(all);
  print_false(all);
}

}  // namespace
}  // namespace ssjs::benchmarks

int main(int count, char** arguments) {
  cv::setNumThreads(1);
  try {
    if (count < 4) throw std::invalid_argument("a scenario, a first and a last seed are needed");
    ssjs::SideScanSurveyConfig config;
    if (count > 4) config.detector = ssjs::ContactDetector::kImprovedOtsu;
    ssjs::benchmarks::run(arguments[1], std::stoi(arguments[2]), std::stoi(arguments[3]), config);
  } catch (const std::invalid_argument& error) {
    std::fprintf(stderr, "ssjs_contact_study: %s\n%s", error.what(), kUsage);
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "ssjs_contact_study: %s\n", error.what());
    return 1;
  }
  return 0;
}
