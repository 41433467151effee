// A true checkpoint of a short mission with any edits: it is restored, or refused with a FileError. Kind 0 edits the file, which its
// checksum finds; kind 1 the state, sealed again; kind 2 the header, with a checksum that fits: what a forger or another build would write.
#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string>

#include "byte_stream.hpp"
#include "ssjs/base/checksum.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/pipeline/checkpoint_file.hpp"
#include "ssjs/pipeline/online_survey.hpp"

namespace {

using ssjs::NavigationTick;
using ssjs::OnlineSurvey;
using ssjs::OnlineSurveyConfig;
using ssjs::fuzz::ByteStream;

constexpr std::size_t kHeaderAt = 11;  // CBOR's marks and the length of the header, docs of checkpoint_file.hpp

OnlineSurveyConfig config() {
  OnlineSurveyConfig config;
  config.slam.local.split.longest_m = 4.0;
  config.slam.local.split.policy.max_landmarks = 4;
  config.arrival.window_s = 0.2;
  config.joining_delay_s = 1.0;
  return config;
}

const ssjs::CheckpointOwner& owner() {
  static const ssjs::CheckpointOwner owner{"online survey", ssjs::field_texts(config())};
  return owner;
}

NavigationTick tick_at(int i) {
  NavigationTick tick = ssjs::tick_at(0.5 * i);
  tick.gyro_rad_s = Eigen::Vector3d::Zero();
  tick.roll_pitch_rad = Eigen::Vector2d::Zero();
  tick.compass_rad = 0.1;
  tick.depth_m = 5.0;
  tick.altitude_m = 6.0;
  tick.velocity = ssjs::VelocitySample{Eigen::Vector3d(i % 16 < 8 ? 1.5 : -1.5, 0.0, 0.0), true, std::nullopt};  // to and fro
  if (i % 3 == 0) {
    ssjs::SideScanSighting sighting;
    sighting.vehicle_p_point = Eigen::Vector3d(0.0, 8.0, 6.0);
    tick.sightings.push_back(sighting);
  }
  return tick;
}

constexpr int kTicks = 32;

const std::string& true_checkpoint() {
  static const std::string bytes = [] {
    OnlineSurvey survey(config());
    for (int i = 0; i < kTicks; ++i) (void)survey.feed(tick_at(i));
    return survey.checkpoint();
  }();
  return bytes;
}

const std::string& true_state() {
  static const std::string bytes(ssjs::open_checkpoint(owner(), true_checkpoint(), "seed"));
  return bytes;
}

void edit(std::string& text, ByteStream& bytes) {
  while (!bytes.empty() && !text.empty()) {
    std::size_t at = bytes.byte();
    at += 256U * bytes.byte();
    at = (at + 65536U * bytes.byte()) % text.size();
    const std::size_t how = bytes.below(5);
    std::string value;
    for (int i = 0; i < 8; ++i) value.push_back(static_cast<char>(bytes.byte()));
    if (how < 2) text[at] = value[0];
    if (how == 2 || how == 3) text.replace(at, std::min<std::size_t>(8, text.size() - at), value);
    if (how == 4) text.resize(at);
  }
}

std::string with_checksum(std::string bytes) {
  const std::uint64_t checksum = ssjs::crc64(bytes);
  bytes.push_back('\x1b');
  for (unsigned i = 0; i < 8; ++i) bytes.push_back(static_cast<char>((checksum >> (56U - 8U * i)) & 0xFFU));
  return bytes;
}

std::string forged(ByteStream& bytes) {
  const std::string& whole = true_checkpoint();
  const std::size_t kind = bytes.below(3);
  std::string text = whole;
  if (kind == 1) {
    text = true_state();
    edit(text, bytes);
    return ssjs::seal_checkpoint(owner(), text, "");
  }
  if (kind == 0) {
    edit(text, bytes);
    return text;
  }
  const std::size_t state_at = whole.size() - 18 - true_state().size();  // with its own head
  std::string header = whole.substr(kHeaderAt, state_at - kHeaderAt);
  edit(header, bytes);
  text = whole.substr(0, kHeaderAt - 4);
  for (unsigned i = 0; i < 4; ++i) text.push_back(static_cast<char>((header.size() >> (24U - 8U * i)) & 0xFFU));
  return with_checksum(text + header + whole.substr(state_at, whole.size() - 9 - state_at));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  ByteStream bytes(data, size);
  const std::string file = forged(bytes);
  std::unique_ptr<OnlineSurvey> survey;
  try {
    survey = OnlineSurvey::restored(config(), file, "fuzz");
  } catch (const ssjs::FileError&) {
    return 0;
  }
  (void)survey->status();
  (void)survey->checkpoint();
  return 0;
}
