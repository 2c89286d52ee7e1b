// Random numbers that depend on nothing but a seed, a stream and a counter: frames can be drawn in any order.
#pragma once

#include <cstdint>

namespace tribotrack::vision {

/// x with P(N(0, 1) < x) = probability, to the accuracy of a double. +-infinity at 0 and 1.
double normal_quantile(double probability);

/// The value number `counter` of the stream (seed, stream). Calls do not disturb one another.
class CounterRandom {
 public:
  CounterRandom(std::uint64_t seed, std::uint64_t stream);
  std::uint64_t bits(std::uint64_t counter) const { return mix(key_ + counter * 0x9e3779b97f4a7c15u); }
  /// In (0, 1), never an end.
  double uniform(std::uint64_t counter) const {
    return (static_cast<double>(bits(counter) >> 12) + 0.5) * 0x1p-52;
  }
  /// Standard normal by a table of 4096 equally probable cells; the outermost two exactly, out to 8 sd.
  float gaussian(std::uint64_t counter) const;

 private:
  /// An invertible scramble of 64 bits (the finaliser of splitmix64; Steele, Lea and Flood 2014).
  static std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  std::uint64_t key_ = 0;
};

}  // namespace tribotrack::vision
