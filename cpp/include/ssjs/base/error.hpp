/// Typed exceptions of the library. Each says what is wrong, with which value, and what to do.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

namespace ssjs {

/// Root of everything this library throws on purpose.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A contract broken by the caller: "argument = value: rule".
class InvalidArgument : public Error {
 public:
  InvalidArgument(const std::string& argument, const std::string& value, const std::string& rule);
  InvalidArgument(const std::string& argument, double value, const std::string& rule);
};

/// A matrix that has to be a covariance is not one. `matrix` names it, `detail` the landmark, map or time concerned.
class NotPositiveDefinite : public Error {
 public:
  NotPositiveDefinite(const std::string& matrix, const std::string& detail);
};

/// A file that cannot be read or written; `offset` is the byte (or line, as the message says) where it went wrong.
class FileError : public Error {
 public:
  FileError(std::string path, std::int64_t offset, const std::string& what);
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] std::int64_t offset() const { return offset_; }

 private:
  std::string path_;
  std::int64_t offset_;
};

/// The caller's progress sink asked to stop.
class Cancelled : public Error {
 public:
  Cancelled() : Error("cancelled by the caller") {}
};

}  // namespace ssjs
