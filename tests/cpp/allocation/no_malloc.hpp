/// A stretch of code that may not take anything from the heap.
#pragma once

#include <Eigen/Core>

#ifndef EIGEN_RUNTIME_NO_MALLOC
#error "these tests go with the sources that are built with EIGEN_RUNTIME_NO_MALLOC and assertions: target ssjs_watched"
#endif

namespace ssjs::testing {

/// Of this thread, by the counter of counted_heap.hpp; 0 where the heap cannot be watched.
[[nodiscard]] long allocations_so_far();

/// While it lives, an Eigen matrix that would allocate ends the process with an assertion that names the place.
class NoMalloc {
 public:
  NoMalloc() : before_(allocations_so_far()) { Eigen::internal::set_is_malloc_allowed(false); }
  NoMalloc(const NoMalloc&) = delete;
  NoMalloc& operator=(const NoMalloc&) = delete;
  ~NoMalloc() { Eigen::internal::set_is_malloc_allowed(true); }
  [[nodiscard]] long taken() const { return allocations_so_far() - before_; }

 private:
  long before_;
};

}  // namespace ssjs::testing
