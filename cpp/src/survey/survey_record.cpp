#include "ssjs/survey/survey_record.hpp"

#include <algorithm>
#include <limits>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

int row_of(const FinishedBlock& finished, std::uint64_t index) { return static_cast<int>(index - finished.first_index); }

PictureRows rows_between(const FinishedBlock& finished, int first, int end) {
  const Waterfall& waterfall = finished.block.waterfall;
  return {finished.block.grey.rowRange(first, end).clone(), finished.first_index + static_cast<std::uint64_t>(first),
          waterfall.nadir_column, waterfall.column_m};
}

/// Near and far edge of the valid pixels between two columns, as columns away from the nadir.
std::array<double, 2> reach_of(const Waterfall& waterfall, int row, SonarSide side) {
  const auto* valid = waterfall.valid.ptr(row);
  const int nadir = waterfall.nadir_column;
  const int columns = side == SonarSide::kPort ? nadir : waterfall.valid.cols - nadir;
  const auto is_valid = [&](int k) { return valid[side == SonarSide::kPort ? nadir - 1 - k : nadir + k] != 0; };
  int near = 0;
  while (near < columns && !is_valid(near)) ++near;
  if (near == columns) return {kNone, kNone};
  int far = columns - 1;
  while (!is_valid(far)) --far;
  return {near * waterfall.column_m, (far + 1) * waterfall.column_m};
}

}  // namespace

std::vector<PingReach> own_reach(const FinishedBlock& finished) {
  std::vector<PingReach> reach;
  for (std::uint64_t index = finished.core_begin; index < finished.core_end; ++index) {
    const int row = row_of(finished, index);
    const SideScanPing& ping = finished.block.pings[static_cast<std::size_t>(row)];
    const auto [port_near, port_far] = reach_of(finished.block.waterfall, row, SonarSide::kPort);
    const auto [starboard_near, starboard_far] = reach_of(finished.block.waterfall, row, SonarSide::kStarboard);
    reach.push_back({ping.time_s, ping.altitude_m, {port_near, port_far, starboard_near, starboard_far}});
  }
  return reach;
}

PictureRows own_rows(const FinishedBlock& finished) {
  return rows_between(finished, row_of(finished, finished.core_begin), row_of(finished, finished.core_end));
}

PictureRows rows_around(const FinishedBlock& finished, const SideScanContact& contact, int around) {
  const int rows = finished.block.grey.rows;
  if (contact.index < finished.first_index || contact.index - finished.first_index >= static_cast<std::uint64_t>(rows))
    throw InvalidArgument("contact.index", static_cast<double>(contact.index), "must be a ping of the block");
  const int row = row_of(finished, contact.index);
  return rows_between(finished, std::max(row - around, 0), std::min(row + around + 1, rows));
}

}  // namespace ssjs
