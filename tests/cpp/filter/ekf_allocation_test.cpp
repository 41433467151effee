// Counts what the filter takes from the heap. Eigen allocates with malloc and the standard library with operator new, which ends in
// malloc too: standing in front of malloc sees both.
#include <gtest/gtest.h>

#include <cstdlib>

#include "ssjs/filter/ekf.hpp"
#include "ssjs/sensors/ackerman.hpp"
#include "ssjs/sensors/range_bearing.hpp"

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define SSJS_SANITIZED
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SSJS_SANITIZED
#endif
#if defined(__GLIBC__) && !defined(SSJS_SANITIZED)
#define SSJS_COUNTS_ALLOCATIONS
#endif

namespace {
long allocations = 0;
}

#ifdef SSJS_COUNTS_ALLOCATIONS
extern "C" {
void* __libc_malloc(std::size_t size);                     // NOLINT(bugprone-reserved-identifier)
void* __libc_realloc(void* block, std::size_t size);       // NOLINT(bugprone-reserved-identifier)
void* __libc_calloc(std::size_t count, std::size_t size);  // NOLINT(bugprone-reserved-identifier)

void* malloc(std::size_t size) noexcept {
  ++allocations;
  return __libc_malloc(size);
}
void* realloc(void* block, std::size_t size) noexcept {
  ++allocations;
  return __libc_realloc(block, size);
}
void* calloc(std::size_t count, std::size_t size) noexcept {
  ++allocations;
  return __libc_calloc(count, size);
}
}
#endif

namespace ssjs {
namespace {

TEST(EkfAllocation, SteadyStateTakesNothingFromTheHeap) {
#ifndef SSJS_COUNTS_ALLOCATIONS
  GTEST_SKIP() << "the heap cannot be watched here (a sanitizer owns it, or the C library is not glibc)";
#endif
  for (const ErrorForm form : {ErrorForm::kAdditive, ErrorForm::kInvariant}) {
    constexpr Eigen::Index kLandmarks = 20;
    Ekf filter(kLandmarks, form);
    filter.reset({});
    const AckermanConfig vehicle;
    const Eigen::Matrix2d R = Eigen::Vector2d(0.01, 0.0003).asDiagonal();
    const auto drive = [&] { filter.predict(predict_ackerman(filter.vehicle_pose(), {3.0, 0.05}, 0.025, vehicle)); };
    for (Eigen::Index i = 0; i < kLandmarks; ++i) {
      drive();
      filter.add_landmark({Eigen::Vector2d(4.0 + 0.2 * static_cast<double>(i), -1.5 + 0.15 * static_cast<double>(i)), R, std::nullopt});
    }
    const std::vector<Eigen::Index> selected{3, 17, 8, 0, 11, 5, 19, 2};
    const std::vector<Pair> pairs{{0, 0}, {1, 1}, {2, 3}, {3, 5}, {4, 7}};
    Features scan(5);
    PairingProblem problem;
    const auto step = [&] {
      for (int i = 0; i < 3; ++i) drive();
      filter.predict_observations(selected, problem);
      for (const Pair& pair : pairs) {  // what is predicted is seen
        scan[static_cast<std::size_t>(pair.observation)].range_bearing = problem.predicted.segment<2>(2 * pair.prediction);
        scan[static_cast<std::size_t>(pair.observation)].covariance = R;
      }
      return filter.update(scan, pairs, selected);
    };
    (void)step();  // sizes of `problem` and of the workspace
    const long before = allocations;
    int updated = 0;
    for (int i = 0; i < 50; ++i) updated += step().dof;
    const long taken = allocations - before;
    EXPECT_EQ(updated, 50 * 10);
    EXPECT_EQ(taken, 0);
    // The counter counts: a vector that grows is seen.
    std::vector<double> grown;
    grown.resize(1000);
    EXPECT_GT(allocations - before, 0);
  }
}

}  // namespace
}  // namespace ssjs
