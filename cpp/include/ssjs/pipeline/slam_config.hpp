/// The whole configuration of a run: one section a stage.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/features/tree_detector.hpp"
#include "ssjs/joining/selective.hpp"
#include "ssjs/mapping/submap_builder.hpp"
#include "ssjs/pipeline/smoother.hpp"
#include "ssjs/sensors/ackerman.hpp"
#include "ssjs/sensors/range_bearing.hpp"
#include "ssjs/sensors/unicycle.hpp"

namespace ssjs {

enum class Method { kSelective, kEkf };
enum class VehicleKind { kAckerman, kUnicycle, kIncrements };

struct VehicleConfig {
  VehicleKind kind = VehicleKind::kAckerman;
  AckermanConfig ackerman;
  UnicycleConfig unicycle;
  template <class Visitor>
  void visit(Visitor& v) {
    v.choice("kind", kind,
             Choices<VehicleKind>{
                 {"ackerman", VehicleKind::kAckerman}, {"unicycle", VehicleKind::kUnicycle}, {"increments", VehicleKind::kIncrements}},
             "motion model: steering and wheel speed, speed and turn rate, or measured pose increments");
    v.section("ackerman", ackerman, "car-like vehicle");
    v.section("unicycle", unicycle, "speed and turn rate");
  }
};

struct SlamConfig {
  Method method = Method::kSelective;
  VehicleConfig vehicle;
  RangeBearingConfig sensor;
  TreeDetectorConfig trees;
  ScanAssociationConfig association;
  SubmapBuilderConfig submap;
  SelectiveJoinerConfig joining;
  SmoothingConfig smoothing;
  template <class Visitor>
  void visit(Visitor& v) {
    v.choice("method", method, Choices<Method>{{"ssjs", Method::kSelective}, {"ekf", Method::kEkf}},
             "selective submap joining, or one endless EKF map");
    v.section("vehicle", vehicle, "how the vehicle moves");
    v.section("sensor", sensor, "range and bearing of landmarks");
    v.section("trees", trees, "landmarks from laser scans");
    v.section("association", association, "which observation is of which landmark");
    v.section("submap", submap, "local maps");
    v.section("joining", joining, "the global level");
    v.section("smoothing", smoothing, "least squares over the whole mission at its end");
  }

  /// Every violation, rules between fields included; empty when valid.
  [[nodiscard]] std::vector<std::string> violations() const;
};

}  // namespace ssjs
