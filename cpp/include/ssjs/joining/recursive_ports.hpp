/// The global level of a survey as an extended Kalman filter: new unknowns are augmented, known ones update it. Equal to BatchPorts in a
/// linear world, and brought back to it where the linearisation has moved. docs/math/ports.md (P-7..P-9).
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "ssjs/joining/batch_ports.hpp"
#include "ssjs/joining/port_level.hpp"

namespace ssjs {

class RecursivePorts final : public PortLevel {
 public:
  /// relinearize_heading_rad: once an update has turned a base by more than this (in sum since the last time), settle() starts anew from
  /// Gauss-Newton over all factors; infinity never does.
  explicit RecursivePorts(double relinearize_heading_rad);

  void align_to_north(const PortMap& map, Eigen::Index row, const OffsetPrior& prior) override;
  void introduce(const PortMap& map, const std::vector<Port>& ports) override;
  void tie(const PortMap& map, const std::vector<Port>& ports) override;
  void drift(int from, double variance) override;
  void merge_landmarks(int keep, int gone) override;
  void free_start(const StartPrior& prior) override;
  void fix(const FixFactor& fix) override;
  void loosen(const PortMap& map) override;
  void settle() override;
  void adjust() override;  ///< (P-9)

  [[nodiscard]] const PortValues& values() const override { return values_; }
  [[nodiscard]] Eigen::MatrixXd covariance(const std::vector<Unknown>& unknowns) const override;
  [[nodiscard]] int relinearizations() const { return relinearizations_; }

 private:
  struct Block {
    Unknown unknown;
    Eigen::Index row;

    void archive(Archive& a) {
      a("unknown", unknown);
      a("row", row);
    }
  };
  /// J over listed unknowns -> over the whole state.
  [[nodiscard]] Eigen::MatrixXd over_state(const Eigen::MatrixXd& J, const std::vector<Unknown>& unknowns,
                                           const std::vector<Eigen::Index>& columns) const;
  /// New rows y = J x + n, n ~ N(0, noise), at the end of the state.
  void augment(const std::vector<Unknown>& unknowns, const Eigen::MatrixXd& J, const Eigen::MatrixXd& noise);
  void update(const Eigen::VectorXd& residual, const Eigen::MatrixXd& H, const Eigen::MatrixXd& noise, const std::string& name);

  double relinearize_heading_rad_;
  BatchPorts factors_;  ///< what relinearisation starts from
  PortValues values_;
  std::vector<Block> blocks_;  ///< of the state, in the order of P_; base 0 is among them (zero rows where it is fixed)
  std::map<Unknown, Eigen::Index> row_of_;
  Eigen::MatrixXd P_;
  bool is_free_ = false;            ///< base 0
  std::vector<double> turned_rad_;  ///< by base: sum of the heading steps since the last linearisation
  int relinearizations_ = 0;

 public:
  void archive(Archive& a) override {
    a("factors", factors_);
    a("values", values_);
    a("blocks", blocks_);
    a("P", P_);
    a("is_free", is_free_);
    a("turned_rad", turned_rad_);
    a("relinearizations", relinearizations_);
  }
  void resume(const std::deque<PortMap>& maps) override;
};

}  // namespace ssjs
