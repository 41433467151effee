/// CRC-64/XZ (ECMA-182, reflected): finds every burst of damage up to 64 bits and any other with a chance of 2^-64 to miss it. Against
/// accidents, not against forgers.
#pragma once

#include <cstdint>
#include <string_view>

namespace ssjs {

/// `before`: the checksum of what comes before these bytes.
[[nodiscard]] std::uint64_t crc64(std::string_view bytes, std::uint64_t before = 0);

}  // namespace ssjs
