/// Memory that is handed out piece after piece and kept when it is cleared: what is recorded map after map asks the heap only while a map
/// is longer than all before it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace ssjs {

/// Pieces stay where they are until they are released, oldest first.
template <class T>
class Tape {
 public:
  /// A run of items, and the number of the reel that it lies on.
  struct Piece {
    T* items = nullptr;
    std::size_t reel = 0;
  };

  explicit Tape(std::size_t items_per_reel) : items_per_reel_(items_per_reel) {}

  /// `count` items that follow each other; what is in them is left over from before.
  [[nodiscard]] Piece append(std::size_t count) {
    if (reels_.empty() || reels_.back().used + count > reels_.back().size) open(count);
    Reel& reel = reels_.back();
    const Piece piece{reel.items.get() + reel.used, first_ + reels_.size() - 1};
    reel.used += count;
    return piece;
  }

  /// The reels before this one are not asked for any more.
  void release_before(std::size_t reel) {
    std::size_t gone = 0;
    for (; gone < reels_.size() && first_ < reel; ++gone, ++first_) spare_.push_back(std::move(reels_[gone]));
    reels_.erase(reels_.begin(), reels_.begin() + static_cast<std::ptrdiff_t>(gone));
  }
  void clear() { release_before(first_ + reels_.size()); }

  /// So much memory as `other` has come to: what it could hold asks the heap for nothing here either.
  void match(const Tape& other) {
    if (items() < other.items()) add_spare(other.items() - items());
  }

 private:
  struct Reel {
    std::unique_ptr<T[]> items;
    std::size_t size = 0;
    std::size_t used = 0;
  };

  void open(std::size_t count) {
    const auto fits = [count](const Reel& reel) { return reel.size >= count; };
    const auto found = std::find_if(spare_.begin(), spare_.end(), fits);
    if (found != spare_.end()) {
      reels_.push_back(std::move(*found));
      spare_.erase(found);
      reels_.back().used = 0;
      return;
    }
    // twice as much as before, so that soon no map is larger
    add_spare(std::max({count, items_per_reel_, std::min(items(), kLargestReel * items_per_reel_)}));
    reels_.push_back(std::move(spare_.back()));
    spare_.pop_back();
  }
  void add_spare(std::size_t size) {
    spare_.reserve(spare_.size() + reels_.size() + 1);  // so that clearing asks for nothing
    reels_.reserve(spare_.size() + reels_.size() + 1);
    spare_.push_back({std::make_unique<T[]>(size), size, 0});
  }
  [[nodiscard]] std::size_t items() const {
    std::size_t sum = 0;
    for (const std::vector<Reel>* const reels : {&reels_, &spare_}) {
      for (const Reel& reel : *reels) sum += reel.size;
    }
    return sum;
  }

  static constexpr std::size_t kLargestReel = 64;  ///< in reels of the first size
  std::size_t items_per_reel_;
  std::size_t first_ = 0;  ///< number of the oldest reel
  std::vector<Reel> reels_, spare_;
};

}  // namespace ssjs
