#include "ssjs/joining/conditional_chain.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <string>
#include <utility>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using Rows = std::vector<Eigen::Index>;

constexpr Eigen::Index kPose = StateLayout::kVehicle;

std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

void append_rows(Rows& rows, Eigen::Index first, Eigen::Index count) {
  for (Eigen::Index i = 0; i < count; ++i) rows.push_back(first + i);
}

/// s - reference of shared variables: a pose first, its heading wrapped, then points.
Eigen::VectorXd shared_difference(const Eigen::VectorXd& shared, const Eigen::VectorXd& reference) {
  Eigen::VectorXd difference = shared - reference;
  difference(2) = angle_difference(shared(2), reference(2));
  return difference;
}

/// (I-3) for the mean.
Eigen::VectorXd own_given(const ClosedMap& map, const Eigen::VectorXd& shared) {
  Eigen::VectorXd own = map.own_mean + map.K * shared_difference(shared, map.shared_mean);
  own(2) = wrap_angle(own(2));
  return own;
}

}  // namespace

MapState ConditionalChain::close(const MapState& state, const std::vector<TrackedLandmark>& landmarks,
                                 const std::vector<Eigen::Index>& shared) {
  const StateLayout layout{true};
  ClosedMap map;
  Rows own_rows, shared_rows;
  append_rows(own_rows, kPose, kPose);
  append_rows(shared_rows, 0, kPose);
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    const int label = landmarks[i].label;
    if (label >= static_cast<int>(holder_.size())) {
      holder_.resize(static_cast<std::size_t>(label) + 1, -1);
      variance_.resize(holder_.size(), 0.0);
      row_of_.resize(holder_.size(), 0);
    }
    const auto index = static_cast<Eigen::Index>(i);
    const bool goes_on = std::find(shared.begin(), shared.end(), index) != shared.end();
    holder_[static_cast<std::size_t>(label)] = goes_on ? size() + 1 : size();
    if (goes_on) continue;
    map.own.push_back(landmarks[i]);
    append_rows(own_rows, layout.offset(index), StateLayout::kLandmark);
    variance_[static_cast<std::size_t>(label)] = state.landmark(index).covariance.trace();
  }
  for (const Eigen::Index index : shared) {
    map.shared.push_back(landmarks[at(index)].label);
    append_rows(shared_rows, layout.offset(index), StateLayout::kLandmark);
  }
  map.own_mean = state.mean(own_rows);
  map.shared_mean = state.mean(shared_rows);
  const Eigen::MatrixXd P_ss = state.covariance(shared_rows, shared_rows);
  const Eigen::MatrixXd P_sa = state.covariance(shared_rows, own_rows);
  const Eigen::MatrixXd L = cholesky_lower(P_ss, "covariance of the shared variables", ("submap " + std::to_string(size())).c_str());
  const Eigen::MatrixXd Y = L.triangularView<Eigen::Lower>().solve(P_sa);
  map.K = L.triangularView<Eigen::Lower>().transpose().solve(Y).transpose();  // (I-2)
  map.C = state.covariance(own_rows, own_rows);
  map.C.noalias() -= Y.transpose() * Y;

  Rows next_rows;  // (I-1): the vehicle stands twice, as itself and frozen
  append_rows(next_rows, 0, kPose);
  next_rows.insert(next_rows.end(), shared_rows.begin(), shared_rows.end());
  maps_.push_back(std::move(map));
  return {state.mean(next_rows), state.covariance(next_rows, next_rows), layout};
}

bool ConditionalChain::is_past(int label) const {
  return label >= 0 && label < static_cast<int>(holder_.size()) && holder(label) >= 0 && holder(label) < size();
}

void ConditionalChain::note_rows(const ClosedMap& map) const {
  for (std::size_t i = 0; i < map.own.size(); ++i) {
    row_of_[static_cast<std::size_t>(map.own[i].label)] = kPose + 2 * static_cast<Eigen::Index>(i);
  }
  for (std::size_t i = 0; i < map.shared.size(); ++i) {
    row_of_[static_cast<std::size_t>(map.shared[i])] = map.own_mean.size() + kPose + 2 * static_cast<Eigen::Index>(i);
  }
}

