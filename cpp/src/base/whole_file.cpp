#include "ssjs/base/whole_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

[[noreturn]] void fail(const std::string& path, const char* what) {
  throw FileError(path, 0, std::string(what) + ": " + std::strerror(errno));
}

/// An open file or folder.
class Descriptor {
 public:
  Descriptor(std::string path, int flags, const char* otherwise) : path_(std::move(path)), number_(open(path_.c_str(), flags, 0666)) {
    if (number_ < 0) fail(path_, otherwise);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (number_ >= 0) close(number_);
  }

  void put(std::string_view content) const {
    while (!content.empty()) {
      const ssize_t written = write(number_, content.data(), content.size());
      if (written < 0 && errno != EINTR) fail(path_, "cannot be written");
      if (written > 0) content.remove_prefix(static_cast<std::size_t>(written));
    }
  }
  /// Onto the disk; a file system that cannot do so for folders says EINVAL.
  void settle() const {
    if (fsync(number_) != 0 && errno != EINVAL) fail(path_, "cannot be brought to the disk");
  }

 private:
  std::string path_;
  int number_;
};

}  // namespace

std::string read_whole_file(const std::string& path, std::int64_t most_bytes) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw FileError(path, 0, "is no file that can be read");
  std::ifstream in(path, std::ios::binary);
  if (!in) fail(path, "cannot be opened");
  const auto bytes = static_cast<std::int64_t>(std::filesystem::file_size(path, error));
  if (error || bytes > most_bytes) {
    throw FileError(path, most_bytes, "is larger than " + std::to_string(most_bytes) + " bytes: this is not what is looked for");
  }
  std::string content(static_cast<std::size_t>(bytes), '\0');
  in.read(content.data(), static_cast<std::streamsize>(bytes));
  if (in.gcount() != bytes) throw FileError(path, in.gcount(), "cannot be read further");
  return content;
}

void write_whole_file(const std::string& path, std::string_view content) {
  const std::string part = path + ".part";
  {
    const Descriptor file(part, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, "cannot be written");
    file.put(content);
    file.settle();
  }
  std::error_code error;
  std::filesystem::rename(part, path, error);
  if (error) throw FileError(path, 0, "cannot be put in place: " + error.message());
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  Descriptor(folder.empty() ? "." : folder.string(), O_RDONLY | O_DIRECTORY | O_CLOEXEC, "cannot be opened").settle();
}

}  // namespace ssjs
