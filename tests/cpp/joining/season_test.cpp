#include "ssjs/joining/season.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "joining/gaussian_world.hpp"
#include "ssjs/base/angle.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/evaluation/consistency.hpp"
#include "ssjs/joining/chance_alignment.hpp"

namespace ssjs {
namespace {

using testing::correlated_covariance;
using testing::normal_vector;

/// Objects on a square of this side, and missions that each see those of a square of half the side.
struct Sea {
  double side_m = 240.0;
  int objects = 70;
  int missions = 6;
  double landmark_m = 0.4;
  double common_m = 0.8;  ///< error that all landmarks of a mission share
  double origin_m = 3.0;
  double turn_rad = 0.01;
  double false_per_mission = 2.0;
};

struct Drawn {
  std::vector<MissionMap> missions;
  std::vector<std::vector<int>> objects;  ///< by mission, of each landmark; negative: of nothing
  std::vector<Eigen::Vector3d> places;    ///< of the objects
  std::vector<Se2> frames;
};

Drawn draw(const Sea& sea, Rng& rng, const Eigen::Vector2d& corner = Eigen::Vector2d::Zero()) {
  Drawn drawn;
  for (int i = 0; i < sea.objects; ++i) {
    const double x = rng.uniform(0.0, sea.side_m);
    const double y = rng.uniform(0.0, sea.side_m);
    drawn.places.emplace_back(corner.x() + x, corner.y() + y, 16.0 + rng.normal(0.3));
  }
  for (int k = 0; k < sea.missions; ++k) {
    const double north = rng.uniform(0.0, 0.5 * sea.side_m);
    const double east = rng.uniform(0.0, 0.5 * sea.side_m);
    const Se2 frame{corner.x() + north, corner.y() + east, rng.uniform(-kPi, kPi)};
    std::vector<int> seen;
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < sea.objects; ++i) {
      const Eigen::Vector3d& p = drawn.places[static_cast<std::size_t>(i)];
      const bool inside = p.x() > frame.x && p.x() < frame.x + 0.5 * sea.side_m && p.y() > frame.y && p.y() < frame.y + 0.5 * sea.side_m;
      if (!inside || rng.uniform() > 0.85) continue;
      seen.push_back(i);
      points.push_back(p);
    }
    for (int i = 0; i < static_cast<int>(sea.false_per_mission); ++i) {
      seen.push_back(-1);
      const double x = frame.x + rng.uniform(0.0, 0.5 * sea.side_m);
      points.emplace_back(x, frame.y + rng.uniform(0.0, 0.5 * sea.side_m), 16.0 + rng.normal(0.3));
    }
    MissionMap mission;
    const auto n = static_cast<Eigen::Index>(points.size());
    mission.mean.resize(3 * n);
    const Se2 inverse = frame.inverse();
    for (Eigen::Index i = 0; i < n; ++i) {
      const Eigen::Vector3d& p = points[static_cast<std::size_t>(i)];
      mission.mean.segment<2>(3 * i) = inverse * Eigen::Vector2d(p.head<2>());
      mission.mean(3 * i + 2) = p.z();
    }
    mission.covariance = correlated_covariance(rng, Eigen::VectorXd::Constant(3 * n, sea.landmark_m));
    for (Eigen::Index i = 0; i < n; ++i) {
      for (Eigen::Index j = 0; j < n; ++j) {
        mission.covariance.block<3, 3>(3 * i, 3 * j) += sea.common_m * sea.common_m * Eigen::Matrix3d::Identity();
      }
    }
    mission.mean += Eigen::LLT<Eigen::MatrixXd>(mission.covariance).matrixL() * normal_vector(rng, 3 * n);
    const Eigen::Vector3d sigmas(sea.origin_m, sea.origin_m, sea.turn_rad);
    mission.world_T_mission.covariance = sigmas.cwiseAbs2().asDiagonal();
    const Eigen::Vector3d error = sigmas.cwiseProduct(normal_vector(rng, 3));
    mission.world_T_mission.mean = Se2{frame.x + error.x(), frame.y + error.y(), wrap_angle(frame.heading + error.z())};
    drawn.missions.push_back(mission);
    drawn.objects.push_back(seen);
    drawn.frames.push_back(frame);
  }
  return drawn;
}

struct Score {
  int right = 0, wrong = 0, missed = 0;  ///< sightings beyond the first of an object: merged, merged with another's, left apart
  std::vector<double> contact_nees, frame_nees;
  std::vector<double> origin_error_m, frame_error_m;
};

void judge(const Drawn& drawn, const SeasonEstimate& season, Score& score) {
  std::map<int, int> contacts_of;  // by object
  for (const SeasonContact& contact : season.contacts) {
    std::map<int, int> of;
    for (const MissionLandmark& at : contact.sightings) ++of[drawn.objects[at.mission][at.landmark]];
    int most = 0;
    int object = -1;
    for (const auto& [id, count] : of) {
      if (id >= 0 && count > most) {
        most = count;
        object = id;
      }
    }
    const auto size = static_cast<int>(contact.sightings.size());
    if (object >= 0) {
      score.right += most - 1;
      ++contacts_of[object];
    }
    score.wrong += size - std::max(most, 1);
    if (object >= 0 && most == size && size > 1) {
      score.contact_nees.push_back(
          normalized_squared_error(contact.position - drawn.places[static_cast<std::size_t>(object)], contact.covariance));
    }
  }
  for (const auto& [object, count] : contacts_of) score.missed += count - 1;
  for (std::size_t k = 0; k < drawn.missions.size(); ++k) {
    Eigen::Vector3d error = season.world_T_mission[k].mean.vector() - drawn.frames[k].vector();
    error.z() = wrap_angle(error.z());
    score.frame_nees.push_back(normalized_squared_error(error, season.world_T_mission[k].covariance));
    score.frame_error_m.push_back(error.head<2>().norm());
    const Eigen::Vector2d first = drawn.missions[k].world_T_mission.mean.translation() - drawn.frames[k].translation();
    score.origin_error_m.push_back(first.norm());
  }
}

double mean_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

TEST(Season, W1_W3_TwentySeasonsAreMergedRightAndConsistently) {
  Score score;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Rng rng(seed);
    const Drawn drawn = draw(Sea{}, rng);
    judge(drawn, join_missions(drawn.missions, SeasonConfig{}), score);
  }
  RecordProperty("right", score.right);
  RecordProperty("wrong", score.wrong);
  RecordProperty("missed", score.missed);
  RecordProperty("contact_nees", std::to_string(mean_of(score.contact_nees)));
  RecordProperty("frame_nees", std::to_string(mean_of(score.frame_nees)));
  RecordProperty("origin_error_m", std::to_string(mean_of(score.origin_error_m)));
  RecordProperty("frame_error_m", std::to_string(mean_of(score.frame_error_m)));
  EXPECT_GT(score.right, 500);
  EXPECT_LT(score.wrong, 0.02 * score.right);
  EXPECT_LT(score.missed, 0.10 * score.right);
  // Contacts of one season share the errors of its frames: the band is that of the seasons, not of the contacts.
  const Band band = mean_band(3.0, 20);
  EXPECT_GT(mean_of(score.contact_nees), band.lower);
  EXPECT_LT(mean_of(score.contact_nees), band.upper);
  EXPECT_GT(mean_of(score.frame_nees), band.lower);
  EXPECT_LT(mean_of(score.frame_nees), band.upper);
  EXPECT_LT(mean_of(score.frame_error_m), 0.7 * mean_of(score.origin_error_m));
}

