#include "ssjs/base/random.hpp"

#include <cmath>
#include <sstream>
#include <string>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

std::uint64_t rotate_left(std::uint64_t value, int bits) { return (value << bits) | (value >> (64 - bits)); }

/// One step of splitmix64 (Steele, Lea, Flood 2014; Vigna's public-domain code). Advances `state`.
std::uint64_t splitmix64(std::uint64_t& state) {
  state += 0x9e3779b97f4a7c15U;
  std::uint64_t z = state;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
  return z ^ (z >> 31);
}

/// FNV-1a, 64 bits: the same value on every platform, unlike std::hash.
std::uint64_t fnv1a(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  return hash;
}

}  // namespace

Rng::Rng(std::uint64_t seed) : seed_(seed) {
  for (std::uint64_t& word : state_) word = splitmix64(seed);
}

Rng Rng::stream(std::string_view name) const {
  // The seed is mixed before the name joins it, so that neighbouring seeds and similar names share no stream.
  std::uint64_t state = seed_;
  state = splitmix64(state) ^ fnv1a(name);
  return Rng(splitmix64(state));
}

std::uint64_t Rng::next() {
  const std::uint64_t result = rotate_left(state_[1] * 5, 7) * 9;
  const std::uint64_t shifted = state_[1] << 17;
  state_[2] ^= state_[0];
  state_[3] ^= state_[1];
  state_[1] ^= state_[2];
  state_[0] ^= state_[3];
  state_[2] ^= shifted;
  state_[3] = rotate_left(state_[3], 45);
  return result;
}

double Rng::uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }

double Rng::uniform(double low, double high) {
  if (!(low <= high) || !std::isfinite(high - low)) {
    std::ostringstream interval;
    interval << "[" << low << ", " << high << ")";
    throw InvalidArgument("Rng::uniform interval", interval.str(), "low must not exceed high, both finite");
  }
  const double value = low + (high - low) * uniform();
  return value < high ? value : std::nextafter(high, low);  // rounding can land on high itself; [low, low) gives low
}

std::uint64_t Rng::below(std::uint64_t bound) {
  if (bound == 0) throw InvalidArgument("Rng::below bound", "0", "must be positive");
  const std::uint64_t remainder = (0 - bound) % bound;  // 2^64 mod bound: so many values would make the first results more frequent
  std::uint64_t value = next();
  while (value < remainder) value = next();
  return value % bound;
}

double Rng::normal() {
  if (has_spare_normal_) {
    has_spare_normal_ = false;
    return spare_normal_;
  }
  double u = 0.0;
  double v = 0.0;
  double s = 0.0;
  do {
    u = 2.0 * uniform() - 1.0;
    v = 2.0 * uniform() - 1.0;
    s = u * u + v * v;
  } while (s >= 1.0 || s == 0.0);
  const double scale = std::sqrt(-2.0 * std::log(s) / s);
  spare_normal_ = v * scale;
  has_spare_normal_ = true;
  return u * scale;
}

}  // namespace ssjs
