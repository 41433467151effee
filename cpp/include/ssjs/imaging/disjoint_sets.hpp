/// Sets of the numbers 0 .. n - 1 that grow together (union-find with path halving).
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace ssjs {

/// The smallest member of a set stands for it, so that the answer does not depend on the order of the unions.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t size = 0) {
    for (std::size_t i = 0; i < size; ++i) add();
  }
  /// One more number, in a set of its own.
  void add() { parent_.push_back(static_cast<int>(parent_.size())); }
  void unite(int a, int b) {
    a = smallest(a);
    b = smallest(b);
    parent(std::max(a, b)) = std::min(a, b);
  }
  /// The smallest number in the set of `member`.
  [[nodiscard]] int smallest(int member) {
    while (parent(member) != member) {
      parent(member) = parent(parent(member));
      member = parent(member);
    }
    return member;
  }

 private:
  int& parent(int member) { return parent_[static_cast<std::size_t>(member)]; }

  std::vector<int> parent_;  ///< a number is its own parent or that of a smaller member
};

}  // namespace ssjs
