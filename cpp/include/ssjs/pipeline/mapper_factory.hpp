/// The mapper of each method. docs/architecture.md.
#pragma once

#include <cstdint>
#include <memory>

#include "ssjs/joining/mapper.hpp"
#include "ssjs/pipeline/slam_config.hpp"

namespace ssjs {

[[nodiscard]] std::unique_ptr<Mapper> make_mapper(const SlamConfig& config, std::uint64_t seed);

}  // namespace ssjs
