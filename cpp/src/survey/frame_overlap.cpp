#include "ssjs/survey/frame_overlap.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ssjs/base/error.hpp"

namespace ssjs {

std::vector<std::array<int, 2>> overlapping_frames(const Eigen::Ref<const Eigen::MatrixX3d>& pose,
                                                   const Eigen::Ref<const Eigen::VectorXd>& variance, double frame_width,
                                                   const FrameOverlapConfig& config) {
  if (variance.size() != pose.rows()) throw InvalidArgument("variance", static_cast<int>(variance.size()), "must be one for each pose");
  std::vector<std::array<int, 2>> pairs;
  for (int later = 2; later < static_cast<int>(pose.rows()); ++later) {
    std::vector<std::pair<double, int>> near;
    for (int earlier = 0; earlier + 1 < later; ++earlier) {
      const double distance = (pose.row(later).head<2>() - pose.row(earlier).head<2>()).norm();
      const double sigma = std::sqrt(std::max(variance(later) + variance(earlier), 0.0));
      if (distance < config.revisit_overlap * frame_width + config.revisit_sigmas * sigma) near.emplace_back(distance, earlier);  // (V-21)
    }
    std::sort(near.begin(), near.end());
    near.resize(std::min(near.size(), static_cast<std::size_t>(config.revisit_candidates)));
    for (const auto& [distance, earlier] : near) pairs.push_back({earlier, later});
  }
  return pairs;
}

}  // namespace ssjs