TEST(Season, W2_MissionsThatCannotOverlapDoNotMeet) {
  Rng rng(7);
  Sea sea;
  sea.missions = 3;
  Drawn here = draw(sea, rng);
  const Drawn there = draw(sea, rng, {5000.0, 0.0});
  std::vector<MissionMap> missions;
  for (std::size_t k = 0; k < here.missions.size(); ++k) {
    missions.push_back(here.missions[k]);
    missions.push_back(there.missions[k]);
  }
  const SeasonEstimate together = join_missions(missions, SeasonConfig{});
  const SeasonEstimate alone = join_missions(here.missions, SeasonConfig{});
  for (std::size_t k = 0; k < here.missions.size(); ++k) {
    EXPECT_NE(together.sites[2 * k], together.sites[2 * k + 1]);
    EXPECT_EQ(together.world_T_mission[2 * k].mean.vector(), alone.world_T_mission[k].mean.vector());
  }
}

TEST(Season, W1_AMissionAloneStaysWhereItsOriginSays) {
  Rng rng(3);
  Sea sea;
  sea.missions = 1;
  const Drawn drawn = draw(sea, rng);
  const SeasonEstimate season = join_missions(drawn.missions, SeasonConfig{});
  const MissionMap& mission = drawn.missions.front();
  EXPECT_TRUE(season.world_T_mission.front().covariance.isApprox(mission.world_T_mission.covariance, 1e-9));
  ASSERT_EQ(static_cast<Eigen::Index>(season.contacts.size()), mission.mean.size() / 3);
  for (const SeasonContact& contact : season.contacts) {
    const Eigen::Index at = 3 * static_cast<Eigen::Index>(contact.sightings.front().landmark);
    const Se2& X = mission.world_T_mission.mean;
    EXPECT_NEAR((X * Eigen::Vector2d(mission.mean.segment<2>(at)) - contact.position.head<2>()).norm(), 0.0, 1e-9);
    const Eigen::Matrix<double, 2, 3> J = act_jacobian(X, mission.mean.segment<2>(at));
    const Eigen::Matrix2d P = J * mission.world_T_mission.covariance * J.transpose() +
                              X.rotation() * mission.covariance.block<2, 2>(at, at) * X.rotation().transpose();
    EXPECT_TRUE((contact.covariance.topLeftCorner<2, 2>().isApprox(P, 1e-9)));
  }
}

