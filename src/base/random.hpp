// Reproducible random numbers: the value depends only on (seed, stream, counter), never on threads or call order elsewhere.
#pragma once
#include <cmath>
#include <cstdint>

namespace quern {

// A counter-based generator (SplitMix64's finalizer over the counter; Steele et al. 2014).
class RandomStream {
 public:
  explicit RandomStream(std::uint64_t seed, std::uint64_t stream = 0) : key_(mix(seed ^ mix(stream + 0x9e3779b97f4a7c15ull))) {}

  std::uint64_t next() { return mix(key_ + 0x9e3779b97f4a7c15ull * ++counter_); }
  double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }  // [0, 1)
  double uniform(double from, double to) { return from + (to - from) * uniform(); }
  // Standard normal, Box–Muller.
  double normal() {
    const double u = 1.0 - uniform(), angle = 6.283185307179586 * uniform();
    return std::sqrt(-2.0 * std::log(u)) * std::cos(angle);
  }

 private:
  static std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  }
  std::uint64_t key_, counter_ = 0;
};

}  // namespace quern
