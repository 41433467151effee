#include "ssjs/survey/contact.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ssjs/base/angle.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/survey/object_centre.hpp"
#include "ssjs/survey/object_trace.hpp"

namespace ssjs {
namespace {

constexpr double kLeastPartInOne = 0.5;         // of the length of all pieces, where they are one object
constexpr double kLeastPartTraced = 1.0 / 3.0;  // of the length of a structure, by its pieces; a box of noise holds less

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
double along_variance_rows(const ObjectTrace& trace, const cv::Rect& box, int rows) {
  const double apart = 0.5 * (trace.rows.first + trace.rows.end) - (box.y + 0.5 * box.height);
  const bool is_cut = trace.rows.first <= 0 || trace.rows.end >= rows;
  const double missing = is_cut ? trace.rows.end - trace.rows.first : 0.0;
  return 1.0 / 24.0 + apart * apart / 12.0 + missing * missing;
}

/// Of an object whose measures are known but for those along track, and whose box is.
struct Extent {
  RowExtent rows;
  double across_sigma_m = 0;       ///< of its middle, on the ground
  double along_variance_rows = 0;  ///< of its middle, rows squared
};

double middle_of(const RowExtent& rows) { return 0.5 * (rows.first + rows.end) - 0.5; }  // row r is the ping at r

std::size_t row_abeam(const ContactPicture& picture, double middle) {
  return static_cast<std::size_t>(std::clamp(std::lround(middle), 0L, static_cast<long>(picture.pings.size()) - 1));
}

const SideScanPing& ping_abeam(const ContactPicture& picture, double middle) { return picture.pings[row_abeam(picture, middle)]; }

/// The contact where it lies, with the ping it is abeam of. None where that ping has no altitude or sees no ground so near.
std::optional<SideScanContact> placed(const ContactPicture& picture, SideScanContact contact, const Extent& extent,
                                      const SideScanGeometryConfig& geometry) {
  const double middle = middle_of(extent.rows);
  const std::size_t abeam = row_abeam(picture, middle);
  const SideScanPing& ping = picture.pings[abeam];
  if (!(ping.altitude_m > 0)) return std::nullopt;
  const cv::Rect& box = contact.box;
  contact.slant_range_m = std::hypot(contact.ground_range_m, first_return_m(ping));
  const std::size_t first_row = abeam > 5 ? abeam - 5 : 0;
  const std::size_t last_row = std::min(abeam + 5, picture.pings.size() - 1);
  const double spacing_m = row_spacing_m(picture.pings, first_row, last_row);
  contact.row_m = spacing_m;
  contact.column_m = picture.waterfall.column_m;
  contact.length_m =
      std::max((extent.rows.end - extent.rows.first) * spacing_m - geometry.beam_width_rad * contact.slant_range_m, spacing_m);

  contact.traced_m = contact.length_m;
  SideScanGeometryConfig measured = geometry;
  if (std::isfinite(ping.speed_m_s)) measured.speed_m_s = ping.speed_m_s;
  measured.sample_m = std::max(geometry.sample_m, picture.waterfall.column_m);
  measured.range_sigma_m = std::hypot(geometry.range_sigma_m, extent.across_sigma_m * contact.ground_range_m / contact.slant_range_m);
  std::optional<SideScanPoint> point =
      body_point({contact.side, contact.slant_range_m, ping.altitude_m, or_zero(ping.roll_rad), or_zero(ping.pitch_rad)}, measured);
  if (!point) return std::nullopt;
  point->position_m.x() += (middle - static_cast<double>(abeam)) * spacing_m;
  point->covariance_m2(0, 0) += spacing_m * spacing_m * extent.along_variance_rows;  // (SS-33)
  contact.body_p_contact = *point;
  const SideScanChannel* channel = channel_of(ping, contact.side, 0);
  if (channel) contact.sample = sample_at_slant_range(ping, *channel, contact.slant_range_m);
  contact.ping = ping.number;
  contact.navigation = ping;
  contact.navigation.channels.clear();
  contact.time_s = ping.time_s;
  contact.index = picture.first_index + abeam;
  contact.first_index = picture.first_index + static_cast<std::uint64_t>(box.y);
  contact.last_index = picture.first_index + static_cast<std::uint64_t>(box.y + box.height - 1);
  return contact;
}

/// (SS-36) The surest piece, put into the middle of the box.
std::optional<SideScanContact> measure_structure(const ContactPicture& picture, SideScanContact contact,
                                                 const SideScanGeometryConfig& geometry) {
  const cv::Rect& box = contact.box;
  const int near =
      contact.side == SonarSide::kStarboard ? box.x - picture.waterfall.nadir_column : picture.waterfall.nadir_column - box.x - box.width;
  contact.width_m = box.width * picture.waterfall.column_m;
  contact.ground_range_m = std::max(near + 0.5 * box.width, 0.0) * picture.waterfall.column_m;
  const RowExtent rows{static_cast<double>(box.y), static_cast<double>(box.y + box.height)};
  return placed(picture, contact, {rows, contact.width_m / std::sqrt(12.0), box.height * box.height / 12.0}, geometry);
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
  contact.side = detected.side;
  contact.box = box;
  // (SS-33) abeam of the middle of echo and shadow
  const double middle = middle_of(trace->rows);
  const SideScanPing& ping = ping_abeam(picture, middle);
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
  contact.width_m = centre.width_m;
  return placed(picture, contact, {trace->rows, centre.sigma_m, along_variance_rows(*trace, box, picture.grey.rows)}, geometry);
}

std::vector<SideScanContact> merge_contacts(std::vector<SideScanContact> contacts, double merge_m) {
  std::sort(contacts.begin(), contacts.end(), [](const SideScanContact& a, const SideScanContact& b) {
    if (a.first_index != b.first_index) return a.first_index < b.first_index;
    if (a.side != b.side) return a.side == SonarSide::kPort;
    return a.ground_range_m < b.ground_range_m;
  });
  const auto touches = [&](const SideScanContact& a, const SideScanContact& b) {
    if (a.side != b.side) return false;
    const cv::Rect& one = a.box;
    const cv::Rect& other = b.box;
    const int columns = std::max(one.x, other.x) - std::min(one.x + one.width, other.x + other.width);
    const double rows =
        static_cast<double>(std::max(a.first_index, b.first_index)) - static_cast<double>(std::min(a.last_index, b.last_index));
    return columns * a.column_m <= merge_m && rows * a.row_m <= merge_m;
  };
  const auto take_in = [](SideScanContact& known, const SideScanContact& other) {
    SideScanContact surest = other.confidence * other.length_m > known.confidence * known.length_m ? other : known;
    surest.first_index = std::min(known.first_index, other.first_index);
    surest.last_index = std::max(known.last_index, other.last_index);
    surest.length_m = surest.row_m * static_cast<double>(surest.last_index - surest.first_index + 1);
    surest.pieces = known.pieces + other.pieces;
    surest.traced_m = known.traced_m + other.traced_m;
    surest.box = known.box | other.box;
    known = std::move(surest);
  };
  std::vector<SideScanContact> merged;
  for (SideScanContact& contact : contacts) {
    const auto touching = [&](const SideScanContact& known) { return touches(known, contact); };
    for (auto other = std::find_if(merged.begin(), merged.end(), touching); other != merged.end();
         other = std::find_if(merged.begin(), merged.end(), touching)) {  // it may tie together what was apart
      take_in(contact, *other);
      merged.erase(other);
    }
    merged.push_back(contact);
  }
  std::sort(merged.begin(), merged.end(), [](const SideScanContact& a, const SideScanContact& b) {
    if (a.index != b.index) return a.index < b.index;
    if (a.side != b.side) return a.side == SonarSide::kPort;
    return a.ground_range_m < b.ground_range_m;
  });
  return merged;
}

SideScanContact measure_whole(const ContactPicture& picture, const SideScanContact& pieces, const ContactConfig& config,
                              const SideScanGeometryConfig& geometry) {
  std::optional<SideScanContact> whole = measure_contact(picture, {pieces.side, pieces.box}, config, geometry);
  const bool is_one_object = whole && whole->length_m > kLeastPartInOne * pieces.length_m;
  const bool is_structure = pieces.length_m > config.structure_m && pieces.traced_m > kLeastPartTraced * pieces.length_m;
  if (!is_one_object && is_structure) whole = measure_structure(picture, pieces, geometry);
  if (!whole) return pieces;
  whole->pieces = pieces.pieces;
  return *whole;
}

}  // namespace ssjs
