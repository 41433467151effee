/// Files read and written as a whole.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace ssjs {

/// Throws FileError if the file cannot be read or is larger than `most_bytes`.
[[nodiscard]] std::string read_whole_file(const std::string& path, std::int64_t most_bytes);

/// Written beside `path` as PATH.part, brought to the disk, then renamed: whoever reads, and be it after the power went, finds the old file
/// or the new one, never a part. Throws FileError.
void write_whole_file(const std::string& path, std::string_view content);

}  // namespace ssjs
