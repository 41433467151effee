/// A world in which joining is linear, so that every order of joins gives the batch solution to rounding: headings are known and positions
/// are not. Positions have standard deviations of 100 m; the variance that live_map_of() adds to an exit heading (1e-12) moves a point
/// 100 m away by 1e-4 m, a millionth of that, and what constraints are softened by (1e-12 m^2) is 1e-16 of a variance.
#pragma once

#include <map>

#include "joining/gaussian_world.hpp"

namespace ssjs::testing {

struct LinearWorld {
  static constexpr double kSigma_m = 100.0;
  World truth{{Se2{}}, Eigen::Matrix2Xd(2, 40)};
  std::vector<Submap> submaps;

  LinearWorld(int count, Rng& rng) {
    for (int k = 0; k < count; ++k) {
      truth.global_T_base.push_back(truth.global_T_base.back() *
                                    Se2{rng.uniform(5.0, 15.0), rng.uniform(-5.0, 5.0), rng.uniform(-1.0, 1.0)});
    }
    for (Eigen::Index i = 0; i < truth.landmarks.cols(); ++i) truth.landmarks.col(i) << rng.uniform(-50.0, 50.0), rng.uniform(-50.0, 50.0);
    for (int k = 0; k < count; ++k) {
      std::vector<int> seen;  // some common with the neighbours, some only seen again much later
      for (int i = 0; i < 40; ++i) {
        if ((i + 5 * k) % 40 < 8 || (i + k) % 9 == 0) seen.push_back(i);
      }
      submaps.push_back(noisy_submap(truth, k, seen, kSigma_m, rng));
      Submap& submap = submaps.back();
      submap.state.covariance.row(2).setZero();
      submap.state.covariance.col(2).setZero();
      submap.state.mean(2) =
          (truth.global_T_base[static_cast<std::size_t>(k)].inverse() * truth.global_T_base[static_cast<std::size_t>(k) + 1]).heading;
    }
  }
};

/// All positions at once: bases 1..count, then the landmarks seen, by weighted linear least squares with the true headings.
struct LinearBatch {
  int bases;
  std::map<int, Eigen::Index> landmark_at;
  Eigen::VectorXd y;
  Eigen::MatrixXd covariance;

  LinearBatch(const LinearWorld& world, int count) : bases(count) {
    for (int k = 0; k < count; ++k) {
      for (const MapLandmark& landmark : world.submaps[static_cast<std::size_t>(k)].landmarks) {
        const auto id = static_cast<int>(*landmark.source_id);
        if (landmark_at.count(id) == 0) landmark_at[id] = 2 * (bases + static_cast<Eigen::Index>(landmark_at.size()));
      }
    }
    const Eigen::Index n = 2 * (bases + static_cast<Eigen::Index>(landmark_at.size()));
    Eigen::MatrixXd information = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd weighted = Eigen::VectorXd::Zero(n);
    for (int k = 0; k < count; ++k) {
      const Submap& submap = world.submaps[static_cast<std::size_t>(k)];
      const Eigen::Matrix2d k_R_global = world.truth.global_T_base[static_cast<std::size_t>(k)].rotation().transpose();
      std::vector<Eigen::Index> columns{base_at(k + 1)};
      std::vector<int> rows{0, 1};
      for (std::size_t i = 0; i < submap.landmarks.size(); ++i) {
        columns.push_back(landmark_at.at(static_cast<int>(*submap.landmarks[i].source_id)));
        rows.push_back(static_cast<int>(3 + 2 * i));
        rows.push_back(static_cast<int>(4 + 2 * i));
      }
      Eigen::MatrixXd J = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(rows.size()), n);
      for (std::size_t i = 0; i < columns.size(); ++i) {
        J.block<2, 2>(static_cast<Eigen::Index>(2 * i), columns[i]) = k_R_global;
        if (k > 0) J.block<2, 2>(static_cast<Eigen::Index>(2 * i), base_at(k)) -= k_R_global;
      }
      const Eigen::LLT<Eigen::MatrixXd> P(live_map_of(submap).covariance(rows, rows));
      information += J.transpose() * P.solve(J);
      weighted += J.transpose() * P.solve(Eigen::VectorXd(submap.state.mean(rows)));
    }
    const Eigen::LLT<Eigen::MatrixXd> solver(information);
    y = solver.solve(weighted);
    covariance = solver.solve(Eigen::MatrixXd::Identity(n, n));
  }
  [[nodiscard]] static Eigen::Index base_at(int base) { return 2 * (Eigen::Index{base} - 1); }
};

}  // namespace ssjs::testing
