#include "ssjs/pipeline/mapper_factory.hpp"

#include "ssjs/joining/augmented.hpp"
#include "ssjs/joining/compressed.hpp"
#include "ssjs/joining/conditionally_independent.hpp"
#include "ssjs/joining/selective.hpp"
#include "ssjs/joining/submap_mapper.hpp"

namespace ssjs {
namespace {

/// The textbook filter: one endless map, whose answer is what it filtered at the time.
SubmapBuilderConfig endless(SubmapBuilderConfig submap) {
  submap.split = {std::nullopt, std::nullopt, std::nullopt, std::nullopt, std::nullopt, 0};
  submap.condition_trajectory = false;
  submap.invariant_filter = false;
  return submap;
}

}  // namespace

std::unique_ptr<Mapper> make_mapper(const SlamConfig& config, std::uint64_t seed) {
  if (config.method == Method::kAugmentedEkf) {
    return std::make_unique<AugmentedEkfMapper>(config.aekf, config.sensor, config.submap, config.association, seed);
  }
  if (config.method == Method::kCompressedEkf) {
    return std::make_unique<CompressedEkfMapper>(config.cekf, config.sensor.max_range_m, config.submap, config.association, seed);
  }
  if (config.method == Method::kConditionallyIndependent) {
    return std::make_unique<ConditionallyIndependentMapper>(config.cis, config.submap, config.association, seed);
  }
  const SubmapBuilderConfig submap = config.method == Method::kEkf ? endless(config.submap) : config.submap;
  auto joiner = std::make_unique<SelectiveJoiner>(config.joining, config.association.method, config.submap.split.max_landmarks, seed);
  return std::make_unique<SubmapMapper>(submap, config.association, seed, std::move(joiner));
}

}  // namespace ssjs
