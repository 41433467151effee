/// Feeds a simulated Ackerman mission to a mapper, without a pipeline around it.
#pragma once

#include <limits>
#include <optional>
#include <variant>

#include "ssjs/features/event.hpp"
#include "ssjs/joining/mapper.hpp"
#include "ssjs/simulation/scenario.hpp"

namespace ssjs::testing {

/// after(event): called behind every event.
template <class After>
void drive(Mapper& mapper, const SimulatedMission& mission, const AckermanConfig& vehicle, double until_s, After&& after) {
  std::optional<AckermanControl> held;
  double time_s = 0.0;
  for (const Event& event : mission.events) {
    if (event.time_s > until_s) break;
    if (held && event.time_s > time_s) {
      mapper.predict(event.time_s, predict_ackerman(mapper.base_T_vehicle(), *held, event.time_s - time_s, vehicle));
    }
    time_s = event.time_s;
    std::optional<MapperReport> report;
    if (const auto* control = std::get_if<AckermanControl>(&event.record)) {
      held = *control;
    } else {
      report = mapper.observe(event.time_s, std::get<Features>(event.record));
    }
    mapper.record_step(event.time_s);
    after(event, report);
  }
}

}  // namespace ssjs::testing
