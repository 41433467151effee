/// The local maps and the joiner of each method of an underwater mission. docs/math/underwater_methods.md.
#pragma once

#include <cstdint>
#include <memory>

#include "ssjs/pipeline/levelled_pipeline.hpp"

namespace ssjs {

/// How the method builds its maps. Throws InvalidArgument listing every violation of the configuration.
[[nodiscard]] LevelledBuilderConfig local_config(const LevelledConfig& config);

/// config.joining, identities being known between maps where they are known within them.
[[nodiscard]] PortJoinerConfig joining_config(const LevelledConfig& config);

[[nodiscard]] std::unique_ptr<SurveyJoiner> make_survey_joiner(const LevelledConfig& config, std::uint64_t seed);

}  // namespace ssjs
