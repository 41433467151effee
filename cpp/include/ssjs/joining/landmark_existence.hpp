/// Whether a landmark is there: how often the sonar passed it, and how often it showed. docs/math/ports.md (P-20..P-23).
#pragma once

#include <optional>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/joining/port_estimate.hpp"

namespace ssjs {

struct ExistenceConfig {
  double real_probability = 0.8;
  double detection_probability = 0.8;
  double chance_probability = 0.03;
  double pass_window_s = 10.0;
  double min_existence = 0.5;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("real_probability", real_probability, Rule::open(0, 1),
            "how likely a new landmark is to be an object: where the learning from the survey starts");
    v.field("detection_probability", detection_probability, Rule::open(0, 1), "how likely a pass is to show an object: the same");
    v.field("chance_probability", chance_probability, Rule::open(0, 1), "how likely a pass is to show something where nothing is");
    v.field("pass_window_s", pass_window_s, Rule::positive(), "sightings of one landmark that follow each other faster are one pass");
    v.field("min_existence", min_existence, Rule::closed(0, 1), "landmarks of a smaller probability are not confirmed: no contacts");
  }
};

/// What the sonar covers, by where and when it did show things. (P-20)
struct CoveredSwath {
  double min_across_m = 0.0, max_across_m = 0.0;  ///< horizontal, to either side
  double max_turn_rad_s = 0.0;
};
/// From every sighting of these landmarks; nothing with fewer than 20, from which no edge can be told.
[[nodiscard]] std::optional<CoveredSwath> covered_swath(const std::vector<SurveyLandmark>& landmarks, const std::vector<SurveyStep>& way);

/// What is learnt from a survey on the way. (P-23)
struct ExistenceModel {
  double real_probability = 0.0;
  double detection_probability = 0.0;
};

/// Of a landmark that `seen` of `expected` passes showed, 1 <= seen <= expected. (P-22)
[[nodiscard]] double existence_probability(int seen, int expected, const ExistenceModel& model, double chance_probability);

/// Fills in passes_seen, passes_expected, existence and confirmed of every landmark, none of which is dropped. `way`: ascending times; two
/// steps more than 5 s apart have nothing between them.
ExistenceModel judge_existence(std::vector<SurveyLandmark>& landmarks, const std::vector<SurveyStep>& way, const ExistenceConfig& config);

}  // namespace ssjs
