// The planar filter takes nothing from the heap: counted, and by Eigen's own word.
#include <gtest/gtest.h>

#include "allocation/no_malloc.hpp"
#include "ssjs/filter/ekf.hpp"
#include "ssjs/sensors/ackerman.hpp"
#include "ssjs/sensors/range_bearing.hpp"

namespace ssjs {
namespace {

TEST(EkfAllocation, SteadyStateTakesNothingFromTheHeap) {
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
    int updated = 0;
    {
      const testing::NoMalloc forbidden;
      for (int i = 0; i < 50; ++i) updated += step().dof;
      EXPECT_EQ(forbidden.taken(), 0);
    }
    EXPECT_EQ(updated, 50 * 10);
  }
}

}  // namespace
}  // namespace ssjs