ConditionalChain::Traveller ConditionalChain::take_out(ClosedMap& map, std::size_t own, TrackedLandmark& landmark) {
  landmark = map.own[own];
  const Eigen::Index row = kPose + 2 * static_cast<Eigen::Index>(own);
  Rows rest;
  append_rows(rest, 0, row);
  append_rows(rest, row + 2, map.own_mean.size() - row - 2);
  const Traveller traveller{map.own_mean.segment<2>(row), map.K.middleRows<2>(row), map.C.block<2, 2>(row, row)};
  const PairRows with_own = map.C.middleRows<2>(row)(Eigen::all, rest);
  map.own.erase(map.own.begin() + static_cast<std::ptrdiff_t>(own));
  map.own_mean = map.own_mean(rest).eval();
  map.K = map.K(rest, Eigen::all).eval();
  map.C = map.C(rest, rest).eval();
  share(map, traveller, with_own, landmark.label);
  return traveller;
}

void ConditionalChain::share(ClosedMap& map, const Traveller& traveller, const PairRows& with_own, int label) {
  const Eigen::Index n = map.shared_mean.size();
  const Eigen::Matrix<double, Eigen::Dynamic, 2> G = with_own.transpose() * traveller.variance.inverse();  // (I-4)
  map.K -= G.lazyProduct(traveller.k);
  map.K.conservativeResize(map.K.rows(), n + 2);
  map.K.rightCols<2>() = G;
  map.C -= G.lazyProduct(with_own);
  map.shared_mean.conservativeResize(n + 2);
  map.shared_mean.tail<2>() = traveller.mean;
  map.shared.push_back(label);
}

void ConditionalChain::pass_through(ClosedMap& map, const ClosedMap& before, Traveller& traveller, int label) {
  note_rows(map);
  const Eigen::Index own = map.own_mean.size();
  PairRows k_own = PairRows::Zero(2, own);
  PairRows k = PairRows::Zero(2, map.shared_mean.size());
  Eigen::VectorXd reference(traveller.k.cols());  // of the variables that `before` shares, as this map knows them
  k_own.leftCols<kPose>() = traveller.k.leftCols<kPose>();
  reference.head<kPose>() = map.own_mean.head<kPose>();
  for (Eigen::Index c = kPose; c < traveller.k.cols(); c += 2) {
    const Eigen::Index row = row_of_[static_cast<std::size_t>(before.shared[at((c - kPose) / 2)])];
    if (row < own) {
      k_own.middleCols<2>(row) = traveller.k.middleCols<2>(c);
      reference.segment<2>(c) = map.own_mean.segment<2>(row);
    } else {
      k.middleCols<2>(row - own) = traveller.k.middleCols<2>(c);
      reference.segment<2>(c) = map.shared_mean.segment<2>(row - own);
    }
  }
  const Eigen::VectorXd before_mean = before.shared_mean.head(traveller.k.cols());
  traveller.mean += traveller.k * shared_difference(reference, before_mean);  // (I-5)
  const PairRows with_own = k_own.lazyProduct(map.C);
  traveller.variance += with_own * k_own.transpose();
  k += k_own.lazyProduct(map.K);
  traveller.k = std::move(k);
  share(map, traveller, with_own, label);
}

void ConditionalChain::recall(int label, LandmarkMap& present) {
  const int from = holder(label);
  ClosedMap& holding = maps_[static_cast<std::size_t>(from)];
  const auto found = std::find_if(holding.own.begin(), holding.own.end(), [&](const TrackedLandmark& own) { return own.label == label; });
  TrackedLandmark landmark;
  Traveller traveller = take_out(holding, static_cast<std::size_t>(found - holding.own.begin()), landmark);
  for (int i = from + 1; i < size(); ++i) {
    pass_through(maps_[static_cast<std::size_t>(i)], maps_[static_cast<std::size_t>(i) - 1], traveller, label);
  }
  const ClosedMap& last = maps_.back();
  const Ekf& filter = present.filter();
  const StateLayout layout{true};
  for (Eigen::Index i = 0; i < present.size(); ++i) {
    const int other = present.tracked(i).label;
    if (other >= 0 && other < static_cast<int>(row_of_.size())) row_of_[static_cast<std::size_t>(other)] = i;
  }
  PairRows J = PairRows::Zero(2, layout.size(present.size()));
  Eigen::VectorXd now(traveller.k.cols());
  J.middleCols<kPose>(kPose) = traveller.k.leftCols<kPose>();
  now.head<kPose>() = filter.frozen_pose().vector();
  for (Eigen::Index c = kPose; c < traveller.k.cols(); c += 2) {
    const Eigen::Index i = row_of_[static_cast<std::size_t>(last.shared[at((c - kPose) / 2)])];
    J.middleCols<2>(layout.offset(i)) = traveller.k.middleCols<2>(c);
    now.segment<2>(c) = filter.landmark_position(i);
  }
  const Eigen::VectorXd last_mean = last.shared_mean.head(traveller.k.cols());
  const Eigen::Vector2d position = traveller.mean + traveller.k * shared_difference(now, last_mean);
  present.add_known(landmark, position, J, traveller.variance);  // (I-5)
  holder_[static_cast<std::size_t>(label)] = size();
}

