#include "ssjs/joining/port_association.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "ssjs/association/compatibility.hpp"
#include "ssjs/association/joint_factor.hpp"
#include "ssjs/base/angle.hpp"
#include "ssjs/base/chi_squared.hpp"
#include "ssjs/geometry/gaussian.hpp"
#include "ssjs/joining/chance_alignment.hpp"

namespace ssjs {
namespace {

/// Rows of the plane among 3 n rows.
Eigen::VectorXi planar_rows(std::size_t points) {
  Eigen::VectorXi rows(static_cast<Eigen::Index>(2 * points));
  for (Eigen::Index i = 0; i < rows.size(); ++i) rows(i) = static_cast<int>(3 * (i / 2) + i % 2);
  return rows;
}

/// First column of each unknown.
std::vector<Eigen::Index> starts_of(const std::vector<Unknown>& unknowns, Eigen::Index& size) {
  std::vector<Eigen::Index> starts;
  size = 0;
  for (const Unknown& unknown : unknowns) {
    starts.push_back(size);
    size += rows_of(unknown.kind);
  }
  return starts;
}

/// Both sides in the world, with what they have in common.
struct Meeting {
  PlacedSightings observed, predicted;
  Eigen::MatrixXd P;  ///< of the unknowns
  PairingProblem problem;

  /// (P-10): covariance of the depth difference of a pair.
  [[nodiscard]] double depth_variance(const Pair& pair) const {
    const Eigen::Index q = 3 * pair.observation + 2;
    const Eigen::Index p = 3 * pair.prediction + 2;
    const Eigen::RowVectorXd J = observed.J.row(q) - predicted.J.row(p);
    return J * P * J.transpose() + observed.noise(q, q) + predicted.noise(p, p);
  }
  [[nodiscard]] double depth_difference(const Pair& pair) const {
    return observed.mean(3 * pair.observation + 2) - predicted.mean(3 * pair.prediction + 2);
  }
  /// Standard deviation of the displacement that the unknowns leave open.
  [[nodiscard]] double displacement_sigma(const Pair& pair) const {
    const Eigen::MatrixXd J = observed.J.middleRows<2>(3 * pair.observation) - predicted.J.middleRows<2>(3 * pair.prediction);
    return largest_sigma(J * P * J.transpose());
  }
  /// Whether the pair would say where the maps lie against each other: it is known better what was seen than where.
  [[nodiscard]] bool would_align(const Pair& pair) const {
    const Eigen::Index q = 3 * pair.observation;
    return displacement_sigma(pair) > largest_sigma(observed.noise.block<2, 2>(q, q));
  }
};

Meeting meet(const std::vector<Sighting>& observed, const std::vector<Sighting>& predicted, const PortLevel& level) {
  std::vector<Unknown> unknowns = unknowns_of(observed);
  const std::vector<Unknown> others = unknowns_of(predicted);
  unknowns.insert(unknowns.end(), others.begin(), others.end());
  std::sort(unknowns.begin(), unknowns.end());
  unknowns.erase(std::unique(unknowns.begin(), unknowns.end()), unknowns.end());

  Meeting meeting{place_sightings(observed, unknowns, level.values()),
                  place_sightings(predicted, unknowns, level.values()),
                  level.covariance(unknowns),
                  {}};
  const Eigen::VectorXi of_observed = planar_rows(observed.size());
  const Eigen::VectorXi of_predicted = planar_rows(predicted.size());
  const Eigen::MatrixXd J_observed = meeting.observed.J(of_observed, Eigen::all);
  const Eigen::MatrixXd J_predicted = meeting.predicted.J(of_predicted, Eigen::all);
  const Eigen::MatrixXd PJt_observed = meeting.P * J_observed.transpose();
  meeting.problem.observed = meeting.observed.mean(of_observed);
  meeting.problem.predicted = meeting.predicted.mean(of_predicted);
  meeting.problem.observed_covariance = J_observed * PJt_observed + meeting.observed.noise(of_observed, of_observed);
  meeting.problem.predicted_covariance =
      J_predicted * meeting.P * J_predicted.transpose() + meeting.predicted.noise(of_predicted, of_predicted);
  meeting.problem.cross_covariance = J_predicted * PJt_observed;
  return meeting;
}

/// Joint covariance of the residuals of these pairs.
Eigen::MatrixXd joint_covariance(const PairingProblem& problem, const std::vector<Pair>& pairs) {
  const auto n = static_cast<Eigen::Index>(pairs.size());
  Eigen::MatrixXd S(2 * n, 2 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      S.block<2, 2>(2 * i, 2 * j) = pair_covariance(problem, pairs[static_cast<std::size_t>(i)], pairs[static_cast<std::size_t>(j)]);
    }
  }
  return S;
}

/// How many of the landmarks that lie elsewhere look alike all the same: by so much less often does chance bring one that does. 1 where
/// nobody knows what the pair looks like. (I-15)
double chance_of_likeness(const std::vector<Sighting>& observed, const std::vector<Sighting>& predicted, const Compatibility& compatibility,
                          double gate, double max_descriptor_distance) {
  int elsewhere = 0, alike = 0;
  for (std::size_t i = 0; i < observed.size(); ++i) {
    for (std::size_t j = 0; j < predicted.size(); ++j) {
      if (compatibility.squared_distance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) <= gate) continue;
      const std::optional<double> distance = descriptor_distance(observed[i].known().descriptor, predicted[j].known().descriptor);
      if (!distance) continue;
      ++elsewhere;
      if (*distance <= max_descriptor_distance) ++alike;
    }
  }
  return (alike + 1.0) / (elsewhere + 1.0);
}

