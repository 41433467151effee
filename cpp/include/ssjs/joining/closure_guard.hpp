/// Which loop closures of a survey stand: the heaviest set of which no two contradict each other, found anew as closures come.
/// [mangelson2018], docs/math/closures.md (C-6..C-9).
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/joining/closure.hpp"
#include "ssjs/joining/levelled_chain.hpp"

namespace ssjs {

struct ClosureGuardConfig {
  bool enabled = true;
  double gate_probability = 0.99999;
  int max_partners = 40;
  int node_budget = 20000;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("enabled", enabled, "loop closures handed in are kept only while they do not contradict others that agree; no: all are taken");
    v.field("gate_probability", gate_probability, Rule::open(0, 1),
            "two closures contradict each other where their cycle along the way without closures is off by more than this quantile");
    v.field("max_partners", max_partners, Rule::at_least(1), "a closure is held against so many others, those nearest along the way");
    v.field("node_budget", node_budget, Rule::at_least(1), "nodes of the search for the heaviest consistent set, for each connected piece");
  }
};

/// How far a closure's word goes.
enum class ClosureStanding : std::uint8_t {
  kProposed,  ///< by something that does not know the estimate: held against everything
  kFound,     ///< by a pairing gated by the estimate: held against proposals
  kGranted,   ///< by known identities: never refused
};

class ClosureGuard {
 public:
  explicit ClosureGuard(const ClosureGuardConfig& config) : config_(config) {}

  /// The next map; arguments as in LevelledChain.
  void append(const LevelledSubmap& submap, bool compass_goes_on, double drift_variance) {
    if (config_.enabled) chain_.append(submap, compass_goes_on, drift_variance);
  }

  /// Forgets the maps: they have changed and are appended again. What was decided by them stays decided.
  void forget_maps() { chain_ = {}; }

  /// A closure between maps that were appended; weight: how many independent observations it stands for, > 0. Returns its number.
  std::size_t add(const Closure& closure, double weight, ClosureStanding standing, const std::deque<PortMap>& maps);

  /// Whether it stands, by all that was added so far.
  [[nodiscard]] bool stands(std::size_t closure);
  /// Why it does not; empty when it does.
  [[nodiscard]] std::string reason(std::size_t closure);

  /// What all other closures and the way together say of it, found by whoever holds them all (C-12): beyond the gate it does not stand;
  /// within it, it may again.
  void judge_by_the_rest(std::size_t closure, const ClosureFit& fit);
  /// Proposals of a relative pose that share a part of the way with this one, the nearest, itself among them; or all.
  [[nodiscard]] std::vector<std::size_t> poses_near(std::size_t closure) const;
  [[nodiscard]] std::vector<std::size_t> all_poses() const;
  /// Refused by judge_by_the_rest() alone.
  [[nodiscard]] bool is_doubted(std::size_t closure) const { return closures_[closure].against_the_rest.has_value(); }
  [[nodiscard]] bool fits(const ClosureFit& fit) const;

  [[nodiscard]] std::size_t size() const { return closures_.size(); }
  [[nodiscard]] const Closure& closure(std::size_t nth) const { return closures_[nth].closure; }
  /// Squared distance from the way without closures (C-5); nothing of closures that were never held against anything.
  [[nodiscard]] const std::optional<ClosureFit>& alone(std::size_t nth) const { return closures_[nth].alone; }
  [[nodiscard]] bool search_was_exact() const { return exact_; }
  [[nodiscard]] const LevelledChain& chain() const { return chain_; }

 private:
  struct Judged {
    Closure closure{};
    double weight = 1.0;
    ClosureStanding standing = ClosureStanding::kProposed;
    std::optional<ClosureFit> alone{};
    bool against_the_way = false;
    std::optional<ClosureFit> against_the_rest{};

    void archive(Archive& a) {
      a("closure", closure);
      a("weight", weight);
      a.choice("standing", standing, ClosureStanding::kGranted);
      a("alone", alone);
      a("against_the_way", against_the_way);
      a("against_the_rest", against_the_rest);
    }
  };
  struct Contradiction {
    std::size_t a = 0, b = 0;
    ClosureFit fit{};  ///< of b given a

    void archive(Archive& archive) {
      archive("a", a);
      archive("b", b);
      archive("fit", fit);
    }
  };
  [[nodiscard]] std::vector<std::size_t> partners_of(std::size_t nth) const;
  [[nodiscard]] std::vector<std::size_t> nearest(std::vector<std::pair<int, std::size_t>> by_distance) const;
  void compare(std::size_t a, std::size_t b, const std::deque<PortMap>& maps);
  void resolve();

  ClosureGuardConfig config_;
  LevelledChain chain_;
  std::vector<Judged> closures_;
  std::vector<Contradiction> contradictions_;
  std::size_t proposals_ = 0;
  std::deque<bool> stands_;
  bool is_stale_ = false;
  bool exact_ = true;

 public:
  /// The chain follows from the maps.
  void archive(Archive& a) {
    a("closures", closures_);
    a("contradictions", contradictions_);
    a("proposals", proposals_);
    a("stands", stands_);
    a("is_stale", is_stale_);
    a("exact", exact_);
    a.require(stands_.size() == closures_.size(), "has more or fewer verdicts than closures");
    for (const Contradiction& one : contradictions_) {
      a.require(one.a < one.b && one.b < closures_.size(), "has a contradiction of closures that are not there");
    }
  }
};

}  // namespace ssjs