std::vector<ConditionalChain::PastLandmark> ConditionalChain::past_landmarks(const LandmarkMap& present) const {
  std::vector<Eigen::Vector2d> position(holder_.size(), Eigen::Vector2d::Zero());
  for (Eigen::Index i = 0; i < present.size(); ++i) {
    const int label = present.tracked(i).label;
    if (label >= 0 && label < static_cast<int>(position.size())) {
      position[static_cast<std::size_t>(label)] = present.filter().landmark_position(i);
    }
  }
  Se2 exit = present.filter().frozen_pose();
  for (auto map = maps_.rbegin(); map != maps_.rend(); ++map) {
    Eigen::VectorXd shared(map->shared_mean.size());
    shared.head<kPose>() = exit.vector();
    for (std::size_t i = 0; i < map->shared.size(); ++i) {
      shared.segment<2>(kPose + 2 * static_cast<Eigen::Index>(i)) = position[static_cast<std::size_t>(map->shared[i])];
    }
    const Eigen::VectorXd own = own_given(*map, shared);
    exit = Se2::from_vector(own.head<kPose>());
    for (std::size_t i = 0; i < map->own.size(); ++i) {
      position[static_cast<std::size_t>(map->own[i].label)] = own.segment<2>(kPose + 2 * static_cast<Eigen::Index>(i));
    }
  }
  std::vector<PastLandmark> past;
  for (int label = 0; label < static_cast<int>(holder_.size()); ++label) {
    const auto index = static_cast<std::size_t>(label);
    if (is_past(label)) past.push_back({label, position[index], variance_[index]});
  }
  return past;
}

