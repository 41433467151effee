#include "ssjs/survey/contact.hpp"

#include <algorithm>
#include <cmath>

#include "ssjs/base/angle.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/survey/object_centre.hpp"
#include "ssjs/survey/object_trace.hpp"

namespace ssjs {
namespace {

double or_zero(double value) { return std::isfinite(value) ? value : 0.0; }

TraceLevels trace_levels(const ContactConfig& config, double column_m) {
  TraceLevels levels;
  levels.seabed = config.seabed_level;
  levels.shadow = config.dark_part * config.seabed_level;
  levels.gap = static_cast<int>(std::lround(config.shadow_gap_m / column_m));
  levels.least_shadow = config.least_shadow_m / column_m;
  return levels;
}

/// (SS-33) Both ends lie anywhere in the row where they are found, the middle anywhere between what detector and trace say, and where
/// the object runs out of the picture as much may be missing as is seen.
double along_variance_m2(const ObjectTrace& trace, const cv::Rect& box, int rows, double spacing_m) {
  const double apart = 0.5 * (trace.rows.first + trace.rows.end) - (box.y + 0.5 * box.height);
  const bool is_cut = trace.rows.first <= 0 || trace.rows.end >= rows;
  const double missing = is_cut ? trace.rows.end - trace.rows.first : 0.0;
  return spacing_m * spacing_m * (1.0 / 24.0 + apart * apart / 12.0 + missing * missing);
}

}  // namespace

double row_spacing_m(const std::vector<SideScanPing>& pings, std::size_t first, std::size_t last) {
  if (last <= first || last >= pings.size()) throw InvalidArgument("rows", static_cast<double>(last), "two different pings are needed");
  const SideScanPing& a = pings[first];
  const SideScanPing& b = pings[last];
  const auto steps = static_cast<double>(last - first);
  const double moved_m = std::hypot(b.north_m - a.north_m, b.east_m - a.east_m);
  if (std::isfinite(moved_m) && moved_m > 0) return moved_m / steps;
  const double speed_m_s = std::isfinite(a.speed_m_s) ? a.speed_m_s : b.speed_m_s;
  const double spacing_m = speed_m_s * (b.time_s - a.time_s) / steps;
  if (spacing_m > 0) return spacing_m;
  constexpr double kEarthRadius_m = 6371000.0;  // a sphere will do for the distance of neighbouring pings
  const double degree_m = kEarthRadius_m * kPi / 180.0;
  const double north_m = (b.latitude_deg - a.latitude_deg) * degree_m;
  const double east_m = (b.longitude_deg - a.longitude_deg) * degree_m * std::cos(a.latitude_deg * kPi / 180.0);
  const double fixes_m = std::hypot(north_m, east_m) / steps;
  if (!(fixes_m > 0))
    throw InvalidArgument("pings", static_cast<double>(a.number),
                          "give neither positions nor speed and times, so that lengths along track are not known");
  return fixes_m;
}

std::optional<SideScanContact> measure_contact(const ContactPicture& picture, const ContactBox& detected, const ContactConfig& config,
                                               const SideScanGeometryConfig& geometry) {
  const cv::Rect box = detected.box & cv::Rect(0, 0, picture.grey.cols, picture.grey.rows);
  if (box.empty()) throw InvalidArgument("box", detected.box.x, "must lie in the picture");
  const Waterfall& waterfall = picture.waterfall;

  // Columns from the nadir: the echo covers near .. far + 1.
  const bool starboard = detected.side == SonarSide::kStarboard;
  const int near = starboard ? box.x - waterfall.nadir_column : waterfall.nadir_column - box.x - box.width;
  const cv::Range echo(std::max(near, 0), near + box.width);  // the box may reach over the nadir
  if (echo.size() <= 0) return std::nullopt;
  const SwathView upright(waterfall, picture.grey, detected.side);
  const std::optional<ObjectTrace> trace =
      trace_object(upright, {box.y, box.y + box.height}, echo, trace_levels(config, waterfall.column_m));
  if (!trace || trace->confidence < config.least_confidence) return std::nullopt;
  const ShadowEdges& shadow = trace->shadow;
  // At the end of the swath an object is seen in part.
  if (shadow.is_cut && (shadow.end - shadow.start) * waterfall.column_m < config.least_cut_shadow_m) return std::nullopt;

  SideScanContact contact;
  contact.confidence = trace->confidence;
  // (SS-33) abeam of the middle of echo and shadow
  const double middle = 0.5 * (trace->rows.first + trace->rows.end) - 0.5;  // row r is the ping at r
  const auto abeam = static_cast<std::size_t>(std::clamp(std::lround(middle), 0L, static_cast<long>(picture.pings.size()) - 1));
  const SideScanPing& ping = picture.pings[abeam];
  if (!(ping.altitude_m > 0)) return std::nullopt;

  // (SS-18), (SS-35)
  const double first_m = first_return_m(ping);
  const double moved = trace->skew * (middle - trace->middle_row);
  if (!(shadow.start + moved > 0)) return std::nullopt;
  const auto slant = [&](double column) { return std::hypot((column + moved) * waterfall.column_m, first_m); };
  const ObjectCentre centre = centre_of_object({first_m, slant(std::max(trace->near, -moved)), slant(shadow.start), slant(shadow.end)});
  if (centre.height_m < config.least_height_m) return std::nullopt;
  contact.shadow_is_cut = shadow.is_cut;
  contact.shadow_m = (shadow.end - shadow.start) * waterfall.column_m;
  contact.height_m = centre.height_m;
  contact.ground_range_m = centre.ground_range_m;
  contact.slant_range_m = std::hypot(contact.ground_range_m, first_m);
  contact.width_m = centre.width_m;
  const std::size_t first_row = abeam > 5 ? abeam - 5 : 0;
  const std::size_t last_row = std::min(abeam + 5, picture.pings.size() - 1);
  const double spacing_m = row_spacing_m(picture.pings, first_row, last_row);
  contact.length_m =
      std::max((trace->rows.end - trace->rows.first) * spacing_m - geometry.beam_width_rad * contact.slant_range_m, spacing_m);

  SideScanGeometryConfig measured = geometry;
  if (std::isfinite(ping.speed_m_s)) measured.speed_m_s = ping.speed_m_s;
  measured.sample_m = std::max(geometry.sample_m, waterfall.column_m);
  measured.range_sigma_m = std::hypot(geometry.range_sigma_m, centre.sigma_m * contact.ground_range_m / contact.slant_range_m);
  std::optional<SideScanPoint> point =
      body_point({detected.side, contact.slant_range_m, ping.altitude_m, or_zero(ping.roll_rad), or_zero(ping.pitch_rad)}, measured);
  if (!point) return std::nullopt;
  point->position_m.x() += (middle - static_cast<double>(abeam)) * spacing_m;
  point->covariance_m2(0, 0) += along_variance_m2(*trace, box, picture.grey.rows, spacing_m);  // (SS-33)
  contact.box = {detected.side, box};
  contact.body_p_contact = *point;
  const SideScanChannel* channel = channel_of(ping, detected.side, 0);
  if (channel) contact.sample = sample_at_slant_range(ping, *channel, contact.slant_range_m);
  contact.ping = ping.number;
  contact.navigation = ping;
  contact.navigation.channels.clear();
  contact.time_s = ping.time_s;
  contact.side = detected.side;
  contact.index = picture.first_index + abeam;
  contact.first_index = picture.first_index + static_cast<std::uint64_t>(box.y);
  contact.last_index = picture.first_index + static_cast<std::uint64_t>(box.y + box.height - 1);
  return contact;
}

std::vector<SideScanContact> merge_contacts(std::vector<SideScanContact> contacts, double merge_m) {
  std::sort(contacts.begin(), contacts.end(), [](const SideScanContact& a, const SideScanContact& b) {
    if (a.first_index != b.first_index) return a.first_index < b.first_index;
    if (a.side != b.side) return a.side == SonarSide::kPort;
    return a.ground_range_m < b.ground_range_m;
  });
  const auto touches = [&](const SideScanContact& a, const SideScanContact& b) {
    if (a.side != b.side) return false;
    if (std::abs(a.ground_range_m - b.ground_range_m) > 0.5 * (a.width_m + b.width_m) + merge_m) return false;
    const double rows =
        static_cast<double>(std::max(a.first_index, b.first_index)) - static_cast<double>(std::min(a.last_index, b.last_index));
    const double row_m = a.length_m / static_cast<double>(a.last_index - a.first_index + 1);
    return rows * row_m <= merge_m;
  };
  std::vector<SideScanContact> merged;
  for (SideScanContact& contact : contacts) {
    const auto other = std::find_if(merged.begin(), merged.end(), [&](const SideScanContact& known) { return touches(known, contact); });
    if (other == merged.end()) {
      merged.push_back(contact);
      continue;
    }
    SideScanContact surest = contact.confidence * contact.length_m > other->confidence * other->length_m ? contact : *other;
    const double row_m = surest.length_m / static_cast<double>(surest.last_index - surest.first_index + 1);
    surest.first_index = std::min(other->first_index, contact.first_index);
    surest.last_index = std::max(other->last_index, contact.last_index);
    surest.length_m = row_m * static_cast<double>(surest.last_index - surest.first_index + 1);
    surest.pieces = other->pieces + contact.pieces;
    surest.box.box = other->box.box | contact.box.box;
    *other = surest;
  }
  std::sort(merged.begin(), merged.end(), [](const SideScanContact& a, const SideScanContact& b) {
    if (a.index != b.index) return a.index < b.index;
    if (a.side != b.side) return a.side == SonarSide::kPort;
    return a.ground_range_m < b.ground_range_m;
  });
  return merged;
}

}  // namespace ssjs
