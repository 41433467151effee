#include "ssjs/pipeline/slam_config.hpp"

#include <sstream>

namespace ssjs {
namespace {

template <class A, class B>
std::string is(const char* key, A value, const char* rule, B other) {
  std::ostringstream text;
  text << key << " = " << value << ": " << rule << " " << other;
  return text.str();
}

}  // namespace

std::vector<std::string> SlamConfig::violations() const {
  std::vector<std::string> all = ssjs::violations(*this);
  if (!(sensor.min_range_m < sensor.max_range_m)) {
    all.push_back(is("sensor.min_range_m", sensor.min_range_m, "must be below sensor.max_range_m =", sensor.max_range_m));
  }
  if (!(trees.min_range_m < trees.max_range_m)) {
    all.push_back(is("trees.min_range_m", trees.min_range_m, "must be below trees.max_range_m =", trees.max_range_m));
  }
  if (!(trees.min_diameter_m < trees.max_diameter_m)) {
    all.push_back(is("trees.min_diameter_m", trees.min_diameter_m, "must be below trees.max_diameter_m =", trees.max_diameter_m));
  }
  if (submap.split.max_landmarks && joining.max_fused_landmarks < *submap.split.max_landmarks) {
    all.push_back(is("joining.max_fused_landmarks", joining.max_fused_landmarks,
                     "must be at least submap.max_landmarks =", *submap.split.max_landmarks));
  }
  if (aekf.max_missed_views > aekf.view_window) {
    all.push_back(is("aekf.max_missed_views", aekf.max_missed_views, "must be at most aekf.view_window =", aekf.view_window));
  }
  return all;
}

}  // namespace ssjs
