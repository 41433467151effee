#include "allocation/no_malloc.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "allocation/counted_heap.hpp"

namespace ssjs::testing {

long allocations_so_far() { return allocations; }

namespace {

TEST(NoMalloc, SeesWhatAMatrixAndAVectorTake) {
#ifndef SSJS_COUNTS_ALLOCATIONS
  GTEST_SKIP() << "the heap cannot be watched here";
#endif
  const NoMalloc forbidden;
  std::vector<double> grown;
  grown.resize(1000);
  EXPECT_EQ(forbidden.taken(), 1);
  EXPECT_DEATH(Eigen::MatrixXd::Zero(40, 40).eval(), "heap allocation is forbidden");
}

}  // namespace
}  // namespace ssjs::testing
