/// Whether a gyro turns as attitude and compass say. Its rates are an input of the filter and have no gate there. docs/faults.md
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "ssjs/base/archive.hpp"
#include "ssjs/features/navigation_tick.hpp"

namespace ssjs {

/// Angles measured less angles integrated stay where they are while the gyro is right. A sample of attitude that is wrong makes them leap
/// and come back, a gyro that is wrong leaves them elsewhere: the median of kBlock samples is compared with the kMedians before it.
class GyroWitness {
 public:
  static constexpr std::size_t kBlock = 15;
  static constexpr std::size_t kMedians = 4;

  /// `disagreement_rad` between two medians is too much, of the compass three times as much; without it nobody looks. After a doubt so many
  /// blocks in a row must agree to half of it, twice as many each time.
  explicit GyroWitness(std::optional<double> disagreement_rad, int recover_blocks);

  /// Times must not decrease. The tick holds the rates that the filter would get.
  void see(const NavigationTick& tick);
  [[nodiscard]] bool is_doubted() const { return is_doubted_; }
  /// Standard deviations of roll, pitch and yaw (rad) that the filter does not know of, when see() has just begun to doubt.
  [[nodiscard]] const std::optional<Eigen::Vector3d>& astray_rad() const { return astray_rad_; }

 private:
  /// One angle: the differences of a block, relative to the first.
  struct Angle {
    std::array<double, kBlock> block{};
    std::size_t count = 0;
    double reference_rad = 0.0;  ///< what the differences are relative to
    double begin_s = 0.0;
    struct Median {
      double angle_rad = 0.0;
      double begin_s = 0.0;

      void archive(Archive& a) {
        a("angle_rad", angle_rad);
        a("begin_s", begin_s);
      }
    };
    std::array<Median, kMedians> medians{};  ///< of the blocks before, each in its place for a while
    std::int64_t blocks = 0;

    void archive(Archive& a) {
      a("block", block);
      a("count", count);
      a("reference_rad", reference_rad);
      a("begin_s", begin_s);
      a("medians", medians);
      a("blocks", blocks);
      a.require(count < kBlock && blocks >= 0, "has a block that is over-full");
    }
  };

  void integrate_to(double time_s);
  void forget();
  /// How far the angle has moved since any of the blocks before, when this sample ends a block.
  [[nodiscard]] static std::optional<double> moved(Angle& angle, double time_s, double difference_rad);

  std::optional<double> disagreement_rad_;
  int recover_blocks_;
  Eigen::Vector3d rates_rad_s_ = Eigen::Vector3d::Zero();
  std::optional<double> rates_s_;                             ///< when they were sampled
  Eigen::Vector3d turned_rad_ = Eigen::Vector3d::Zero();      ///< roll, pitch, yaw by the gyro alone
  double turned_s_ = 0.0;                                     ///< until when
  Eigen::Vector2d roll_pitch_rad_ = Eigen::Vector2d::Zero();  ///< measured last
  double compass_rad_ = 0.0;
  std::array<Angle, 3> angles_{};
  bool is_doubted_ = false;
  int agreed_ = 0, needed_ = 0;
  std::optional<Eigen::Vector3d> astray_rad_;

 public:
  void archive(Archive& a) {
    a("rates_rad_s", rates_rad_s_);
    a("rates_s", rates_s_);
    a("turned_rad", turned_rad_);
    a("turned_s", turned_s_);
    a("roll_pitch_rad", roll_pitch_rad_);
    a("compass_rad", compass_rad_);
    a("angles", angles_);
    a("is_doubted", is_doubted_);
    a("agreed", agreed_);
    a("needed", needed_);
  }
};

}  // namespace ssjs
