#include "ssjs/pipeline/online_checkpoint.hpp"

#include "ssjs/base/archive.hpp"

namespace ssjs {

SurveyState state_of(PortJoiner& joiner) {
  Archive a;
  joiner.archive(a);
  return {a.take_bytes(), joiner.submaps()};
}

std::string seal_checkpoint(const CheckpointOwner& owner, const SurveyState& state) {
  Archive a;
  for (LevelledSubmap* submap : state.submaps) a("submap", *submap);
  return seal_checkpoint(owner, state.bytes, a.take_bytes());
}

void read_joiner(PortJoiner& joiner, std::string_view bytes, Archive& submaps, const std::string& source) {
  Archive a(bytes, source);
  joiner.archive(a);
  a.end();
  for (LevelledSubmap* submap : joiner.submaps()) submaps("submap", *submap);
  submaps.end();
  joiner.resume();
}

std::string bytes_of(LevelledSubmap& submap) {
  Archive a;
  a("submap", submap);
  return a.take_bytes();
}

LevelledSubmap submap_of(std::string_view bytes, const std::string& source) {
  LevelledSubmap submap;
  Archive a(bytes, source);
  a("submap", submap);
  a.end();
  return submap;
}

}  // namespace ssjs
