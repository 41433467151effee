/// Bytes of a log: a file read through a window, or memory. Little-endian fields are read with their bounds checked.
#pragma once

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <string>
#include <type_traits>
#include <vector>

#include "ssjs/base/error.hpp"

namespace ssjs {

/// A stretch of bytes that belong to someone else.
class ByteView {
 public:
  ByteView() = default;
  ByteView(const unsigned char* data, std::size_t size) : data_(data), size_(size) {}

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] const unsigned char* data() const { return data_; }
  [[nodiscard]] bool holds(std::uint64_t offset, std::uint64_t count) const { return offset <= size_ && count <= size_ - offset; }

  /// `count` bytes from `offset` on. Throws Error where the view ends before.
  [[nodiscard]] ByteView part(std::size_t offset, std::size_t count) const;

  [[nodiscard]] std::uint8_t u8(std::size_t offset) const { return static_cast<std::uint8_t>(bits(offset, 1)); }
  [[nodiscard]] std::uint16_t u16(std::size_t offset) const { return static_cast<std::uint16_t>(bits(offset, 2)); }
  [[nodiscard]] std::uint32_t u32(std::size_t offset) const { return static_cast<std::uint32_t>(bits(offset, 4)); }
  [[nodiscard]] std::int16_t i16(std::size_t offset) const { return static_cast<std::int16_t>(u16(offset)); }
  [[nodiscard]] std::int32_t i32(std::size_t offset) const { return static_cast<std::int32_t>(u32(offset)); }
  [[nodiscard]] float f32(std::size_t offset) const;
  [[nodiscard]] double f64(std::size_t offset) const;
  /// Printable ASCII up to the first zero byte; whatever else a damaged file holds becomes '?'.
  [[nodiscard]] std::string text(std::size_t offset, std::size_t count) const;

 private:
  [[nodiscard]] std::uint64_t bits(std::size_t offset, std::size_t bytes) const;

  const unsigned char* data_ = nullptr;
  std::size_t size_ = 0;
};

/// Random access to the bytes of a log. Only what is asked for is read; nothing beside the file is ever opened.
class ByteSource {
 public:
  virtual ~ByteSource() = default;
  [[nodiscard]] virtual std::uint64_t size() const = 0;
  /// Up to `count` bytes from `offset` on, fewer at the end. Valid until the next call.
  [[nodiscard]] virtual ByteView view(std::uint64_t offset, std::size_t count) = 0;
};

class MemoryBytes : public ByteSource {
 public:
  /// The bytes stay the caller's and must outlive this.
  MemoryBytes(const unsigned char* data, std::size_t size) : bytes_(data, size) {}
  [[nodiscard]] std::uint64_t size() const override { return bytes_.size(); }
  [[nodiscard]] ByteView view(std::uint64_t offset, std::size_t count) override;

 private:
  ByteView bytes_;
};

class FileBytes : public ByteSource {
 public:
  /// Throws FileError if `path` is no regular file that can be read.
  explicit FileBytes(const std::string& path);
  [[nodiscard]] std::uint64_t size() const override { return size_; }
  [[nodiscard]] ByteView view(std::uint64_t offset, std::size_t count) override;

 private:
  std::string path_;
  std::ifstream file_;
  std::uint64_t size_ = 0;
  std::vector<unsigned char> window_;
  std::uint64_t window_offset_ = 0;
};

}  // namespace ssjs