TEST(Season, W4_AMissionIsInAContactOnceAtMost) {
  Rng rng(5);
  Sea sea;
  sea.objects = 300;  // neighbours 14 m apart, frames 3 m unsure
  sea.missions = 4;
  const Drawn drawn = draw(sea, rng);
  int several = 0;
  for (const SeasonContact& contact : join_missions(drawn.missions, SeasonConfig{}).contacts) {
    std::set<std::size_t> missions;
    for (const MissionLandmark& at : contact.sightings) EXPECT_TRUE(missions.insert(at.mission).second);
    several += contact.sightings.size() > 1 ? 1 : 0;
  }
  EXPECT_GT(several, 50);
}

/// Contacts of two missions over different objects at one place that were merged all the same, and seasons with any.
std::pair<int, int> merged_by_chance(const SeasonConfig& config) {
  int contacts = 0;
  int seasons = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Rng rng(1000 + seed);
    Sea sea;
    sea.missions = 1;
    sea.side_m = 120.0;
    sea.objects = 60;
    const Drawn one = draw(sea, rng);
    const Drawn other = draw(sea, rng);
    int merged = 0;
    for (const SeasonContact& contact : join_missions({one.missions.front(), other.missions.front()}, config).contacts) {
      merged += contact.sightings.size() > 1 ? 1 : 0;
    }
    contacts += merged;
    seasons += merged > 0 ? 1 : 0;
  }
  return {contacts, seasons};
}

TEST(Season, W5_ForeignLandmarksAreNotAligned) {
  SeasonConfig anything;
  anything.max_chance_alignments = 1e9;
  EXPECT_GT(merged_by_chance(anything).second, 10);  // joint compatibility and the odds of single pairs find something in every second
  const auto [contacts, seasons] = merged_by_chance(SeasonConfig{});
  RecordProperty("contacts", contacts);
  RecordProperty("seasons", seasons);
  EXPECT_LE(seasons, 2);
}

TEST(Season, W5_ExpectedAlignmentsOfIndependentAndOfCommonDisplacements) {
  const double gate = 9.0;
  const double area = kPi * gate * 0.04;
  const Eigen::MatrixXd apart =
      0.04 * Eigen::MatrixXd::Identity(6, 6);  // three pairs that know nothing of each other: one place to look at
  EXPECT_NEAR(expected_chance_alignments(apart, 10, 0.3, gate), binomial_tail(10, 1.0 - std::exp(-0.3 * area), 3), 1e-12);
  EXPECT_EQ(expected_chance_alignments(apart, 2, 0.3, gate), expected_chance_alignments(apart, 3, 0.3, gate));
  EXPECT_EQ(expected_chance_alignments(Eigen::MatrixXd(0, 0), 10, 0.3, gate), 0.0);
  // Two pairs displaced together by s^2 on top of their own n^2: n^2 + s^2 n^2/(n^2 + s^2) given the other, sqrt |S| = (n^2 + s^2)^2 - s^4.
  const double own = 0.01;
  const double common = 4.0;
  Eigen::MatrixXd S = own * Eigen::MatrixXd::Identity(4, 4);
  for (int i = 0; i < 4; ++i) {
    for (int j = i % 2; j < 4; j += 2) S(i, j) += common;
  }
  const double given = own + common * own / (own + common);
  const double places = ((own + common) * (own + common) - common * common) / (given * given);
  EXPECT_NEAR(places, 0.5 * common / own, 0.01 * places);
  EXPECT_NEAR(expected_chance_alignments(S, 10, 0.3, gate), places * binomial_tail(10, 1.0 - std::exp(-0.3 * kPi * gate * given), 2),
              1e-9 * places);
}

TEST(Season, W5_BinomialTail) {
  EXPECT_NEAR(binomial_tail(5, 0.5, 4), 6.0 / 32.0, 1e-12);
  EXPECT_NEAR(binomial_tail(3, 0.1, 1), 1.0 - 0.729, 1e-12);
  EXPECT_EQ(binomial_tail(3, 0.1, 0), 1.0);
  EXPECT_EQ(binomial_tail(3, 0.1, 4), 0.0);
  EXPECT_EQ(binomial_tail(3, 1.0, 2), 1.0);
}

TEST(Season, WhatDoesNotFitIsNamed) {
  MissionMap mission;
  mission.world_T_mission.covariance.setIdentity();
  mission.mean = Eigen::VectorXd::Zero(6);
  mission.covariance = Eigen::MatrixXd::Identity(3, 3);
  try {
    (void)join_missions({mission}, SeasonConfig{});
    FAIL() << "no error";
  } catch (const InvalidArgument& error) {
    EXPECT_NE(std::string(error.what()).find("mission 0"), std::string::npos);
  }
}

}  // namespace
}  // namespace ssjs