/// The pair that chance explains best, and the odds of chance against it given the other pairs (P-12). density_per_m2: for each pair.
std::pair<std::size_t, double> likeliest_chance(const PairingProblem& problem, const std::vector<Pair>& pairs,
                                                const std::vector<double>& density_per_m2) {
  const Eigen::MatrixXd S = joint_covariance(problem, pairs);
  const Eigen::MatrixXd L = cholesky_lower(S, "residual covariance", "pairs of two maps");
  const Eigen::MatrixXd L_inverse = L.triangularView<Eigen::Lower>().solve(Eigen::MatrixXd::Identity(S.rows(), S.rows()));
  const Eigen::MatrixXd W = L_inverse.transpose() * L_inverse;
  Eigen::VectorXd r(S.rows());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    r.segment<2>(static_cast<Eigen::Index>(2 * i)) = pair_residual(problem, pairs[i].observation, pairs[i].prediction);
  }
  const Eigen::VectorXd W_r = W * r;
  std::pair<std::size_t, double> worst{0, 0.0};
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(2 * i);
    const Eigen::Matrix2d S_given = W.block<2, 2>(at, at).inverse();  // of the residual given all others, which is S_given (W r)_i
    const double squared_distance = W_r.segment<2>(at).dot(S_given * W_r.segment<2>(at));
    const double odds = density_per_m2[i] * 2.0 * kPi * std::sqrt(S_given.determinant()) * std::exp(0.5 * squared_distance);
    if (odds > worst.second) worst = {i, odds};
  }
  return worst;
}

/// Refuses the pairs that would align the maps where chance brings as many together. (W-5)
void refuse_chance_alignments(const Meeting& meeting, double density_per_m2, double gate, double most, SightingPairs& result) {
  std::vector<Pair> sure, aligning;
  for (const Pair& pair : result.pairs) (meeting.would_align(pair) ? aligning : sure).push_back(pair);
  if (aligning.empty()) return;
  const auto n = static_cast<Eigen::Index>(2 * sure.size());
  std::vector<Pair> all = sure;
  all.insert(all.end(), aligning.begin(), aligning.end());
  const Eigen::MatrixXd S = joint_covariance(meeting.problem, all);
  const Eigen::Index m = S.rows() - n;
  const auto others = static_cast<int>(meeting.problem.observed.size() / 2 - n / 2);
  Eigen::MatrixXd S_given = S.bottomRightCorner(m, m);
  if (n > 0) S_given -= S.bottomLeftCorner(m, n) * S.topLeftCorner(n, n).llt().solve(S.topRightCorner(n, m));
  if (expected_chance_alignments(S_given, others, density_per_m2, gate) <= most) return;
  result.refused += static_cast<int>(aligning.size());
  result.pairs = std::move(sure);
}

}  // namespace

bool may_be_one(const Sighting& a, const Sighting& b, double max_descriptor_distance) {
  if (a.known().of_camera != b.known().of_camera) return false;
  return descriptor_distance(a.known().descriptor, b.known().descriptor).value_or(0.0) <= max_descriptor_distance;
}

std::vector<Unknown> unknowns_of(const std::vector<Sighting>& sightings) {
  std::vector<Unknown> unknowns;
  for (const Sighting& sighting : sightings) {
    if (const std::optional<Unknown> port = sighting.port()) {
      unknowns.push_back(*port);
      continue;
    }
    unknowns.push_back({UnknownKind::kBase, sighting.map->base()});
    for (const Port& port : sighting.map->ports) unknowns.push_back(port.unknown);
  }
  std::sort(unknowns.begin(), unknowns.end());
  unknowns.erase(std::unique(unknowns.begin(), unknowns.end()), unknowns.end());
  return unknowns;
}

