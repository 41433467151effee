// Any bytes as settings of the vehicle's estimator and of the planar one, "key=text" a line: taken, or refused with InvalidArgument and
// the configuration unchanged. No field ever holds a number outside its rule.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "byte_stream.hpp"
#include "ssjs/base/config_text.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/pipeline/online_survey.hpp"
#include "ssjs/pipeline/slam_config.hpp"

namespace {

constexpr int kMostSettings = 4;  // of one input: more only take time

template <class Config>
void set_all(ssjs::fuzz::ByteStream bytes) {
  Config config;
  for (int i = 0; i < kMostSettings && !bytes.empty(); ++i) {
    const std::string key = bytes.until('=');
    const std::string text = bytes.until('\n');
    try {
      ssjs::set_field(config, key, text);
    } catch (const ssjs::InvalidArgument&) {  // says so, and is the only thing thrown
    }
  }
  if (!ssjs::violations(config).empty()) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const ssjs::fuzz::ByteStream settings(data + 1, size - 1);
  if ((data[0] & 1U) == 0) {
    set_all<ssjs::OnlineSurveyConfig>(settings);
  } else {
    set_all<ssjs::SlamConfig>(settings);
  }
  return 0;
}
