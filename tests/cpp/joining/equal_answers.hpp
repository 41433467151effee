/// Whether two methods gave the same answer.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <map>

#include "ssjs/joining/map_joiner.hpp"

namespace ssjs::testing {

/// Largest differences over all landmarks, found by their identity.
struct AnswerDifference {
  double mean_m = 0.0;
  double covariance = 0.0;           ///< m^2
  double relative_covariance = 0.0;  ///< in units of the covariance's trace
  int sightings = 0;                 ///< landmarks seen another number of times

  AnswerDifference(const WorldEstimate& a, const WorldEstimate& b) {
    EXPECT_EQ(a.landmarks.size(), b.landmarks.size());
    std::map<std::int64_t, LandmarkEstimate> by_identity;
    for (const LandmarkEstimate& landmark : b.landmarks) by_identity[*landmark.landmark.source_id] = landmark;
    EXPECT_EQ(by_identity.size(), b.landmarks.size());
    for (const LandmarkEstimate& landmark : a.landmarks) {
      const auto found = by_identity.find(*landmark.landmark.source_id);
      if (found == by_identity.end()) {
        ADD_FAILURE() << "landmark " << *landmark.landmark.source_id << " is in one answer only";
        continue;
      }
      const LandmarkEstimate& other = found->second;
      const double difference = (landmark.position.covariance - other.position.covariance).cwiseAbs().maxCoeff<Eigen::PropagateNaN>();
      EXPECT_TRUE(std::isfinite(difference));
      mean_m = std::max(mean_m, (landmark.position.mean - other.position.mean).norm());
      covariance = std::max(covariance, difference);
      relative_covariance = std::max(relative_covariance, difference / other.position.covariance.trace());
      sightings += landmark.landmark.times_seen != other.landmark.times_seen ? 1 : 0;
    }
  }
};

}  // namespace ssjs::testing
