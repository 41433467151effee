/// An object found in the pings of a side-scan sonar, in metres. docs/math/side_scan.md (SS-17) to (SS-19)
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/base/sonar_side.hpp"
#include "ssjs/sensors/side_scan_ping.hpp"
#include "ssjs/survey/side_scan_geometry.hpp"
#include "ssjs/survey/waterfall.hpp"

namespace ssjs {

/// Where a detector says an object is, in a ground-range waterfall.
struct ContactBox {
  SonarSide side = SonarSide::kStarboard;
  cv::Rect box;  ///< of its echo, columns and rows
};

struct SideScanContact {
  std::uint32_t ping = 0;   ///< number of the ping that it is abeam of
  std::uint64_t index = 0;  ///< of that ping, counted from 0 in the order they were fed
  double time_s = SideScanPing::kUnknown;
  SonarSide side = SonarSide::kStarboard;
  double slant_range_m = 0.0;
  double ground_range_m = 0.0;     ///< of its middle, flat seabed
  double sample = 0.0;             ///< of the slant range
  SideScanPoint body_p_contact;    ///< its foot, body frame of that ping; see SideScanGeometryConfig for what the covariance holds
  double length_m = 0.0;           ///< along track, less the width of the beam
  double width_m = 0.0;            ///< across track, of what echoes
  std::optional<double> height_m;  ///< from the shadow; none without one
  double shadow_m = 0.0;           ///< length of the shadow on the ground
  bool shadow_is_cut = false;      ///< it runs out of what was recorded: the height is a lower bound
  double confidence = 0.0;         ///< 0 .. 1
  int pieces = 1;                  ///< detections that are this object
  std::uint64_t first_index = 0;   ///< pings in which it echoes
  std::uint64_t last_index = 0;
  cv::Rect box;             ///< of the detector, or of all pieces together; rows and columns of the picture that it was measured in
  double traced_m = 0.0;    ///< length of all pieces together, as each was measured
  double row_m = 0.0;       ///< distance along track of the rows of the picture it was found in
  double column_m = 0.0;    ///< ground range of its columns
  SideScanPing navigation;  ///< the ping abeam without its channels: where the sonar was, with the altitude that was used
};

struct ContactConfig {
  double seabed_level = 64.0;
  double dark_part = 0.7;
  double shadow_gap_m = 0.4;
  double least_shadow_m = 0.3;
  double least_cut_shadow_m = 1.0;
  double least_height_m = 0.1;
  double least_confidence = 0.61;
  double merge_m = 1.0;
  double structure_m = 5.0;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("seabed_level", seabed_level, Rule{0, 255, true, false}, "of the seabed in the picture after gain normalisation");
    v.field("dark_part", dark_part, Rule::open(0, 1), "a shadow is darker than this part of the seabed");
    v.field("shadow_gap_m", shadow_gap_m, Rule::not_negative(), "range between echo and shadow that is bridged");
    v.field("least_shadow_m", least_shadow_m, Rule::not_negative(), "shorter ones are speckle");
    v.field("least_cut_shadow_m", least_cut_shadow_m, Rule::not_negative(), "the same where a shadow runs out of what was recorded");
    v.field("least_height_m", least_height_m, Rule::not_negative(), "what rises less is ripples and speckle");
    v.field("least_confidence", least_confidence, Rule::closed(0, 1), "contacts below it are dropped");
    v.field("merge_m", merge_m, Rule::not_negative(), "contacts of one side nearer than this along and across track are one");
    v.field("structure_m", structure_m, Rule::positive(),
            "pieces that reach farther along track without being one object are the parts of a wreck or the like, one contact");
  }
};

/// The picture a contact is measured in: pings and their ground-range waterfall, row by row, gain normalised to 8 bits.
struct ContactPicture {
  const std::vector<SideScanPing>& pings;
  const Waterfall& waterfall;
  const cv::Mat& grey;        ///< CV_8U of the waterfall's size
  std::uint64_t first_index;  ///< of the first row's ping
};

/// None where there is no shadow, where the confidence is too low and where the ping abeam has no altitude.
[[nodiscard]] std::optional<SideScanContact> measure_contact(const ContactPicture& picture, const ContactBox& detected,
                                                             const ContactConfig& config, const SideScanGeometryConfig& geometry);

/// Contacts of one side whose extents are nearer than `merge_m` become one: the measures are those of the surest piece, extent and box
/// those of all, so that it can be measured again. In the order of pings, port before starboard.
[[nodiscard]] std::vector<SideScanContact> merge_contacts(std::vector<SideScanContact> contacts, double merge_m);

/// What merge_contacts() made of several pieces, measured again in the box of all: one object; or something of many parts, like a wreck,
/// whose place and size are those of the box, in which its middle may lie anywhere; or neither, a piece beside noise: then it stays what it
/// is. (SS-36)
[[nodiscard]] SideScanContact measure_whole(const ContactPicture& picture, const SideScanContact& pieces, const ContactConfig& config,
                                            const SideScanGeometryConfig& geometry);

/// Metres along track between neighbouring rows, from projected positions, else from speed and time, else from
/// latitude and longitude (whose fixes often repeat); throws InvalidArgument where neither is known.
[[nodiscard]] double row_spacing_m(const std::vector<SideScanPing>& pings, std::size_t first, std::size_t last);

}  // namespace ssjs
