/// The whole configuration of a run: one section a stage.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/features/persistence_filter.hpp"
#include "ssjs/features/sonar_point_detector.hpp"
#include "ssjs/features/tree_detector.hpp"
#include "ssjs/joining/augmented.hpp"
#include "ssjs/joining/compressed.hpp"
#include "ssjs/joining/conditionally_independent.hpp"
#include "ssjs/joining/divide_and_conquer.hpp"
#include "ssjs/joining/selective.hpp"
#include "ssjs/mapping/submap_builder.hpp"
#include "ssjs/pipeline/smoother.hpp"
#include "ssjs/sensors/ackerman.hpp"
#include "ssjs/sensors/odometry_increment.hpp"
#include "ssjs/sensors/range_bearing.hpp"
#include "ssjs/sensors/unicycle.hpp"

namespace ssjs {

enum class Method {
  kSelective,
  kEkf,
  kAugmentedEkf,
  kCompressedEkf,
  kConditionallyIndependent,
  kSequential,
  kDivideAndConquer,
  kHierarchical,
  kConstrainedLocal,
  kSelectiveThesis
};
enum class VehicleKind { kAckerman, kUnicycle, kIncrements };

struct VehicleConfig {
  VehicleKind kind = VehicleKind::kAckerman;
  AckermanConfig ackerman;
  UnicycleConfig unicycle;
  IncrementsConfig increments;
  template <class Visitor>
  void visit(Visitor& v) {
    v.choice("kind", kind,
             Choices<VehicleKind>{
                 {"ackerman", VehicleKind::kAckerman}, {"unicycle", VehicleKind::kUnicycle}, {"increments", VehicleKind::kIncrements}},
             "motion model: steering and wheel speed, speed and turn rate, or measured pose increments");
    v.section("ackerman", ackerman, "car-like vehicle");
    v.section("unicycle", unicycle, "speed and turn rate");
    v.section("increments", increments, "measured pose increments");
  }
};

struct SlamConfig {
  Method method = Method::kSelective;
  VehicleConfig vehicle;
  RangeBearingConfig sensor;
  TreeDetectorConfig trees;
  SonarPointConfig sonar_points;
  PersistenceConfig persistence;
  ScanAssociationConfig association;
  SubmapBuilderConfig submap;
  SelectiveJoinerConfig joining;
  ConditionallyIndependentConfig cis;
  CompressedEkfConfig cekf;
  AugmentedEkfConfig aekf;
  DivideAndConquerConfig dcs;
  SmoothingConfig smoothing;
  template <class Visitor>
  void visit(Visitor& v) {
    v.choice(
        "method", method,
        Choices<Method>{{"ssjs", Method::kSelective},
                        {"ekf", Method::kEkf},
                        {"aekf", Method::kAugmentedEkf},
                        {"lmj", Method::kSequential},
                        {"dcs", Method::kDivideAndConquer},
                        {"hs", Method::kHierarchical},
                        {"cis", Method::kConditionallyIndependent},
                        {"cekf", Method::kCompressedEkf},
                        {"clsf", Method::kConstrainedLocal},
                        {"ssjs-thesis", Method::kSelectiveThesis}},
        "selective submap joining; one endless EKF map, plain, augmented (aekf) or compressed (cekf); submaps joined in sequence (lmj), "
        "by divide and conquer (dcs), tied by their links alone (hs), conditionally independent (cis), constrained to a global map "
        "(clsf); selective joining as printed in the thesis (ssjs-thesis)");
    v.section("vehicle", vehicle, "how the vehicle moves");
    v.section("sensor", sensor, "range and bearing of landmarks");
    v.section("trees", trees, "landmarks from laser scans");
    v.section("sonar_points", sonar_points, "landmarks from the hits of a forward-looking sonar");
    v.section("persistence", persistence, "observations that earlier scans must confirm");
    v.section("association", association, "which observation is of which landmark");
    v.section("submap", submap, "local maps");
    v.section("joining", joining, "the global level");
    v.section("cis", cis, "conditionally independent submaps");
    v.section("cekf", cekf, "compressed EKF");
    v.section("aekf", aekf, "augmented EKF");
    v.section("dcs", dcs, "divide and conquer");
    v.section("smoothing", smoothing, "least squares over the whole mission at its end");
  }

  /// Every violation, rules between fields included; empty when valid.
  [[nodiscard]] std::vector<std::string> violations() const;
};

}  // namespace ssjs
