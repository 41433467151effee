// The library in a vehicle's own loop: feed events as they come, read pose and covariance after each.
// Built against the installed package: find_package(ssjs REQUIRED COMPONENTS slam), target ssjs::slam.
#include <cmath>
#include <cstdio>

#include "ssjs/pipeline/slam_pipeline.hpp"
#include "ssjs/simulation/scenario.hpp"

int main() {
  // A simulated vehicle stands in for the sensors.
  const ssjs::Scenario scenario = ssjs::built_in_scenario("grid-survey", 1);
  const ssjs::SimulatedMission mission = ssjs::simulate(scenario.world, scenario.config, 1);

  ssjs::SlamConfig config;  // every field has a documented default; `ssjs-cli config dump` prints them
  config.vehicle.ackerman = scenario.config.vehicle;
  config.joining.max_pairing_sigma_m = 0.8;  // a regular grid of landmarks is easily mistaken by one cell

  ssjs::SlamPipeline pipeline(config, 1);
  for (const ssjs::Event& event : mission.events) {
    const ssjs::StepReport step = pipeline.feed(event);
    if (!step.join) continue;  // print at submap borders only
    const ssjs::GaussianSe2& at = step.global_T_vehicle;
    std::printf("%8.2f s  x %7.2f m  y %7.2f m  heading %6.3f rad  sigma %.2f m  %d maps compared\n", step.time_s, at.mean.x, at.mean.y,
                at.mean.heading, std::sqrt(at.covariance.topLeftCorner<2, 2>().trace()), step.join->candidates);
  }
  pipeline.finish();
  std::printf("%zu landmarks in %zu submaps\n", pipeline.world().landmarks.size(), pipeline.submaps().size());
}
