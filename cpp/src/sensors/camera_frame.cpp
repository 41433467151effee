#include "ssjs/sensors/camera_frame.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "ssjs/base/error.hpp"

namespace ssjs {

std::optional<double> descriptor_distance(const Descriptor& a, const Descriptor& b) {
  if (a.size() == 0 || b.size() == 0) return std::nullopt;
  if (a.size() != b.size()) {
    throw InvalidArgument("descriptor", static_cast<double>(b.size()),
                          "must have as many numbers as those before it, " + std::to_string(a.size()));
  }
  const float lengths = a.norm() * b.norm();
  if (!(lengths > 0.0F)) return std::nullopt;
  return static_cast<double>(std::sqrt(std::max(0.0F, 2.0F - 2.0F * a.dot(b) / lengths)));
}

}  // namespace ssjs
