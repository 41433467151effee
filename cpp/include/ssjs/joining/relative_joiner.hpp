/// The methods whose global level is a relative stochastic map: local maps hang on its bases, and a new one is compared with those that
/// the chain of links brings near it. They differ in what a loop does. docs/math/joining_methods.md (H-1..H-4, T-1..T-3).
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>

#include "ssjs/joining/loop_attempt.hpp"
#include "ssjs/joining/relative_map.hpp"
#include "ssjs/joining/selective.hpp"

namespace ssjs {

class RelativeJoiner : public MapJoiner {
 public:
  [[nodiscard]] JoinReport take(const Submap& submap) final;
  [[nodiscard]] GaussianSe2 global_T_newest_base() const final;
  JoinReport finish() final { return {}; }
  [[nodiscard]] WorldEstimate estimate(BaseCovariance covariance) const final;

  [[nodiscard]] const RelativeMap& links() const { return links_; }
  [[nodiscard]] const std::map<int, LiveMap>& maps() const { return maps_; }

 protected:
  RelativeJoiner(const SelectiveJoinerConfig& config, AssociationMethod association, std::optional<int> max_submap_landmarks,
                 std::uint64_t seed);

  /// The submap just finished among the others.
  struct NewMap {
    int base;
    double time_s;
    int needed;                             ///< pairs that a loop takes
    std::vector<int> candidates;            ///< older maps within reach, by base, the nearest first
    std::vector<GaussianSe2> base_T_fresh;  ///< from every base, by the links as they are before any loop
  };
  /// Compares the new map with the candidates and ties it to those that fit.
  virtual void close_loops(const NewMap& fresh, JoinReport& report) = 0;

  [[nodiscard]] static LoopAttempt begun(const NewMap& fresh, int candidate);
  /// Pairs of landmarks of the maps at bases a < b, or the reason why they are not to be tied.
  [[nodiscard]] std::optional<std::vector<Pair>> compare(int a, int b, const std::function<GaussianSe2()>& a_T_b, int needed,
                                                         LoopAttempt& attempt, JoinReport& report);

  [[nodiscard]] const SelectiveJoinerConfig& config() const { return config_; }
  [[nodiscard]] bool fits(LoopAttempt& attempt) const { return ssjs::fits(attempt, associator_, config_.fusion_probability); }

  [[nodiscard]] RelativeMap& mutable_links() { return links_; }
  [[nodiscard]] std::map<int, LiveMap>& mutable_maps() { return maps_; }

 private:
  [[nodiscard]] std::vector<int> candidates_for(const LiveMap& fresh, const std::vector<GaussianSe2>& base_T_fresh) const;

  SelectiveJoinerConfig config_;
  MapAssociator associator_;
  LoopRule rule_;
  RelativeMap links_;
  std::map<int, LiveMap> maps_;  ///< by base: landmarks only, the bases stand in links_
};

}  // namespace ssjs
