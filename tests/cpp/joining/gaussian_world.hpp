/// Submaps whose errors are exactly Gaussian with the covariance they state, drawn around a known truth; and the batch solution
/// that anything built from them is compared with.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <functional>
#include <vector>

#include "geometry/numeric_jacobian.hpp"
#include "ssjs/association/hypothesis.hpp"
#include "ssjs/base/random.hpp"
#include "ssjs/joining/global_map.hpp"
#include "ssjs/joining/live_map.hpp"

namespace ssjs::testing {

inline Eigen::VectorXd normal_vector(Rng& rng, Eigen::Index n) {
  Eigen::VectorXd v(n);
  for (Eigen::Index i = 0; i < n; ++i) v(i) = rng.normal();
  return v;
}

/// Correlated covariance with the given standard deviations.
inline Eigen::MatrixXd correlated_covariance(Rng& rng, const Eigen::VectorXd& sigmas) {
  const Eigen::Index n = sigmas.size();
  Eigen::MatrixXd A(n, n);
  for (Eigen::Index c = 0; c < n; ++c) A.col(c) = normal_vector(rng, n);
  Eigen::MatrixXd C = A * A.transpose() / static_cast<double>(n) + 0.3 * Eigen::MatrixXd::Identity(n, n);
  const Eigen::VectorXd scale = sigmas.array() / C.diagonal().array().sqrt();
  return scale.asDiagonal() * C * scale.asDiagonal();
}

struct World {
  std::vector<Se2> global_T_base;  ///< the truth; base 0 is the world frame
  Eigen::Matrix2Xd landmarks;      ///< 2 x n, identities are the columns
};

/// Standard deviations of a state of `poses` poses and `landmarks` landmarks: sigma_m in position, a tenth of it (per metre) in heading.
inline Eigen::VectorXd state_sigmas(Eigen::Index poses, Eigen::Index landmarks, double sigma_m) {
  Eigen::VectorXd sigmas = Eigen::VectorXd::Constant(3 * poses + 2 * landmarks, sigma_m);
  for (Eigen::Index i = 0; i < poses; ++i) sigmas(3 * i + 2) = 0.1 * sigma_m;
  return sigmas;
}

/// Submap k (from base k to base k + 1) of these landmarks, with an error drawn from its covariance.
inline Submap noisy_submap(const World& world, int k, const std::vector<int>& landmarks, double sigma_m, Rng& rng) {
  Submap submap;
  submap.index = k;
  submap.start_time_s = k;
  submap.end_time_s = k + 1;
  const Se2 base_T_global = world.global_T_base[static_cast<std::size_t>(k)].inverse();
  const auto n = static_cast<Eigen::Index>(landmarks.size());
  submap.state.mean.resize(3 + 2 * n);
  submap.state.mean.head<3>() = (base_T_global * world.global_T_base[static_cast<std::size_t>(k) + 1]).vector();
  for (Eigen::Index i = 0; i < n; ++i) {
    const int id = landmarks[static_cast<std::size_t>(i)];
    submap.state.mean.segment<2>(3 + 2 * i) = base_T_global * Eigen::Vector2d(world.landmarks.col(id));
    submap.landmarks.push_back({1, id, {1000 * std::int64_t{k} + i}});  // tracks of its own
  }
  submap.state.covariance = correlated_covariance(rng, state_sigmas(1, n, sigma_m));
  const Eigen::MatrixXd L = submap.state.covariance.llt().matrixL();
  submap.state.mean += L * normal_vector(rng, 3 + 2 * n);
  submap.state.mean(2) = wrap_angle(submap.state.mean(2));
  return submap;
}

/// observation: b, prediction: a.
inline std::vector<Pair> pairs_by_identity(const LiveMap& a, const LiveMap& b) {
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < b.landmarks.size(); ++i) {
    for (std::size_t j = 0; j < a.landmarks.size(); ++j) {
      if (a.landmarks[j].source_id == b.landmarks[i].source_id)
        pairs.push_back({static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)});
    }
  }
  return pairs;
}

