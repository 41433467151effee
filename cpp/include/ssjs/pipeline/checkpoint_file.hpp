/// What a state's bytes (base/archive.hpp) travel in: one CBOR item (RFC 8949) that says what it is, whose, and whether it is whole.
///
///   55799([24(<<header>>), state, checksum])
///     header    map: format "ssjs-checkpoint", version, library, of, configuration {key: value as text}
///     state     byte string with a length of 8 bytes
///     checksum  unsigned integer of 8 bytes, CRC-64/XZ of every byte before its own item
///
/// The header holds the whole configuration and not a digest of it: whoever restores under another one is told which key differs.
#pragma once

#include <string>
#include <string_view>

#include "ssjs/base/config_text.hpp"

namespace ssjs {

/// Whose state it is: "online survey", and the configuration it was built with.
struct CheckpointOwner {
  std::string_view of;
  FieldTexts configuration;
};

/// `state` is the two texts one after the other.
[[nodiscard]] std::string seal_checkpoint(const CheckpointOwner& owner, std::string_view state, std::string_view more_state);

/// The state inside `bytes`. Throws FileError, with `source` as its path, for what is no checkpoint, cut off, damaged, of another format
/// version, of another kind of estimator or of another configuration.
[[nodiscard]] std::string_view open_checkpoint(const CheckpointOwner& owner, std::string_view bytes, const std::string& source);

}  // namespace ssjs
