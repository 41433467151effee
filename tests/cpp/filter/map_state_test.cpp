#include "ssjs/filter/map_state.hpp"

#include <gtest/gtest.h>

namespace ssjs {
namespace {

TEST(MapState, BlocksLieBehindEachOther) {
  EXPECT_EQ(StateLayout().offset(0), 3);
  EXPECT_EQ(StateLayout().offset(4), 11);
  EXPECT_EQ(StateLayout().size(4), 11);
  EXPECT_EQ(StateLayout{true}.offset(0), 6);
  EXPECT_EQ(StateLayout{true}.size(4), 14);
  MapState state{Eigen::VectorXd::LinSpaced(7, 1.0, 7.0), Eigen::MatrixXd(7, 7)};
  for (Eigen::Index i = 0; i < 49; ++i) state.covariance.data()[i] = static_cast<double>(i);  // entry (r, c) = r + 7 c
  EXPECT_EQ(state.landmarks(), 2);
  EXPECT_EQ(state.vehicle().mean.vector(), Eigen::Vector3d(1.0, 2.0, 3.0));
  EXPECT_EQ(state.vehicle().covariance(2, 1), 9.0);
  EXPECT_EQ(state.landmark(1).mean, Eigen::Vector2d(6.0, 7.0));
  EXPECT_EQ(state.landmark(1).covariance(0, 1), 5.0 + 7.0 * 6.0);
  EXPECT_EQ((state.covariance(state.layout.landmark(0), StateLayout::vehicle()))(1, 2), 4.0 + 7.0 * 2.0);
}

TEST(MapState, HeadingIsWrapped) {
  MapState state{Eigen::Vector3d(0.0, 0.0, 4.0), Eigen::Matrix3d::Identity()};
  EXPECT_NEAR(state.vehicle().mean.heading, 4.0 - 2.0 * kPi, 1e-15);
}

}  // namespace
}  // namespace ssjs
