// A vehicle that is switched off at any moment: feeds a simulated survey, leaves a checkpoint every so many samples, goes on from the last
// one when it is started again, and writes the way and the landmarks when the survey is done.
//   ssjs_survivor CHECKPOINT RESULT SAMPLES_BETWEEN [KEY=VALUE ...]
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <numeric>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "embed/samples.hpp"
#include "ssjs/base/whole_file.hpp"

namespace {

using namespace ssjs;

online::Estimator estimator_of(const std::vector<std::pair<std::string, std::string>>& settings) {
  std::vector<online::Setting> views;
  for (const auto& [key, value] : settings) views.push_back({key.c_str(), value.c_str()});
  return online::Estimator(views.data(), views.size());
}

template <class Record>
void put(std::string& out, const std::vector<Record>& records) {
  static_assert(std::is_trivially_copyable_v<Record>);  // and without padding: doubles, then pairs of 32-bit numbers
  out.append(reinterpret_cast<const char*>(records.data()), sizeof(Record) * records.size());
}

std::string result_of(online::Estimator& estimator) {
  std::vector<online::Pose> way(estimator.trajectory(nullptr, 0));
  estimator.trajectory(way.data(), way.size());
  std::vector<online::Landmark> landmarks(estimator.landmarks(nullptr, 0));
  estimator.landmarks(landmarks.data(), landmarks.size());
  std::string bytes;
  put(bytes, way);
  put(bytes, landmarks);
  return bytes;
}

/// Every sample that arrived was counted, taken or refused: where to go on.
std::size_t samples_so_far(const online::Estimator& estimator) {
  const online::Status status = estimator.status();
  return static_cast<std::size_t>(std::accumulate(std::begin(status.arrivals), std::end(status.arrivals), std::int64_t{0}));
}

void require(bool done, const online::Estimator& estimator) {
  if (!done) throw std::runtime_error(estimator.last_error());
}

void run(const char* checkpoint, const char* result, std::size_t between,
         const std::vector<std::pair<std::string, std::string>>& settings) {
  const std::vector<testing::Arriving> samples = testing::samples_of(testing::survey(3).ticks);
  online::Estimator estimator = estimator_of(settings);
  if (std::ifstream(checkpoint).good()) require(estimator.restore(checkpoint), estimator);
  for (std::size_t i = samples_so_far(estimator); i < samples.size(); ++i) {
    require(testing::feed(estimator, samples[i].sample) == online::Arrival::kTaken, estimator);
    if ((i + 1) % between == 0) {
      require(estimator.wait_for_checkpoint(), estimator);
      require(estimator.checkpoint(checkpoint), estimator);
    }
  }
  require(estimator.finish(), estimator);
  write_whole_file(result, result_of(estimator));
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 4) return 2;
  std::vector<std::pair<std::string, std::string>> settings;
  for (int i = 4; i < count; ++i) {
    const std::string text = arguments[i];
    settings.emplace_back(text.substr(0, text.find('=')), text.substr(text.find('=') + 1));
  }
  try {
    run(arguments[1], arguments[2], static_cast<std::size_t>(std::atoi(arguments[3])), settings);
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "%s\n", problem.what());
    return 1;
  }
  return 0;
}
