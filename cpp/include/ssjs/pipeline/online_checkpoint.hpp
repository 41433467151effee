/// What a checkpoint of an online survey is made of. docs/embedding.md, "State survives".
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "ssjs/joining/port_joiner.hpp"
#include "ssjs/pipeline/checkpoint_file.hpp"

namespace ssjs {

/// `bytes`, followed by submaps. A finished submap never changes: who takes a checkpoint waits for the bytes alone, and a thread can write
/// the submaps down while the survey goes on.
struct SurveyState {
  std::string bytes;
  std::vector<LevelledSubmap*> submaps;
};

[[nodiscard]] SurveyState state_of(PortJoiner& joiner);
[[nodiscard]] std::string seal_checkpoint(const CheckpointOwner& owner, const SurveyState& state);

/// Into a new joiner: its own bytes, and from `submaps` as many as it has.
void read_joiner(PortJoiner& joiner, std::string_view bytes, Archive& submaps, const std::string& source);

/// A submap that waits for the joiner.
[[nodiscard]] std::string bytes_of(LevelledSubmap& submap);
[[nodiscard]] LevelledSubmap submap_of(std::string_view bytes, const std::string& source);

}  // namespace ssjs
