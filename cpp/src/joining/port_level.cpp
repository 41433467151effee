#include "ssjs/joining/port_level.hpp"

#include "ssjs/base/angle.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {

PlacedFix place_fix(const Se2& global_T_base, const Eigen::Vector2d& base_p) {
  return {global_T_base * base_p, act_jacobian(global_T_base, base_p)};
}

void append_values(PortValues& values, const PortMap& map, const std::vector<Port>& ports) {
  const Eigen::VectorXd m = place_rows(map, state_rows(ports), values).mean;
  const Se2 global_T_base = values.base(map.base());
  Eigen::Index row = 0;
  for (const Port& port : ports) {
    std::size_t next = 0;
    switch (port.unknown.kind) {
      case UnknownKind::kBase:
        next = values.bases.size();
        values.bases.push_back(global_T_base * Se2::from_vector(m.segment<3>(row)));
        break;
      case UnknownKind::kOffset:
        next = values.offsets.size();
        values.offsets.push_back(wrap_angle(m(row) - global_T_base.heading));
        break;
      case UnknownKind::kLandmark:
        next = values.landmarks.size();
        values.landmarks.push_back(to_world(global_T_base, m.segment<3>(row)).position);
        break;
    }
    if (port.unknown.index < 0 || static_cast<std::size_t>(port.unknown.index) != next) {
      throw InvalidArgument("unknown.index", port.unknown.index, "a new unknown takes the next index of its kind");
    }
    row += rows_of(port.unknown.kind);
  }
}

}  // namespace ssjs
