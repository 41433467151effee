#include "ssjs/io/byte_source.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

namespace ssjs {
namespace {

constexpr std::size_t kWindowBytes = 256 * 1024;

}  // namespace

ByteView ByteView::part(std::size_t offset, std::size_t count) const {
  if (!holds(offset, count)) throw Error("a field lies beyond the end of its record");
  return {data_ + offset, count};
}

std::uint64_t ByteView::bits(std::size_t offset, std::size_t bytes) const {
  if (!holds(offset, bytes)) throw Error("a field lies beyond the end of its record");
  const unsigned char* field = data_ + offset;
  std::uint64_t value = 0;
  for (std::size_t i = bytes; i > 0; --i) value = (value << 8U) | field[i - 1];
  return value;
}

float ByteView::f32(std::size_t offset) const {
  const std::uint32_t raw = u32(offset);
  float value = 0.0F;
  static_assert(sizeof(value) == sizeof(raw));
  std::memcpy(&value, &raw, sizeof(value));
  return value;
}

double ByteView::f64(std::size_t offset) const {
  const std::uint64_t raw = bits(offset, 8);
  double value = 0.0;
  static_assert(sizeof(value) == sizeof(raw));
  std::memcpy(&value, &raw, sizeof(value));
  return value;
}

std::string ByteView::text(std::size_t offset, std::size_t count) const {
  const ByteView field = part(offset, count);
  std::string text;
  for (std::size_t i = 0; i < count && field.data_[i] != 0; ++i) {
    const unsigned char c = field.data_[i];
    text.push_back(c >= 0x20 && c < 0x7F ? static_cast<char>(c) : '?');
  }
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

ByteView MemoryBytes::view(std::uint64_t offset, std::size_t count) {
  if (offset >= bytes_.size()) return {};
  const auto first = static_cast<std::size_t>(offset);
  return bytes_.part(first, std::min(count, bytes_.size() - first));
}

FileBytes::FileBytes(const std::string& path) : path_(path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw FileError(path, 0, "is no file that can be read; check the path");
  file_.open(path, std::ios::binary);
  if (!file_) throw FileError(path, 0, std::string("cannot be opened: ") + std::strerror(errno));
  size_ = std::filesystem::file_size(path, error);
  if (error) throw FileError(path, 0, "its size cannot be told: " + error.message());
}

ByteView FileBytes::view(std::uint64_t offset, std::size_t count) {
  if (offset >= size_) return {};
  count = static_cast<std::size_t>(std::min<std::uint64_t>(count, size_ - offset));
  const bool inside = offset >= window_offset_ && offset - window_offset_ <= window_.size() &&
                      count <= window_.size() - static_cast<std::size_t>(offset - window_offset_);
  if (!inside) {
    const std::uint64_t wanted = std::min<std::uint64_t>(std::max(count, kWindowBytes), size_ - offset);
    window_.resize(static_cast<std::size_t>(wanted));
    window_offset_ = offset;
    file_.clear();
    file_.seekg(static_cast<std::streamoff>(offset));
    file_.read(reinterpret_cast<char*>(window_.data()), static_cast<std::streamsize>(wanted));
    if (file_.bad()) throw FileError(path_, static_cast<std::int64_t>(offset), "cannot be read further; check the disk");
    window_.resize(static_cast<std::size_t>(file_.gcount()));  // fewer where the file shrank meanwhile
    count = std::min(count, window_.size());
  }
  return {window_.data() + static_cast<std::size_t>(offset - window_offset_), count};
}

}  // namespace ssjs
