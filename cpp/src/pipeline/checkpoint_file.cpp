#include "ssjs/pipeline/checkpoint_file.hpp"

#include <algorithm>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>

#include "ssjs/base/checksum.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/base/version.hpp"

namespace ssjs {
namespace {

using Json = nlohmann::json;

constexpr std::string_view kFormat = "ssjs-checkpoint";
constexpr int kFormatVersion = 1;
constexpr std::string_view kBegin("\xd9\xd9\xf7\x83\xd8\x18\x5a", 7);  // CBOR, a list of 3, encoded CBOR, text of a 4-byte length
constexpr char kState = '\x5b';                                        // bytes of an 8-byte length
constexpr char kChecksum = '\x1b';                                     // an 8-byte number
constexpr std::size_t kMostHeader = std::size_t{1} << 20U;
constexpr int kMostDepth = 4;
constexpr std::size_t kEnd = 9;  // the checksum's item

void put_number(std::string& out, std::uint64_t value, int bytes) {
  for (int i = bytes - 1; i >= 0; --i) out.push_back(static_cast<char>((value >> (8U * static_cast<unsigned>(i))) & 0xFFU));
}

std::uint64_t number_at(std::string_view bytes, std::size_t at, std::size_t size) {
  std::uint64_t value = 0;
  for (const char byte : bytes.substr(at, size)) value = (value << 8U) | static_cast<unsigned char>(byte);
  return value;
}

/// The reader of nlohmann-json calls itself for every level.
class DepthCheck : public Json::json_sax_t {
 public:
  bool null() override { return true; }
  bool boolean(bool) override { return true; }
  bool number_integer(Json::number_integer_t) override { return true; }
  bool number_unsigned(Json::number_unsigned_t) override { return true; }
  bool number_float(Json::number_float_t, const Json::string_t&) override { return true; }
  bool string(Json::string_t&) override { return true; }
  bool binary(Json::binary_t&) override { return true; }
  bool start_object(std::size_t) override { return ++depth_ <= kMostDepth; }
  bool key(Json::string_t&) override { return true; }
  bool end_object() override { return --depth_ >= 0; }
  bool start_array(std::size_t) override { return ++depth_ <= kMostDepth; }
  bool end_array() override { return --depth_ >= 0; }
  bool parse_error(std::size_t, const std::string&, const Json::exception&) override { return false; }

 private:
  int depth_ = 0;
};

std::string text_in(const Json& header, const std::string& key) {
  return header.contains(key) && header[key].is_string() ? header[key].get<std::string>() : "nothing";
}

void check_header(const Json& header, const CheckpointOwner& owner, const std::string& source) {
  const auto fail = [&](const std::string& what) { throw FileError(source, 0, what); };
  if (text_in(header, "format") != kFormat) fail("is no checkpoint of this library");
  if (!header.contains("version") || header["version"] != kFormatVersion) {
    fail("is a checkpoint of format version " + (header.contains("version") ? header["version"].dump() : "none") + ", written by ssjs " +
         text_in(header, "library") + "; this is ssjs " + std::string(kVersion) + ", which reads version " +
         std::to_string(kFormatVersion));
  }
  if (text_in(header, "of") != owner.of) fail("is the state of another estimator: " + text_in(header, "of"));
  if (!header.contains("configuration") || !header["configuration"].is_object()) fail("has no configuration");
  const Json& configuration = header["configuration"];
  for (const auto& [key, value] : owner.configuration) {
    if (text_in(configuration, key) != value)
      fail(std::string("was made with another configuration: ")
               .append(key)
               .append(" = ")
               .append(text_in(configuration, key))
               .append(", here it is ")
               .append(value));
  }
  for (const auto& [key, value] : configuration.items()) {
    const auto known = [&, &name = key](const auto& field) { return field.first == name; };
    if (std::none_of(owner.configuration.begin(), owner.configuration.end(), known))
      fail("was made with a setting that is not known here: " + key);
  }
}

}  // namespace

std::string seal_checkpoint(const CheckpointOwner& owner, std::string_view state, std::string_view more_state) {
  const std::map<std::string, std::string> configuration(owner.configuration.begin(), owner.configuration.end());
  const Json header{
      {"format", kFormat}, {"version", kFormatVersion}, {"library", kVersion}, {"of", owner.of}, {"configuration", configuration}};
  std::string encoded;
  Json::to_cbor(header, encoded);
  std::string out;
  out.reserve(kBegin.size() + 4 + encoded.size() + 9 + state.size() + more_state.size() + kEnd);
  out += kBegin;
  put_number(out, encoded.size(), 4);
  out += encoded;
  out += kState;
  put_number(out, state.size() + more_state.size(), 8);
  out += state;
  out += more_state;
  const std::uint64_t checksum = crc64(out);
  out += kChecksum;
  put_number(out, checksum, 8);
  return out;
}

std::string_view open_checkpoint(const CheckpointOwner& owner, std::string_view bytes, const std::string& source) {
  const auto fail = [&](const std::string& what) { throw FileError(source, 0, what); };
  if (bytes.substr(0, kBegin.size()) != kBegin) fail(bytes.empty() ? "is empty" : "is no checkpoint of this library");
  const std::size_t header_at = kBegin.size() + 4;
  const auto cut_off = [&] { fail("is cut off after " + std::to_string(bytes.size()) + " bytes"); };
  if (bytes.size() < header_at) cut_off();
  const auto header_size = static_cast<std::size_t>(number_at(bytes, kBegin.size(), 4));
  if (header_size > kMostHeader) fail("is damaged: a header of " + std::to_string(header_size) + " bytes");
  const std::size_t state_at = header_at + header_size + 9;
  if (bytes.size() < state_at) cut_off();
  const std::uint64_t state_size = number_at(bytes, state_at - 8, 8);
  const std::size_t left = bytes.size() - state_at;
  if (left < kEnd || state_size > left - kEnd) cut_off();
  if (state_size < left - kEnd) fail("is damaged: bytes after its end");
  const std::size_t end = bytes.size() - kEnd;
  if (bytes[state_at - 9] != kState || bytes[end] != kChecksum || number_at(bytes, end + 1, 8) != crc64(bytes.substr(0, end)))
    fail("is damaged: its checksum is another");

  const std::string_view encoded = bytes.substr(header_at, header_size);
  DepthCheck depth;
  if (!Json::sax_parse(encoded.begin(), encoded.end(), &depth, Json::input_format_t::cbor)) fail("is damaged: its header cannot be read");
  check_header(Json::from_cbor(encoded.begin(), encoded.end()), owner, source);
  return bytes.substr(state_at, static_cast<std::size_t>(state_size));
}

}  // namespace ssjs
