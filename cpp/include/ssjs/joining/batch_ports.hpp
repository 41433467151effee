/// Gauss-Newton over the port factors of all maps, sparse. docs/math/ports.md (P-6).
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "ssjs/joining/port_level.hpp"
#include "ssjs/joining/sparse_cholesky.hpp"

namespace ssjs {

class BatchPorts final : public PortLevel {
 public:
  BatchPorts();

  void align_to_north(const PortMap& map, Eigen::Index row, const OffsetPrior& prior) override;
  void introduce(const PortMap& map, const std::vector<Port>& ports) override;
  void tie(const PortMap& map, const std::vector<Port>& ports) override;
  void drift(int from, double variance) override;
  void merge_landmarks(int keep, int gone) override;
  void free_start(const StartPrior& prior) override;
  void fix(const FixFactor& fix) override;
  void loosen(const PortMap& map) override { set_factor(map, {}); }
  /// Steps are halved while they do not reduce the cost; it ends where a step promises less than 1e-12 of half chi-squared.
  void settle() override;
  void adjust() override { settle(); }

  [[nodiscard]] const PortValues& values() const override { return values_; }
  [[nodiscard]] Eigen::MatrixXd covariance(const std::vector<Unknown>& unknowns) const override;

  /// Start of the next settle().
  void set_values(const PortValues& values);
  /// Whether the unknown has no free coordinate (base 0 of a world neither aligned to north nor fixed; a landmark that is another by now).
  [[nodiscard]] bool is_fixed(const Unknown& unknown) const { return slot(unknown) < 0; }
  [[nodiscard]] std::vector<Unknown> unknowns() const;              ///< bases, offsets, living landmarks
  [[nodiscard]] double chi_squared() const { return 2.0 * cost_; }  ///< of the last settle()

 private:
  struct Factor {
    std::vector<Port> ports;
    Eigen::VectorXd mean;
    Eigen::MatrixXd information;  ///< inverse of the marginal covariance of the ports
  };
  struct Drift {
    int from, to;
    double variance;
  };
  void set_factor(const PortMap& map, const std::vector<Port>& more);
  void count_landmarks();
  void analyse();
  double linearize();
  void factorize();
  [[nodiscard]] int slot(const Unknown& unknown) const;
  /// Free coordinates of an unknown: the first, and how many.
  [[nodiscard]] std::pair<Eigen::Index, Eigen::Index> free_rows(const Unknown& unknown) const;
  [[nodiscard]] std::string name_of(int slot) const;
  [[nodiscard]] const Eigen::MatrixXd& columns_of(const Unknown& unknown) const;

  PortValues values_;
  std::set<int> merged_;              ///< landmarks that are another by now
  std::vector<int> landmark_places_;  ///< among the others; negative: merged
  std::map<int, Factor> factors_;     ///< by base
  std::vector<Drift> drifts_;
  std::optional<OffsetPrior> prior_;
  std::optional<StartPrior> start_prior_;  ///< base 0 is free
  std::vector<FixFactor> fixes_;
  SparseCholesky hessian_;
  Eigen::VectorXd gradient_;
  double cost_ = 0.0;
  bool pattern_is_stale_ = true;
  mutable std::map<Unknown, Eigen::MatrixXd> columns_;  ///< of the covariance, since the last factorisation
};

}  // namespace ssjs
