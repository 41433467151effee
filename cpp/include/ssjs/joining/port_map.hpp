/// A levelled submap at the global level of a survey: which entries of its state are tied to unknowns that the whole survey shares.
/// docs/math/ports.md (P-2..P-5).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "ssjs/base/archive.hpp"
#include "ssjs/geometry/se2.hpp"
#include "ssjs/mapping/levelled_submap.hpp"

namespace ssjs {

enum class UnknownKind {
  kBase,      ///< global_T_base, 3 rows (x m, y m, heading rad)
  kOffset,    ///< compass reading minus heading in the world, 1 row (rad)
  kLandmark,  ///< a landmark that several maps saw, 3 rows (x, y, depth m)
};

/// One unknown of the global level.
struct Unknown {
  UnknownKind kind;
  int index;

  void archive(Archive& a) {
    a.choice("kind", kind, UnknownKind::kLandmark);
    a("index", index);
  }
};
[[nodiscard]] inline bool operator==(const Unknown& a, const Unknown& b) { return a.kind == b.kind && a.index == b.index; }
[[nodiscard]] inline bool operator<(const Unknown& a, const Unknown& b) { return a.kind != b.kind ? a.kind < b.kind : a.index < b.index; }
[[nodiscard]] inline Eigen::Index rows_of(UnknownKind kind) { return kind == UnknownKind::kOffset ? 1 : 3; }

/// Where all unknowns are; an unknown's index is its place in the vector of its kind.
struct PortValues {
  std::vector<Se2> bases;
  std::vector<double> offsets;
  std::vector<Eigen::Vector3d> landmarks;

  void archive(Archive& a) {
    a("bases", bases);
    a("offsets", offsets);
    a("landmarks", landmarks);
  }
  [[nodiscard]] bool holds(const Unknown& unknown) const;
  [[nodiscard]] const Se2& base(int index) const { return bases[static_cast<std::size_t>(index)]; }
  [[nodiscard]] double offset(int index) const { return offsets[static_cast<std::size_t>(index)]; }
  [[nodiscard]] const Eigen::Vector3d& landmark(int index) const { return landmarks[static_cast<std::size_t>(index)]; }
  /// Adds `step` (rows_of(kind) entries, additive coordinates) to one unknown.
  void move(const Unknown& unknown, const Eigen::Ref<const Eigen::VectorXd>& step);
};

/// The entries of a map's state from `row` on (3 or 1) are what the map sees of `unknown` (P-2).
struct Port {
  Eigen::Index row;
  Unknown unknown;

  void archive(Archive& a) {
    a("row", row);
    a("unknown", unknown);
  }
};

/// A submap and those of its ports that are in use. Where the ports are is s(X); what is behind them follows by (P-5).
struct PortMap {
  LevelledSubmap submap;
  std::vector<Port> ports;

  [[nodiscard]] int base() const { return submap.index; }
  [[nodiscard]] std::optional<Unknown> unknown_at(Eigen::Index row) const;

  void archive(Archive& a) {
    a("submap", submap);
    a("ports", ports);
  }
};

/// Rows of these ports in the state of their map, one after the other.
[[nodiscard]] Eigen::VectorXi state_rows(const std::vector<Port>& ports);

/// s(X) of ports of a map that starts at `base`, and its Jacobian: 3 columns for the base first, then those of every port's own unknown
/// in turn (P-3). An unknown has the columns [of_unknown[i], +rows_of(kind)).
struct PortPlacement {
  Eigen::VectorXd s;
  Eigen::MatrixXd J;
  std::vector<Unknown> unknowns;  ///< base, then one a port
  std::vector<Eigen::Index> columns;
};
[[nodiscard]] PortPlacement place_ports(int base, const std::vector<Port>& ports, const PortValues& values);

/// left - right of what these ports stand for, stacked; headings and offsets wrapped.
[[nodiscard]] Eigen::VectorXd port_difference(const std::vector<Port>& ports, const Eigen::Ref<const Eigen::VectorXd>& left,
                                              const Eigen::Ref<const Eigen::VectorXd>& right);

/// Entries m of a state given the ports in use: m = mean + K (s - s_mean) + e, e ~ N(0, C) independent of everything outside (P-5).
struct ConditionalRows {
  Eigen::MatrixXd K;  ///< rows x size of s; no columns when no port is in use
  Eigen::MatrixXd C;
};
/// Throws NotPositiveDefinite naming the map when the covariance of its ports is not.
[[nodiscard]] ConditionalRows condition_on_ports(const PortMap& map, const Eigen::VectorXi& rows);

/// m(X) of these entries, with its Jacobian over the unknowns of the ports in use (P-5).
struct ConditionalPlacement {
  Eigen::VectorXd mean;
  Eigen::MatrixXd J;
  Eigen::MatrixXd noise;  ///< C
  std::vector<Unknown> unknowns;
  std::vector<Eigen::Index> columns;
};
[[nodiscard]] ConditionalPlacement place_rows(const PortMap& map, const Eigen::VectorXi& rows, const PortValues& values);

/// global_p = X (+) p of a point in a map's base frame, depth untouched (P-2); J_base 3 x 3, J_point 3 x 3.
struct WorldPoint {
  Eigen::Vector3d position;
  Eigen::Matrix3d J_base;
  Eigen::Matrix3d J_point;
};
[[nodiscard]] WorldPoint to_world(const Se2& global_T_base, const Eigen::Vector3d& base_p);

}  // namespace ssjs
