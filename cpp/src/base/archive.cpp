#include "ssjs/base/archive.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "ssjs/base/error.hpp"

#if !defined(__BYTE_ORDER__) || __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "Archive copies numbers as they lie in memory: a machine that keeps the high byte first needs them swapped here"
#endif

namespace ssjs {
namespace {

/// FNV-1a folded to 16 bits.
std::uint16_t mark_of(std::string_view name) {
  std::uint32_t hash = 2166136261U;
  for (const char letter : name) hash = (hash ^ static_cast<unsigned char>(letter)) * 16777619U;
  return static_cast<std::uint16_t>(hash ^ (hash >> 16U));
}

}  // namespace

void Archive::fail(const std::string& what) const {
  std::string where;
  for (const Place& place : places_) {
    where += (where.empty() ? "" : ".") + std::string(place.name);
    if (place.element != kNone) where += "[" + std::to_string(place.element) + "]";
  }
  if (!reading_) throw InvalidArgument("state", where, what);
  throw FileError(source_, 0, where + " " + what);
}

void Archive::check_name(std::string_view name) {
  const std::uint16_t mark = mark_of(name);
  std::uint16_t found = mark;
  raw(&found, sizeof found);
  if (found != mark) fail("is not where it should be: written by a build whose state has other members");
}

void Archive::raw(void* data, std::size_t bytes) {
  if (bytes == 0) return;
  if (!reading_) {
    out_.append(static_cast<const char*>(data), bytes);
    return;
  }
  if (bytes > in_.size()) fail("is cut off");
  std::memcpy(data, in_.data(), bytes);
  in_.remove_prefix(bytes);
}

void Archive::numbers(double* data, std::size_t count) {
  raw(data, count * sizeof(double));
  if (!std::all_of(data, data + count, [](double value) { return std::isfinite(value); })) fail("is not finite");
}

void Archive::unbounded(std::string_view name, double& value) {
  const Inside inside(*this, name);
  check_name(name);
  raw(&value, sizeof value);
  if (std::isnan(value)) fail("is not a number");
}

std::size_t Archive::count(std::size_t elements, std::size_t least_bytes) {
  auto size = static_cast<std::int64_t>(elements);
  raw(&size, sizeof size);
  if (reading_ && (size < 0 || static_cast<std::uint64_t>(size) > in_.size() / least_bytes)) {
    fail("claims " + std::to_string(size) + " elements, more than the bytes that are left");
  }
  return static_cast<std::size_t>(size);
}

void Archive::check_size(std::int64_t size, std::int64_t fixed, std::int64_t most) const {
  constexpr std::int64_t kMost = std::numeric_limits<std::int32_t>::max();
  if (size < 0 || size > kMost || (fixed >= 0 && size != fixed) || (most >= 0 && size > most)) {
    fail("has the wrong shape: " + std::to_string(size) + " rows or columns");
  }
}

void Archive::item(bool& value) {
  std::uint8_t byte = value ? 1 : 0;
  raw(&byte, sizeof byte);
  if (byte > 1) fail("is neither true nor false");
  if (reading_) value = byte == 1;
}

void Archive::item(std::string& text) {
  const std::size_t size = count(text.size(), 1);
  if (reading_) text.resize(size);
  raw(text.data(), size);
}

void Archive::end() const {
  if (!in_.empty()) throw FileError(source_, 0, std::to_string(in_.size()) + " bytes too many");
}

}  // namespace ssjs