PlacedSightings place_sightings(const std::vector<Sighting>& sightings, const std::vector<Unknown>& unknowns, const PortValues& values) {
  Eigen::Index size = 0;
  const std::vector<Eigen::Index> starts = starts_of(unknowns, size);
  const auto column_of = [&](const Unknown& unknown) {
    return starts[static_cast<std::size_t>(std::lower_bound(unknowns.begin(), unknowns.end(), unknown) - unknowns.begin())];
  };
  const auto n = static_cast<Eigen::Index>(3 * sightings.size());
  PlacedSightings placed{Eigen::VectorXd(n), Eigen::MatrixXd::Zero(n, size), Eigen::MatrixXd::Zero(n, n)};
  for (std::size_t first = 0; first < sightings.size();) {  // the sightings of one map
    const PortMap& map = *sightings[first].map;
    const Se2& global_T_base = values.base(map.base());
    std::vector<Eigen::Index> inner;  // places of those that are not ports
    std::size_t last = first;
    for (; last < sightings.size() && sightings[last].map == &map; ++last) {
      const auto at = static_cast<Eigen::Index>(3 * last);
      if (const std::optional<Unknown> port = sightings[last].port()) {
        placed.mean.segment<3>(at) = values.landmark(port->index);
        placed.J.block<3, 3>(at, column_of(*port)).setIdentity();
      } else {
        inner.push_back(at);
      }
    }
    Eigen::VectorXi rows(static_cast<Eigen::Index>(3 * inner.size()));
    for (Eigen::Index i = 0; i < rows.size(); ++i) {
      rows(i) = static_cast<int>(sightings[static_cast<std::size_t>(inner[static_cast<std::size_t>(i / 3)] / 3)].row() + i % 3);
    }
    const ConditionalPlacement local = place_rows(map, rows, values);
    const Eigen::Matrix3d R = to_world(global_T_base, Eigen::Vector3d::Zero()).J_point;
    for (std::size_t i = 0; i < inner.size(); ++i) {  // l = X_k (+) m(s(X)), (P-10)
      const auto row = static_cast<Eigen::Index>(3 * i);
      const WorldPoint point = to_world(global_T_base, local.mean.segment<3>(row));
      placed.mean.segment<3>(inner[i]) = point.position;
      for (std::size_t u = 0; u < local.unknowns.size(); ++u) {
        const Eigen::Index count = rows_of(local.unknowns[u].kind);
        placed.J.block(inner[i], column_of(local.unknowns[u]), 3, count) += R * local.J.block(row, local.columns[u], 3, count);
      }
      placed.J.block<3, 3>(inner[i], column_of({UnknownKind::kBase, map.base()})) += point.J_base;
      for (std::size_t j = 0; j < inner.size(); ++j) {
        placed.noise.block<3, 3>(inner[i], inner[j]) = R * local.noise.block<3, 3>(row, static_cast<Eigen::Index>(3 * j)) * R.transpose();
      }
    }
    first = last;
  }
  return placed;
}

SightingPairs associate_sightings(const std::vector<Sighting>& observed, const std::vector<Sighting>& predicted, const PortLevel& level,
                                  double density_per_m2, const PortAssociationConfig& config) {
  SightingPairs result;
  if (observed.empty() || predicted.empty()) return result;
  const Meeting meeting = meet(observed, predicted, level);
  const double gate = chi_squared_quantile(config.joint.gate_probability, 2.0);
  const double depth_gate = chi_squared_quantile(config.joint.gate_probability, 1.0);
  Compatibility compatibility = individual_compatibility(meeting.problem, gate);
  const double likeness = chance_of_likeness(observed, predicted, compatibility, gate, config.max_descriptor_distance);
  std::vector<Eigen::Index> observations;
  for (std::size_t i = 0; i < observed.size(); ++i) {
    const auto observation = static_cast<Eigen::Index>(i);
    std::vector<Eigen::Index>& candidates = compatibility.candidates[i];
    const auto cannot_be = [&](Eigen::Index prediction) {  // (P-11)
      if (!may_be_one(observed[i], predicted[static_cast<std::size_t>(prediction)], config.max_descriptor_distance)) return true;
      const Pair pair{observation, prediction};
      const double difference = meeting.depth_difference(pair);
      return !(difference * difference <= depth_gate * meeting.depth_variance(pair));
    };
    candidates.erase(std::remove_if(candidates.begin(), candidates.end(), cannot_be), candidates.end());
    for (const Eigen::Index prediction : candidates) {
      result.sigma_m = std::max(result.sigma_m, meeting.displacement_sigma({observation, prediction}));
    }
    observations.push_back(observation);
  }
  const Hypothesis hypothesis = joint_compatibility(meeting.problem, compatibility, observations, config.joint);
  result.pairs = hypothesis.pairs;
  result.budget_exhausted = hypothesis.budget_exhausted;
  std::vector<double> densities;
  for (const Pair& pair : result.pairs) {
    const Descriptor& own = observed[static_cast<std::size_t>(pair.observation)].known().descriptor;
    const Descriptor& other = predicted[static_cast<std::size_t>(pair.prediction)].known().descriptor;
    densities.push_back(descriptor_distance(own, other) ? likeness * density_per_m2 : density_per_m2);
  }
  while (!result.pairs.empty()) {  // (P-12)
    const auto [worst, odds] = likeliest_chance(meeting.problem, result.pairs, densities);
    if (odds <= config.max_chance_odds) break;
    result.pairs.erase(result.pairs.begin() + static_cast<std::ptrdiff_t>(worst));
    densities.erase(densities.begin() + static_cast<std::ptrdiff_t>(worst));
    ++result.refused;
  }
  if (config.max_chance_alignments) {
    const double densest = densities.empty() ? 0.0 : *std::max_element(densities.begin(), densities.end());
    refuse_chance_alignments(meeting, densest, gate, *config.max_chance_alignments, result);
  }
  result.joint_squared_distance = joint_squared_distance(meeting.problem, result.pairs);
  return result;
}

}  // namespace ssjs
