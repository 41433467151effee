#include "ssjs/pipeline/mapper_factory.hpp"

#include "ssjs/joining/augmented.hpp"
#include "ssjs/joining/compressed.hpp"
#include "ssjs/joining/conditionally_independent.hpp"
#include "ssjs/joining/constrained_local.hpp"
#include "ssjs/joining/divide_and_conquer.hpp"
#include "ssjs/joining/hierarchical.hpp"
#include "ssjs/joining/selective.hpp"
#include "ssjs/joining/selective_thesis.hpp"
#include "ssjs/joining/sequential.hpp"
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

std::unique_ptr<MapJoiner> make_joiner(Method method, const JoinerParts& parts, std::uint64_t seed) {
  const SelectiveJoinerConfig& joining = parts.joining;
  const AssociationMethod association = parts.association;
  const std::optional<int> max_landmarks = parts.max_landmarks;
  MapAssociationConfig pairing{association,
                               {joining.gate_probability, joining.joint_gate_probability, joining.node_budget},
                               joining.max_pairing_sigma_m,
                               std::nullopt};
  switch (method) {
    case Method::kSequential:
      return std::make_unique<SequentialJoiner>(MapAssociator(pairing, seed));
    case Method::kConstrainedLocal:
      return std::make_unique<ConstrainedLocalJoiner>(MapAssociator(pairing, seed));
    case Method::kDivideAndConquer:
      pairing.randomized_above = parts.dcs.rjc_above_landmarks;
      return std::make_unique<DivideAndConquerJoiner>(MapAssociator(pairing, seed));
    case Method::kHierarchical:
      return std::make_unique<HierarchicalJoiner>(joining, association, max_landmarks, seed);
    case Method::kSelectiveThesis:
      return std::make_unique<SelectiveThesisJoiner>(joining, association, max_landmarks, seed);
    default:  // ssjs, and the one map of ekf, which it places
      return std::make_unique<SelectiveJoiner>(joining, association, max_landmarks, seed);
  }
}

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
  return std::make_unique<SubmapMapper>(
      submap, config.association, seed,
      make_joiner(config.method, {config.joining, config.dcs, config.association.method, config.submap.split.max_landmarks}, seed));
}

}  // namespace ssjs