/// Weighted least squares z = h(y) + n by Gauss-Newton with numerical Jacobians, to the end.
struct BatchSolution {
  Eigen::VectorXd y;
  Eigen::MatrixXd covariance;
  double chi_squared = 0.0;
};
/// difference(z, h): z - h with its angles wrapped; wrap(y) brings the headings of y back into the circle.
inline BatchSolution solve_batch(const Eigen::VectorXd& start, const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& residual,
                                 const Eigen::MatrixXd& z_covariance) {
  BatchSolution solution{start, {}, 0.0};
  const Eigen::MatrixXd W = z_covariance.llt().solve(Eigen::MatrixXd::Identity(z_covariance.rows(), z_covariance.cols()));
  for (int iteration = 0; iteration < 12; ++iteration) {
    const Eigen::VectorXd r = residual(solution.y);
    const Eigen::MatrixXd J = numeric_jacobian(residual, solution.y);
    const Eigen::LLT<Eigen::MatrixXd> information(J.transpose() * W * J);
    solution.y -= information.solve(J.transpose() * W * r);
    solution.covariance = information.solve(Eigen::MatrixXd::Identity(start.size(), start.size()));
  }
  const Eigen::VectorXd r = residual(solution.y);
  solution.chi_squared = r.dot(W * r);
  return solution;
}

/// Largest |a - b| in units of `sigmas`, headings (of the first `poses` poses) wrapped. NaN stays NaN.
inline double difference_in_sigmas(const Eigen::VectorXd& a, const Eigen::VectorXd& b, Eigen::Index poses,
                                   const Eigen::MatrixXd& covariance) {
  Eigen::VectorXd difference = a - b;
  for (Eigen::Index i = 0; i < poses; ++i) difference(3 * i + 2) = wrap_angle(difference(3 * i + 2));
  return (difference.array() / covariance.diagonal().array().sqrt()).abs().maxCoeff<Eigen::PropagateNaN>();
}

/// Largest |A - B| in units of the standard deviations of B.
inline double covariance_difference(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B) {
  const Eigen::VectorXd scale = B.diagonal().array().sqrt().inverse();
  return (scale.asDiagonal() * (A - B) * scale.asDiagonal()).cwiseAbs().maxCoeff<Eigen::PropagateNaN>();
}

/// A live map with random numbers in it: `ports` of the poses first, everything correlated.
inline LiveMap random_map(Rng& rng, int base, std::vector<int> poses, Eigen::Index ports, Eigen::Index landmarks, double sigma_m) {
  LiveMap map;
  map.base = base;
  map.members = {base};
  map.poses = std::move(poses);
  map.landmarks.resize(static_cast<std::size_t>(landmarks));
  map.mean = 10.0 * normal_vector(rng, 3 * map.pose_count() + 2 * landmarks);
  for (Eigen::Index i = 0; i < map.pose_count(); ++i) map.mean(3 * i + 2) = wrap_angle(map.mean(3 * i + 2));
  map.covariance = correlated_covariance(rng, state_sigmas(map.pose_count(), landmarks, sigma_m));
  std::vector<bool> is_port(map.poses.size(), false);
  std::fill(is_port.begin(), is_port.begin() + ports, true);
  set_ports(map, is_port);
  return map;
}

/// A global map whose bases 1.. stand exactly at these poses (each tied to base 0 by a map of its own).
inline GlobalMap global_map_at(const std::vector<Se2>& global_T_base, double sigma_m = 0.1) {
  GlobalMap global(GlobalSolver::kInvariantEkf, 1000);
  Rng rng(7);
  for (std::size_t k = 0; k < global_T_base.size(); ++k) {
    LiveMap tie = random_map(rng, 0, {static_cast<int>(k) + 1}, 1, 0, sigma_m);
    tie.mean = global_T_base[k].vector();
    global.attach(tie);
  }
  return global;
}

}  // namespace ssjs::testing
