/// What the methods that filter in one absolute frame have in common: past poses stay as they were filtered.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "ssjs/joining/mapper.hpp"
#include "ssjs/mapping/landmark_map.hpp"

namespace ssjs {

class FilterMapper : public Mapper {
 public:
  [[nodiscard]] const Se2& base_T_vehicle() const override { return map_.filter().vehicle_pose(); }
  void predict(double time_s, const MotionPrediction& motion) override;
  void record_step(double time_s) override;
  [[nodiscard]] GaussianSe2 global_T_vehicle() const override { return {map_.filter().vehicle_pose(), map_.filter().vehicle_covariance()}; }
  [[nodiscard]] int submap() const override { return static_cast<int>(submaps_.size()) - (finished_ ? 1 : 0); }
  [[nodiscard]] const std::vector<Submap>& submaps() const override { return submaps_; }

 protected:
  FilterMapper(const SubmapBuilderConfig& config, const ScanAssociationConfig& association, std::uint64_t seed, StateLayout layout = {});

  void touch(double time_s);  ///< every event comes by here
  /// Ends the present submap with the steps since the last one. `state`: in the frame of its base.
  void close(const std::string& reason, MapState state, std::vector<MapLandmark> landmarks);
  /// The same for the last one, at the end of the mission.
  void close_last(MapState state, std::vector<MapLandmark> landmarks);

  [[nodiscard]] LandmarkMap& local_map() { return map_; }
  [[nodiscard]] const LandmarkMap& local_map() const { return map_; }
  [[nodiscard]] double time_s() const { return time_s_; }
  [[nodiscard]] double duration_s() const { return time_s_ - start_time_s_; }  ///< of the present submap

 private:
  LandmarkMap map_;
  bool started_ = false;
  bool finished_ = false;
  double start_time_s_ = 0.0;  ///< of the present submap
  double time_s_ = 0.0;
  std::vector<SubmapStep> steps_;
  std::vector<Submap> submaps_;
};

/// The estimate of a method with one map, whose base is the world: `state` with its landmarks.
[[nodiscard]] WorldEstimate single_map_estimate(const MapState& state, const std::vector<MapLandmark>& landmarks,
                                                BaseCovariance covariance);

}  // namespace ssjs
