/// The mapper of each method. docs/architecture.md.
#pragma once

#include <cstdint>
#include <memory>

#include "ssjs/joining/mapper.hpp"
#include "ssjs/pipeline/slam_config.hpp"

namespace ssjs {

/// What the methods that join finished submaps are made of.
struct JoinerParts {
  SelectiveJoinerConfig joining;
  DivideAndConquerConfig dcs;
  AssociationMethod association = AssociationMethod::kJointCompatibility;
  std::optional<int> max_landmarks;  ///< of a submap
};
/// The joiner of a method of submaps: SSJS, its printed recipe, LMJ, D&C, CLSF, HS; of any other method that of SSJS, which places one map.
[[nodiscard]] std::unique_ptr<MapJoiner> make_joiner(Method method, const JoinerParts& parts, std::uint64_t seed);

[[nodiscard]] std::unique_ptr<Mapper> make_mapper(const SlamConfig& config, std::uint64_t seed);

}  // namespace ssjs
