#include "ssjs/cascade/whole_file.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>

#include "ssjs/base/error.hpp"

namespace ssjs {

std::string read_whole_file(const std::string& path, std::int64_t most_bytes) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw FileError(path, 0, "is no file that can be read");
  std::ifstream in(path, std::ios::binary);
  if (!in) throw FileError(path, 0, std::string("cannot be opened: ") + std::strerror(errno));
  const auto bytes = static_cast<std::int64_t>(std::filesystem::file_size(path, error));
  if (error || bytes > most_bytes)
    throw FileError(path, most_bytes, "is larger than " + std::to_string(most_bytes) + " bytes: this is no cascade");
  std::string content{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (in.bad()) throw FileError(path, static_cast<std::int64_t>(content.size()), "cannot be read further");
  return content;
}

void write_whole_file(const std::string& path, std::string_view content) {
  const std::string part = path + ".part";
  {
    std::ofstream out(part, std::ios::binary | std::ios::trunc);
    out.write(content.data(), static_cast<std::streamsize>(content.size()));
    out.close();
    if (!out) throw FileError(part, 0, std::string("cannot be written: ") + std::strerror(errno));
  }
  std::error_code error;
  std::filesystem::rename(part, path, error);
  if (error) throw FileError(path, 0, "cannot be put in place: " + error.message());
}

}  // namespace ssjs