WorldEstimate ConditionalChain::estimate(const MapState& present, const std::vector<TrackedLandmark>& landmarks,
                                         BaseCovariance covariance) const {
  const int last = size();
  const std::size_t bases = static_cast<std::size_t>(last) + 2;
  const bool joint = covariance == BaseCovariance::kJoint;
  const auto base = [](int k) { return Eigen::seqN(kPose * k, Eigen::fix<3>); };
  WorldEstimate world;
  world.global_T_base.resize(bases);
  world.border_covariance.resize(bases - 1);
  if (joint) world.base_covariance.setZero(kPose * static_cast<Eigen::Index>(bases), kPose * static_cast<Eigen::Index>(bases));
  std::vector<std::pair<int, LandmarkEstimate>> by_label;
  const auto put_landmarks = [&](const MapState& state, const std::vector<TrackedLandmark>& own, Eigen::Index offset, int map) {
    for (std::size_t i = 0; i < own.size(); ++i) {
      const Eigen::Index row = offset + 2 * static_cast<Eigen::Index>(i);
      by_label.push_back({own[i].label, {{state.mean.segment<2>(row), state.covariance.block<2, 2>(row, row)}, own[i].landmark, map}});
    }
    world.maps.push_back({map, {map}, static_cast<int>(own.size())});
  };

  // Downwards: `later` = covariance of the map's variables with all bases after its own, its exit first.
  MapState state = present;
  Rows base_rows, exit_rows;
  append_rows(base_rows, kPose, kPose);
  append_rows(exit_rows, 0, kPose);
  Eigen::MatrixXd later = state.covariance(Eigen::all, exit_rows);
  world.global_T_base[bases - 1] = Se2::from_vector(state.mean(exit_rows));
  if (joint) world.base_covariance(base(last + 1), base(last + 1)) = state.covariance(exit_rows, exit_rows);
  put_landmarks(state, landmarks, StateLayout{true}.offset(0), last);
  std::vector<Eigen::Index> row_of(holder_.size(), 0);
  const auto note = [&](int label, Eigen::Index row) {
    if (label >= 0 && label < static_cast<int>(row_of.size())) row_of[static_cast<std::size_t>(label)] = row;
  };
  for (std::size_t i = 0; i < landmarks.size(); ++i) note(landmarks[i].label, StateLayout{true}.offset(static_cast<Eigen::Index>(i)));

  for (int k = last;; --k) {
    world.global_T_base[static_cast<std::size_t>(k)] = Se2::from_vector(state.mean(base_rows));
    Rows border = base_rows;
    border.insert(border.end(), exit_rows.begin(), exit_rows.end());
    world.border_covariance[static_cast<std::size_t>(k)] = state.covariance(border, border);
    if (joint) {
      world.base_covariance(base(k), base(k)) = state.covariance(base_rows, base_rows);
      const Eigen::MatrixXd with_later = later(base_rows, Eigen::all);
      world.base_covariance.block(kPose * k, kPose * (k + 1), kPose, with_later.cols()) = with_later;
      world.base_covariance.block(kPose * (k + 1), kPose * k, with_later.cols(), kPose) = with_later.transpose();
    }
    if (k == 0) break;

    const ClosedMap& map = maps_[static_cast<std::size_t>(k) - 1];
    Rows shared = base_rows;  // of map k: what map k - 1 shares with it
    for (const int label : map.shared) append_rows(shared, row_of[static_cast<std::size_t>(label)], StateLayout::kLandmark);
    const Eigen::Index own = map.own_mean.size();
    const Eigen::Index n = own + static_cast<Eigen::Index>(shared.size());
    MapState before{Eigen::VectorXd(n), Eigen::MatrixXd(n, n), StateLayout{true}};
    before.mean.tail(n - own) = state.mean(shared);
    before.mean.head(own) = own_given(map, before.mean.tail(n - own));  // (I-3)
    auto P_ss = before.covariance.bottomRightCorner(n - own, n - own);
    P_ss = state.covariance(shared, shared);
    auto P_as = before.covariance.topRightCorner(own, n - own);
    P_as.noalias() = map.K * P_ss;
    before.covariance.topLeftCorner(own, own) = map.C;
    before.covariance.topLeftCorner(own, own).noalias() += P_as * map.K.transpose();
    before.covariance.bottomLeftCorner(n - own, own) = P_as.transpose();
    if (joint) {  // (I-6)
      Eigen::MatrixXd after(static_cast<Eigen::Index>(shared.size()), kPose + later.cols());
      after << state.covariance(shared, base_rows), later(shared, Eigen::all);
      later.resize(n, after.cols());
      later.topRows(own).noalias() = map.K * after;
      later.bottomRows(n - own) = after;
    }
    state = std::move(before);
    base_rows.clear();
    exit_rows.clear();
    append_rows(base_rows, 0, kPose);
    append_rows(exit_rows, own, kPose);
    for (std::size_t i = 0; i < map.own.size(); ++i) note(map.own[i].label, kPose + 2 * static_cast<Eigen::Index>(i));
    for (std::size_t i = 0; i < map.shared.size(); ++i) note(map.shared[i], own + kPose + 2 * static_cast<Eigen::Index>(i));
    put_landmarks(state, map.own, kPose, k - 1);
  }
  std::reverse(world.maps.begin(), world.maps.end());
  std::sort(by_label.begin(), by_label.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  for (const auto& entry : by_label) world.landmarks.push_back(entry.second);
  return world;
}

MapState in_base_frame(const MapState& state) {
  const StateLayout from{true};
  const StateLayout to;
  const Eigen::Index n = state.landmarks();
  const Se2 base = Se2::from_vector(state.mean(StateLayout::frozen_pose()));
  const RelativePose exit = relative_pose(base, state.vehicle().mean);
  MapState local{Eigen::VectorXd(to.size(n)), {}, to};
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(to.size(n), from.size(n));
  local.mean(StateLayout::vehicle()) = exit.i_T_j.vector();
  J(StateLayout::vehicle(), StateLayout::vehicle()) = exit.J_j;
  J(StateLayout::vehicle(), StateLayout::frozen_pose()) = exit.J_i;
  const Se2 inverse = base.inverse();
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector2d point = state.mean(from.landmark(i));
    local.mean(to.landmark(i)) = inverse * point;
    J(to.landmark(i), StateLayout::frozen_pose()) = act_jacobian(inverse, point) * inverse_jacobian(base);
    J(to.landmark(i), from.landmark(i)) = inverse.rotation();
  }
  local.covariance = J * state.covariance * J.transpose();
  return local;
}

}  // namespace ssjs
