#include "ssjs/filter/map_state.hpp"

namespace ssjs {

GaussianSe2 MapState::vehicle() const {
  return {Se2::from_vector(mean(StateLayout::vehicle())), covariance(StateLayout::vehicle(), StateLayout::vehicle())};
}

GaussianPoint2 MapState::landmark(Eigen::Index index) const {
  return {mean(layout.landmark(index)), covariance(layout.landmark(index), layout.landmark(index))};
}

}  // namespace ssjs
