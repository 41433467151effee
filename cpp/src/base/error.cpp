#include "ssjs/base/error.hpp"

#include <sstream>
#include <utility>

namespace ssjs {
namespace {

std::string to_text(double value) {
  std::ostringstream out;
  out.precision(12);
  out << value;
  return out.str();
}

}  // namespace

InvalidArgument::InvalidArgument(const std::string& argument, const std::string& value, const std::string& rule)
    : Error(argument + " = " + value + ": " + rule) {}

InvalidArgument::InvalidArgument(const std::string& argument, double value, const std::string& rule)
    : InvalidArgument(argument, to_text(value), rule) {}

NotPositiveDefinite::NotPositiveDefinite(const std::string& matrix, const std::string& detail)
    : Error(matrix + " is not positive definite (" + detail + ")") {}

FileError::FileError(std::string path, std::int64_t offset, const std::string& what)
    : Error(path + ": " + what), path_(std::move(path)), offset_(offset) {}

}  // namespace ssjs
