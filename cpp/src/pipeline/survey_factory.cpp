#include "ssjs/pipeline/survey_factory.hpp"

#include <limits>

#include "ssjs/joining/planar_survey.hpp"
#include "ssjs/joining/port_survey.hpp"
#include "ssjs/pipeline/mapper_factory.hpp"

namespace ssjs {
namespace {

/// The method for vehicles in the plane, where it is one.
std::optional<Method> planar_method(LevelledMethod method) {
  switch (method) {
    case LevelledMethod::kFused:
      return Method::kSelective;
    case LevelledMethod::kSelectiveThesis:
      return Method::kSelectiveThesis;
    case LevelledMethod::kSequential:
      return Method::kSequential;
    case LevelledMethod::kDivideAndConquer:
      return Method::kDivideAndConquer;
    case LevelledMethod::kHierarchical:
      return Method::kHierarchical;
    case LevelledMethod::kConstrainedLocal:
      return Method::kConstrainedLocal;
    default:
      return std::nullopt;
  }
}

}  // namespace

LevelledBuilderConfig local_config(const LevelledConfig& config) {
  throw_if_any(config.violations());
  LevelledBuilderConfig local = config.local;
  if (config.method == LevelledMethod::kNaiveHeading) local.compass_use = CompassUse::kFirstReading;
  const bool is_fixed = config.method == LevelledMethod::kPorts || config.method == LevelledMethod::kNaiveHeading;
  if (!is_fixed) local.split.fix_interval_s.reset();  // the other methods know no fixes
  if (config.method == LevelledMethod::kOneMap) {
    local.split.policy = {std::nullopt, std::nullopt, std::nullopt, std::nullopt, std::nullopt, 0};
    local.split.longest_m = std::numeric_limits<double>::max();
  }
  return local;
}

PortJoinerConfig joining_config(const LevelledConfig& config) {
  PortJoinerConfig joining = config.joining;
  joining.association =
      config.local.association.method == AssociationMethod::kKnown ? AssociationMethod::kKnown : AssociationMethod::kJointCompatibility;
  return joining;
}

std::unique_ptr<SurveyJoiner> make_survey_joiner(const LevelledConfig& config, std::uint64_t seed) {
  const PortJoinerConfig joining = joining_config(config);
  if (const std::optional<Method> method = planar_method(config.method)) {
    std::optional<NorthOffset> north;
    if (joining.north_offset_rad) north = {*joining.north_offset_rad, joining.north_offset_sigma_rad};
    const JoinerParts parts{config.fusing, config.dcs, joining.association, config.local.split.policy.max_landmarks};
    return std::make_unique<PlanarSurvey>(make_joiner(*method, parts, seed), north);
  }
  return std::make_unique<PortSurvey>(joining);
}

}  // namespace ssjs
