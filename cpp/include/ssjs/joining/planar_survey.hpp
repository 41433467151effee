/// A joining method for vehicles in the plane under water: it places the levelled maps by their planar marginals, depths and steps follow.
/// docs/math/underwater_methods.md (U-1..U-5).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "ssjs/joining/survey_joiner.hpp"

namespace ssjs {

/// What a compass reads when the vehicle heads north, and how surely that is known (rad).
struct NorthOffset {
  double mean_rad = 0.0;
  double sigma_rad = 0.0;
};

class PlanarSurvey final : public SurveyJoiner {
 public:
  /// north: aligns the world; without it the world is that of the first base.
  PlanarSurvey(std::unique_ptr<MapJoiner> joiner, std::optional<NorthOffset> north);

  /// Throws InvalidArgument when the world is to be aligned to north and the first map holds no compass.
  JoinReport take(LevelledSubmap submap) override;
  JoinReport finish() override;
  [[nodiscard]] GaussianSe2 global_T_newest_base() const override;
  [[nodiscard]] const std::deque<PortMap>& maps() const override { return maps_; }
  [[nodiscard]] SurveyEstimate estimate(std::size_t max_joint_bases) const override;
  [[nodiscard]] int compass_jumps() const override { return 0; }
  [[nodiscard]] int merged() const override { return 0; }

 private:
  /// Where the observations of a track are: a landmark of a map.
  struct Track {
    int map;
    Eigen::Index landmark;
  };

  [[nodiscard]] SurveyLandmark with_depth(const LandmarkEstimate& planar) const;

  std::unique_ptr<MapJoiner> joiner_;
  std::optional<NorthOffset> north_;
  std::deque<PortMap> maps_;    ///< their one port in use is the next base
  std::vector<Track> tracks_;   ///< by track number
  GaussianSe2 world_T_base_0_;  ///< a heading alone (U-5)
};

}  // namespace ssjs
