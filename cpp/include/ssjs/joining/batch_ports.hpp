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
  /// Steps are halved while they do not reduce the cost; it ends where a step promises less than 1e-12 of half chi-squared. On the way the
  /// Hessian is factorised anew where a base turned by more than 1 mrad or moved by more than 0.1 m since, or steps get hardly smaller; in
  /// the end once more at the solution.
  void settle() override;
  void adjust() override;

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

    void archive(Archive& a) {
      a("from", from);
      a("to", to);
      a("variance", variance);
    }
  };
  void set_factor(const PortMap& map, const std::vector<Port>& more);
  void count_landmarks();
  void analyse();
  double linearize(bool with_hessian);
  void move(const PortValues& start, const Eigen::VectorXd& step);
  [[nodiscard]] bool is_near(const PortValues& other) const;
  void factorize();
  [[nodiscard]] int slot(const Unknown& unknown) const;
  /// Free coordinates of an unknown: the first, and how many.
  [[nodiscard]] std::pair<Eigen::Index, Eigen::Index> free_rows(const Unknown& unknown) const;
  [[nodiscard]] std::string name_of(int slot) const;
  void look_up(const std::vector<Unknown>& unknowns) const;  ///< into at_hand_

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
  PortValues factorized_at_;
  /// What was asked for since the last map came, together: the neighbourhood of that map is asked for again and again.
  struct AtHand {
    std::map<Unknown, Eigen::Index> rows;  ///< of the free coordinates
    Eigen::MatrixXd covariance;            ///< by the last factorisation; empty when that is another by now

    void archive(Archive& a) {
      a("rows", rows);
      a("covariance", covariance);
    }
  };
  mutable AtHand at_hand_;
  bool is_adjusted_ = false;  ///< no map came since

 public:
  /// Factors, pattern and factorisation follow from the ports and the values.
  void archive(Archive& a) override {
    a("values", values_);
    a("merged", merged_);
    a("drifts", drifts_);
    a("prior", prior_);
    a("start_prior", start_prior_);
    a("fixes", fixes_);
    a("pattern_is_stale", pattern_is_stale_);
    a("factorized_at", factorized_at_);
    a("at_hand", at_hand_);
    a("is_adjusted", is_adjusted_);
  }
  void resume(const std::deque<PortMap>& maps) override;
};

}  // namespace ssjs
