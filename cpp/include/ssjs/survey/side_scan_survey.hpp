/// Pings in, contacts out: the survey as it is flown. docs/math/side_scan.md
/// block of pings -> altitude -> ground-range waterfall -> gain -> detector -> contacts in metres -> pieces joined
#pragma once

#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/imaging/highlight_shadow.hpp"
#include "ssjs/imaging/improved_otsu.hpp"
#include "ssjs/survey/bottom_tracking.hpp"
#include "ssjs/survey/cascade_contacts.hpp"
#include "ssjs/survey/contact.hpp"
#include "ssjs/survey/side_scan_geometry.hpp"
#include "ssjs/survey/waterfall.hpp"

namespace ssjs {

enum class ContactDetector {
  kHighlightShadow,  ///< a highlight with a shadow that touches it
  kImprovedOtsu,     ///< regions of the improved Otsu threshold, verified by a shadow behind them
  kCascade,          ///< a trained cascade; the contours it knows may verify
};

enum class AltitudeSource {
  kLog,             ///< pings without altitude show nothing
  kBottomTracking,  ///< the first bottom return, whatever the log says
  kLogElseTracking,
};

struct SideScanSurveyConfig {
  int block_pings = 400;
  int overlap_pings = 80;
  int channel_pair = 0;
  double column_m = 0.1;
  double least_ground_range_m = 1.0;
  double most_turn_rate_rad_s = 0.06;
  AltitudeSource altitude = AltitudeSource::kLogElseTracking;
  ContactDetector detector = ContactDetector::kHighlightShadow;
  HighlightShadowConfig highlight_shadow = default_highlight_shadow();
  ImprovedOtsuConfig improved_otsu;
  CascadeContactsConfig cascade;
  int median_px = 3;
  int smallest_region_px = 12;
  ContactConfig contact;
  BottomTrackingConfig bottom;
  SideScanGeometryConfig geometry;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("block_pings", block_pings, Rule::at_least(32), "pings worked on together");
    v.field("overlap_pings", overlap_pings, Rule::at_least(2), "of neighbouring blocks; more than an object and its merging distance");
    v.field("channel_pair", channel_pair, Rule::at_least(0), "which port and starboard channels, where a sonar has several frequencies");
    v.field("column_m", column_m, Rule::positive(), "ground range of a column of the picture");
    v.field("least_ground_range_m", least_ground_range_m, Rule::not_negative(), "nothing is looked for nearer to the nadir");
    v.field("most_turn_rate_rad_s", most_turn_rate_rad_s, Rule::positive(), "nothing is looked for in sharper turns");
    v.choice("altitude", altitude,
             Choices<AltitudeSource>{{"log", AltitudeSource::kLog},
                                     {"bottom_tracking", AltitudeSource::kBottomTracking},
                                     {"log_else_tracking", AltitudeSource::kLogElseTracking}},
             "where the altitude comes from");
    v.choice("detector", detector,
             Choices<ContactDetector>{{"highlight_shadow", ContactDetector::kHighlightShadow},
                                      {"improved_otsu", ContactDetector::kImprovedOtsu},
                                      {"cascade", ContactDetector::kCascade}},
             "what proposes contacts");
    v.section("highlight_shadow", highlight_shadow, "of that detector");
    v.section("improved_otsu", improved_otsu, "of that detector");
    v.section("cascade", cascade, "of that detector");
    v.field("median_px", median_px, Rule::closed(3, 31), "improved_otsu: side of the median filter before it, odd");
    v.field("smallest_region_px", smallest_region_px, Rule::at_least(1), "improved_otsu: smaller regions are dropped");
    v.section("contact", contact, "measuring contacts");
    v.section("bottom", bottom, "bottom tracking");
    v.section("geometry", geometry, "mounting and accuracy of the sonar");
  }

  /// Every violation, rules beyond single fields included; empty when valid.
  [[nodiscard]] std::vector<std::string> violations() const;

  /// Levels and sizes for pictures of `column_m` with rows of some decimetres.
  [[nodiscard]] static HighlightShadowConfig default_highlight_shadow();
};

/// Pings worked on together, in the pictures that the contacts come from.
struct SurveyBlock {
  std::vector<SideScanPing> pings;  ///< with their altitudes
  Waterfall waterfall;              ///< in ground range, turns and the nadir not valid
  cv::Mat grey;                     ///< CV_8U, gain normalised
  std::vector<ContactBox> boxes;    ///< what the detector proposes
};

/// A block whose contacts are complete. Its own pings are core_begin .. core_end - 1; the others are those of its neighbours.
struct FinishedBlock {
  const SurveyBlock& block;
  const std::vector<SideScanContact>& contacts;
  std::uint64_t first_index;  ///< of the first row, counted from 0 in the order the pings were fed
  std::uint64_t core_begin;
  std::uint64_t core_end;
};

/// Called once a block, in their order: for what wants the pictures too.
using BlockSink = std::function<void(const FinishedBlock&)>;

/// Holds the pings of one block, whatever the length of the mission.
class SideScanSurvey {
 public:
  /// `model`: of the detector that needs one. Throws InvalidArgument listing every violation, without a model where one is needed, and for
  /// one that cannot be used (CascadeContacts).
  explicit SideScanSurvey(const SideScanSurveyConfig& config, const std::optional<HaarCascade>& model = std::nullopt, BlockSink sink = {});

  /// The contacts that are complete with this ping: none until a block is full. Pings come in the order they were sent.
  [[nodiscard]] std::vector<SideScanContact> feed(SideScanPing ping);
  /// Those of the pings still held; the survey is empty afterwards and may go on.
  [[nodiscard]] std::vector<SideScanContact> finish();

 private:
  [[nodiscard]] std::vector<SideScanContact> process(std::uint64_t core_end);

  SideScanSurveyConfig config_;
  BlockSink sink_;
  std::optional<CascadeContacts> cascade_;
  std::vector<SideScanPing> pings_;
  std::uint64_t first_index_ = 0;  ///< of pings_.front()
  std::uint64_t core_begin_ = 0;   ///< contacts before it have been given out
};

/// The work on one block, without joining and cutting at its ends: for pictures and studies. `cascade`: of that detector; without it
/// that one proposes nothing.
[[nodiscard]] SurveyBlock survey_block(std::vector<SideScanPing> pings, const SideScanSurveyConfig& config,
                                       const CascadeContacts* cascade = nullptr);

}  // namespace ssjs
