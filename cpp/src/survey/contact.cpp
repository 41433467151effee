#include "ssjs/survey/contact.hpp"

#include <algorithm>
#include <cmath>

#include "ssjs/base/angle.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/imaging/shadow_height.hpp"

namespace ssjs {
namespace {

double or_zero(double value) { return std::isfinite(value) ? value : 0.0; }

/// One side of some rows with the range growing: mean grey over the rows, and whether any of them was recorded there.
struct RangeProfile {
  std::vector<double> grey;
  std::vector<bool> recorded;
};

RangeProfile profile_of(const ContactPicture& picture, SonarSide side, int first_row, int last_row) {
  const Waterfall& waterfall = picture.waterfall;
  const auto columns =
      static_cast<std::size_t>(side == SonarSide::kStarboard ? picture.grey.cols - waterfall.nadir_column : waterfall.nadir_column);
  RangeProfile profile{std::vector<double>(columns, 0.0), std::vector<bool>(columns, false)};
  for (std::size_t k = 0; k < columns; ++k) {
    const int column =
        side == SonarSide::kStarboard ? waterfall.nadir_column + static_cast<int>(k) : waterfall.nadir_column - 1 - static_cast<int>(k);
    int count = 0;
    for (int row = first_row; row <= last_row; ++row) {
      if (waterfall.valid.at<unsigned char>(row, column) == 0) continue;
      profile.grey[k] += picture.grey.at<unsigned char>(row, column);
      ++count;
    }
    profile.recorded[k] = count > 0;
    if (count > 0) profile.grey[k] /= count;
  }
  return profile;
}

/// (SS-17) Edges of the shadow behind `far`, in columns from the nadir with a fraction; none without one.
struct ShadowEdges {
  double start = 0;
  double end = 0;
  double mean_grey = 0;
  bool is_cut = false;
};

/// Where the profile passes the level between two columns.
double crossing(double before, double behind, double level) { return std::clamp((level - before) / (behind - before), 0.0, 1.0); }

std::optional<ShadowEdges> shadow_behind(const RangeProfile& profile, int near, int far, int gap, double level) {
  const int size = static_cast<int>(profile.grey.size());
  const auto grey = [&](int k) { return profile.grey[static_cast<std::size_t>(k)]; };
  const auto smooth = [&](int k) {  // three columns: a speckle does not end a shadow
    const int low = std::max(k - 1, 0);
    const int high = std::min(k + 1, size - 1);
    double sum = 0;
    for (int i = low; i <= high; ++i) sum += grey(i);
    return sum / (high - low + 1);
  };
  int first = std::max(near + 1, far - gap);
  while (first < std::min(far + gap + 1, size) && !(profile.recorded[static_cast<std::size_t>(first)] && grey(first) < level)) ++first;
  if (first >= std::min(far + gap + 1, size)) return std::nullopt;
  int end = first;
  while (end < size && profile.recorded[static_cast<std::size_t>(end)] && (grey(end) < level || smooth(end) < level)) ++end;
  ShadowEdges edges;
  edges.is_cut = end == size || !profile.recorded[static_cast<std::size_t>(end)];
  // Column k covers k .. k + 1 and its level is that of its middle.
  edges.start = first > 0 && grey(first - 1) > grey(first) ? first - 0.5 + crossing(grey(first - 1), grey(first), level) : first;
  edges.end = edges.is_cut ? end : end - 0.5 + crossing(grey(end - 1), grey(end), level);
  if (!(edges.end > edges.start)) return std::nullopt;
  for (int k = first; k < end; ++k) edges.mean_grey += grey(k) / (end - first);
  return edges;
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
  const int middle = box.y + (box.height - 1) / 2;
  const SideScanPing& ping = picture.pings[static_cast<std::size_t>(middle)];
  if (!(ping.altitude_m > 0)) return std::nullopt;

  // Columns from the nadir: the echo covers near .. far + 1.
  const bool starboard = detected.side == SonarSide::kStarboard;
  const int near = starboard ? box.x - waterfall.nadir_column : waterfall.nadir_column - box.x - box.width;
  const int far = near + box.width - 1;
  const int trim = box.height / 4;  // the middle half: ends of an object are lower than its middle
  const RangeProfile profile = profile_of(picture, detected.side, box.y + trim, box.y + box.height - 1 - trim);
  const double level = config.dark_part * config.seabed_level;
  const int gap = static_cast<int>(std::lround(config.shadow_gap_m / waterfall.column_m));
  const std::optional<ShadowEdges> shadow = shadow_behind(profile, near, far, gap, level);
  if (!shadow || (shadow->end - shadow->start) * waterfall.column_m < config.least_shadow_m) return std::nullopt;

  const double first_m = first_return_m(ping);
  const auto slant = [&](double column) { return std::hypot(column * waterfall.column_m, first_m); };
  SideScanContact contact;
  contact.shadow_is_cut = shadow->is_cut;
  contact.shadow_m = (shadow->end - shadow->start) * waterfall.column_m;
  const double height_m = height_from_shadow_m(first_m, slant(shadow->start), slant(shadow->end), ShadowRanges::kSlantTop);
  contact.height_m = height_m;

  // (SS-18) The echo runs from its foot or its near upper edge to the start of the shadow, which is its top.
  const double end_column = std::max(shadow->start, near + 1.0);
  const double echo_slant_m = slant(0.5 * (near + end_column));
  const double above_m = std::max(first_m - 0.5 * height_m, 0.0);
  contact.ground_range_m = std::sqrt(std::max(0.0, (echo_slant_m - above_m) * (echo_slant_m + above_m)));
  contact.slant_range_m = std::hypot(contact.ground_range_m, first_m);
  contact.width_m = (end_column - near) * waterfall.column_m;
  const auto first_row = static_cast<std::size_t>(std::max(middle - 5, 0));
  const auto last_row = std::min(static_cast<std::size_t>(middle) + 5, picture.pings.size() - 1);
  const double spacing_m = row_spacing_m(picture.pings, first_row, last_row);
  contact.length_m = std::max(box.height * spacing_m - geometry.beam_width_rad * contact.slant_range_m, spacing_m);

  // (SS-19) how far echo and shadow stand out of the seabed
  double bright = 0;
  for (int k = near; k <= far; ++k) bright = std::max(bright, profile.grey[static_cast<std::size_t>(k)]);
  const double highlight_part = bright > 0 ? std::max(0.0, 1.0 - config.seabed_level / bright) : 0.0;
  const double shadow_part = std::max(0.0, 1.0 - shadow->mean_grey / config.seabed_level);
  contact.confidence = std::sqrt(highlight_part * shadow_part);
  if (contact.confidence < config.least_confidence) return std::nullopt;

  SideScanGeometryConfig measured = geometry;
  if (std::isfinite(ping.speed_m_s)) measured.speed_m_s = ping.speed_m_s;
  measured.sample_m = std::max(geometry.sample_m, waterfall.column_m);
  const std::optional<SideScanPoint> point =
      body_point({detected.side, contact.slant_range_m, ping.altitude_m, or_zero(ping.roll_rad), or_zero(ping.pitch_rad)}, measured);
  if (!point) return std::nullopt;
  contact.body_p_contact = *point;
  const SideScanChannel* channel = channel_of(ping, detected.side, 0);
  if (channel) contact.sample = sample_at_slant_range(ping, *channel, contact.slant_range_m);
  contact.ping = ping.number;
  contact.navigation = ping;
  contact.navigation.channels.clear();
  contact.time_s = ping.time_s;
  contact.side = detected.side;
  contact.index = picture.first_index + static_cast<std::uint64_t>(middle);
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
