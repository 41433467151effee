#include "ssjs/geometry/point_grid.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "ssjs/base/error.hpp"
#include "ssjs/base/random.hpp"

namespace ssjs {
namespace {

using Indices = std::vector<Eigen::Index>;

Indices by_search(const Eigen::Matrix2Xd& points, const Eigen::Vector2d& centre, double radius_m) {
  Indices found;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    if ((points.col(i) - centre).norm() <= radius_m) found.push_back(i);
  }
  return found;
}

TEST(PointGrid, FindsWhatALookAtEveryPointFinds) {
  Rng rng(41);
  Eigen::Matrix2Xd points(2, 400);
  for (Eigen::Index i = 0; i < points.cols(); ++i) points.col(i) << rng.uniform(-30.0, 30.0), rng.uniform(-10.0, 50.0);
  for (const double cell_m : {0.5, 5.0, 500.0}) {
    const PointGrid grid(points, cell_m);
    for (int query = 0; query < 50; ++query) {
      const Eigen::Vector2d centre(rng.uniform(-40.0, 40.0), rng.uniform(-20.0, 60.0));
      const double radius_m = rng.uniform(0.0, 15.0);
      EXPECT_EQ(grid.within(centre, radius_m), by_search(points, centre, radius_m));
    }
  }
}

TEST(PointGrid, TheRadiusBelongsToTheAnswer) {
  Eigen::Matrix2Xd points(2, 3);
  points << 0.0, 3.0, -5.0, 0.0, 4.0, 0.0;
  const PointGrid grid(points, 5.0);
  EXPECT_EQ(grid.within({0.0, 0.0}, 5.0), (Indices{0, 1, 2}));
  EXPECT_EQ(grid.within({0.0, 0.0}, 4.999), (Indices{0}));
  EXPECT_EQ(grid.within({0.0, 0.0}, 0.0), (Indices{0}));
}

TEST(PointGrid, PointsVeryFarApartCostNoMemoryOrTime) {
  Eigen::Matrix2Xd points(2, 3);
  points << 0.0, 1e15, -1e300, 0.0, 1e15, 1.0;
  const PointGrid grid(points, 1e-3);
  EXPECT_EQ(grid.within({0.0, 0.0}, 1e16), (Indices{0, 1}));
  EXPECT_EQ(grid.within({1e15, 1e15}, 1.0), (Indices{1}));
}

TEST(PointGrid, WithoutPointsNothingIsFound) {
  const PointGrid grid(Eigen::Matrix2Xd(2, 0), 1.0);
  EXPECT_TRUE(grid.within({0.0, 0.0}, 100.0).empty());
}

TEST(PointGrid, BrokenContractsAreNamed) {
  Eigen::Matrix2Xd points = Eigen::Matrix2Xd::Zero(2, 1);
  EXPECT_THROW(PointGrid(points, 0.0), InvalidArgument);
  EXPECT_THROW(PointGrid(points, std::numeric_limits<double>::quiet_NaN()), InvalidArgument);
  points(1, 0) = std::numeric_limits<double>::infinity();
  EXPECT_THROW(PointGrid(points, 1.0), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
