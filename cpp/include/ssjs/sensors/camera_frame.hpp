/// What a camera saw in one frame: keypoints, each with what it looks like. docs/math/camera.md.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "ssjs/base/archive.hpp"

namespace ssjs {

/// What the surroundings of a keypoint look like (64 numbers of SURF); those of one mission have one length. Empty: not known.
using Descriptor = Eigen::VectorXf;

/// A field of an archive, as numbers of double precision: exact.
inline void archive_descriptor(Archive& a, Descriptor& descriptor) {
  Eigen::VectorXd numbers = descriptor.cast<double>();
  a("descriptor", numbers);
  if (a.reading()) descriptor = numbers.cast<float>();
}

/// Between their directions, whatever their lengths: 0 alike, sqrt(2) nothing in common. Nothing where one of them is not known. Throws
/// InvalidArgument for descriptors of different lengths.
[[nodiscard]] std::optional<double> descriptor_distance(const Descriptor& a, const Descriptor& b);

struct CameraSighting {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< u, v of the frame whose lens is corrected (I-1)
  Descriptor descriptor{};
  std::optional<std::int64_t> landmark_id{};  ///< where the source knows it

  void archive(Archive& a) {
    a("pixel", pixel);
    archive_descriptor(a, descriptor);
    a("landmark_id", landmark_id);
  }
};

/// Of one exposure. A frame without sightings was taken and showed nothing.
struct CameraFrame {
  std::vector<CameraSighting> sightings;

  void archive(Archive& a) { a("sightings", sightings); }
};

}  // namespace ssjs
