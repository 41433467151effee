/// Reproducible random numbers: the same seed gives the same numbers with every compiler and standard library.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace ssjs {

/// xoshiro256** (Blackman and Vigna 2018), seeded through splitmix64. Normal deviates by Marsaglia's polar method.
/// A named stream depends on the seed and on the name alone, so that a new draw in one stream moves nothing in another.
class Rng {
 public:
  explicit Rng(std::uint64_t seed);

  /// An independent generator for `name`; does not advance this one.
  [[nodiscard]] Rng stream(std::string_view name) const;

  std::uint64_t next();                      ///< 64 uniform bits
  double uniform();                          ///< in [0, 1)
  double uniform(double low, double high);   ///< in [low, high)
  std::uint64_t below(std::uint64_t bound);  ///< in [0, bound), unbiased; bound > 0
  double normal();                           ///< mean 0, standard deviation 1
  double normal(double standard_deviation) { return standard_deviation * normal(); }

 private:
  std::uint64_t seed_;
  std::array<std::uint64_t, 4> state_{};
  double spare_normal_ = 0.0;
  bool has_spare_normal_ = false;
};

}  // namespace ssjs
