#include "ssjs/survey/side_scan_survey.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ssjs/base/angle.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/imaging/morphology.hpp"
#include "ssjs/imaging/preprocess.hpp"
#include "ssjs/imaging/regions.hpp"
#include "ssjs/imaging/speckle_filter.hpp"

namespace ssjs {
namespace {

constexpr std::size_t kTurnPings = 5;  // before and after: a turn rate from two headings alone is noise

void set_altitudes(std::vector<SideScanPing>& pings, const SideScanSurveyConfig& config) {
  if (config.altitude == AltitudeSource::kLog) return;
  const auto is_wanted = [&](const SideScanPing& ping) {
    return config.altitude == AltitudeSource::kBottomTracking || !(ping.altitude_m > 0);
  };
  if (std::none_of(pings.begin(), pings.end(), is_wanted)) return;
  const std::vector<double> first_returns_m = track_bottom(pings, config.bottom);
  for (std::size_t i = 0; i < pings.size(); ++i) {
    if (is_wanted(pings[i])) pings[i].altitude_m = altitude_of_first_return_m(pings[i], first_returns_m[i]);
  }
}

bool turns(const std::vector<SideScanPing>& pings, std::size_t i, double most_rad_s) {
  const std::size_t first = i > kTurnPings ? i - kTurnPings : 0;
  const std::size_t last = std::min(i + kTurnPings, pings.size() - 1);
  const double time_s = pings[last].time_s - pings[first].time_s;
  const double turn = angle_difference(pings[last].heading_rad, pings[first].heading_rad);
  return time_s > 0 && std::abs(turn) > most_rad_s * time_s;  // an unknown heading does not turn
}

void mask(SurveyBlock& block, const SideScanSurveyConfig& config) {
  Waterfall& waterfall = block.waterfall;
  const int near = std::min(static_cast<int>(std::ceil(config.least_ground_range_m / waterfall.column_m)), waterfall.nadir_column);
  waterfall.valid.colRange(waterfall.nadir_column - near, waterfall.nadir_column + near).setTo(0);
  for (std::size_t i = 0; i < block.pings.size(); ++i) {
    if (turns(block.pings, i, config.most_turn_rate_rad_s)) waterfall.valid.row(static_cast<int>(i)).setTo(0);
  }
}

std::vector<ContactBox> highlights_with_shadows(const SonarImage& picture, int nadir_column, const HighlightShadowConfig& config) {
  std::vector<ContactBox> boxes;
  for (const ShadowedObject& object : highlight_shadow(picture, nadir_column, config).objects)
    boxes.push_back({object.side, object.highlight_box});
  return boxes;
}

std::vector<ContactBox> bright_regions(const SonarImage& picture, int nadir_column, const SideScanSurveyConfig& config) {
  SpeckleFilterConfig filter;
  filter.kind = SpeckleFilter::kMedian;
  filter.median_px = config.median_px;
  const SonarImage smooth{smooth_speckle(picture, filter), picture.valid};
  const std::optional<ImprovedOtsu> threshold = improved_otsu(smooth, config.improved_otsu);
  if (!threshold) return {};
  cv::Mat bright = smooth.intensity > threshold->threshold;
  bright.setTo(0, picture.valid == 0);
  std::vector<ContactBox> boxes;
  for (const Region& region : find_regions(remove_small_components(bright, config.smallest_region_px), smooth.intensity).regions)
    boxes.push_back({region.centroid_px.x < nadir_column - 0.5 ? SonarSide::kPort : SonarSide::kStarboard, region.bounding_box});
  return boxes;
}

}  // namespace

HighlightShadowConfig SideScanSurveyConfig::default_highlight_shadow() {
  HighlightShadowConfig config;
  config.median_px = 3;
  config.levels = EchoLevels::kGrey;
  config.shadow_grey = 36;
  config.highlight_grey = 130;
  config.shadow_dilations = 2;
  config.highlight_dilations = 1;
  config.smallest_shadow_px = 30;
  config.smallest_highlight_px = 12;
  config.smallest_contact_px = 2;
  return config;
}

std::vector<std::string> SideScanSurveyConfig::violations() const {
  std::vector<std::string> found = ssjs::violations(*this);
  if (!(2 * overlap_pings <= block_pings))
    found.push_back("overlap_pings = " + std::to_string(overlap_pings) + ": must be at most half of block_pings");
  return found;
}

SurveyBlock survey_block(std::vector<SideScanPing> pings, const SideScanSurveyConfig& config, const CascadeContacts* cascade) {
  SurveyBlock block;
  block.pings = std::move(pings);
  set_altitudes(block.pings, config);
  WaterfallConfig shape;
  shape.channel_pair = config.channel_pair;
  shape.column_m = config.column_m;
  block.waterfall = ground_waterfall(block.pings, shape);
  mask(block, config);
  GainConfig gain;
  gain.kind = GainNormalisation::kColumnMedian;
  gain.target_level = config.contact.seabed_level;
  block.grey = normalise_gain(in_16_bits(block.waterfall), gain);
  const SonarImage picture{block.grey, block.waterfall.valid};
  switch (config.detector) {
    case ContactDetector::kHighlightShadow:
      block.boxes = highlights_with_shadows(picture, block.waterfall.nadir_column, config.highlight_shadow);
      break;
    case ContactDetector::kImprovedOtsu:
      block.boxes = bright_regions(picture, block.waterfall.nadir_column, config);
      break;
    case ContactDetector::kCascade:
      if (cascade != nullptr) block.boxes = cascade->boxes(picture, block.waterfall.nadir_column);
      break;
  }
  return block;
}

SideScanSurvey::SideScanSurvey(const SideScanSurveyConfig& config, const std::optional<HaarCascade>& model, BlockSink sink)
    : config_(config), sink_(std::move(sink)) {
  throw_if_any(config.violations());
  if (config.detector != ContactDetector::kCascade) return;
  if (!model) throw InvalidArgument("detector", "cascade", "needs a model: give cascade_model");
  cascade_.emplace(*model, config.cascade);
}

std::vector<SideScanContact> SideScanSurvey::process(std::uint64_t core_end) {
  const SurveyBlock block = survey_block(pings_, config_, cascade_ ? &*cascade_ : nullptr);
  const ContactPicture picture{block.pings, block.waterfall, block.grey, first_index_};
  std::vector<SideScanContact> contacts;
  for (const ContactBox& box : block.boxes) {
    const auto contact = measure_contact(picture, box, config_.contact, config_.geometry);
    if (contact) contacts.push_back(*contact);
  }
  contacts = merge_contacts(std::move(contacts), config_.contact.merge_m);
  for (SideScanContact& contact : contacts) {
    if (contact.pieces > 1) contact = measure_whole(picture, contact, config_.contact, config_.geometry);
  }
  const auto is_others = [&](const SideScanContact& contact) { return contact.index < core_begin_ || contact.index >= core_end; };
  contacts.erase(std::remove_if(contacts.begin(), contacts.end(), is_others), contacts.end());
  if (sink_) sink_({block, contacts, first_index_, core_begin_, core_end});
  core_begin_ = core_end;
  return contacts;
}

std::vector<SideScanContact> SideScanSurvey::feed(SideScanPing ping) {
  pings_.push_back(std::move(ping));
  if (pings_.size() < static_cast<std::size_t>(config_.block_pings)) return {};
  const auto kept = static_cast<std::ptrdiff_t>(config_.overlap_pings);
  const std::uint64_t end = first_index_ + pings_.size();
  std::vector<SideScanContact> contacts = process(end - static_cast<std::uint64_t>(kept / 2));
  pings_.erase(pings_.begin(), pings_.end() - kept);
  first_index_ = end - static_cast<std::uint64_t>(kept);
  return contacts;
}

std::vector<SideScanContact> SideScanSurvey::finish() {
  if (pings_.empty()) return {};
  const std::uint64_t end = first_index_ + pings_.size();
  std::vector<SideScanContact> contacts;
  if (pings_.size() > 1 && core_begin_ < end) contacts = process(end);
  pings_.clear();
  first_index_ = core_begin_ = end;
  return contacts;
}

}  // namespace ssjs
