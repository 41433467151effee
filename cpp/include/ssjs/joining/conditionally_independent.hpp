/// Conditionally independent submaps (Pinies and Tardos 2008): one frame, shared landmarks copied with their covariance, the answer of
/// one filter over everything at the cost of the present map. docs/math/conditionally_independent.md.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/geometry/point_grid.hpp"
#include "ssjs/joining/conditional_chain.hpp"
#include "ssjs/joining/filter_mapper.hpp"

namespace ssjs {

struct ConditionallyIndependentConfig {
  int shared_scans = 3;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("shared_scans", shared_scans, Rule::at_least(1), "a new submap starts with the landmarks seen in so many last scans");
  }
};

class ConditionallyIndependentMapper final : public FilterMapper {
 public:
  ConditionallyIndependentMapper(const ConditionallyIndependentConfig& config, const SubmapBuilderConfig& submap,
                                 const ScanAssociationConfig& association, std::uint64_t seed);

  void predict(double time_s, const MotionPrediction& motion) override;
  [[nodiscard]] MapperReport observe(double time_s, const Features& scan) override;
  [[nodiscard]] JoinReport finish() override;
  [[nodiscard]] WorldEstimate world(BaseCovariance covariance) const override;

 private:
  void recall_seen(const Features& scan);  ///< landmarks of older maps that this scan could show
  void recall(int label);
  [[nodiscard]] SplitSituation situation(const ScanAssociation& association);
  [[nodiscard]] JoinReport close_map(const std::string& reason);
  void label_new_landmarks();
  [[nodiscard]] std::vector<TrackedLandmark> tracked_landmarks() const;

  ConditionallyIndependentConfig config_;
  SplitPolicyConfig split_;
  bool identities_known_;
  ConditionalChain chain_;
  int next_label_ = 0;
  int first_scan_ = 0;                                ///< of the present map
  double distance_m_ = 0.0;                           ///< in the present map
  std::map<int, int> recalled_;                       ///< into the present map: label -> the map that held it
  std::map<std::int64_t, int> past_identities_;       ///< known identities of past landmarks -> label
  std::vector<ConditionalChain::PastLandmark> past_;  ///< as known when the present map started
  std::optional<PointGrid> past_grid_;
  std::optional<WorldEstimate> final_;  ///< after finish(), without the joint covariance
  double past_variance_ = 0.0;          ///< the largest of past_
};

}  // namespace ssjs
