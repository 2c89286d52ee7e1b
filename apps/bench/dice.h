// The generator of one simulated campaign.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>

namespace tribotrack::bench {

/// Depends on what it is given alone.
class Dice {
 public:
  Dice(std::uint64_t seed, std::uint32_t what, int index) {
    std::seed_seq mixed{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32), what,
                        static_cast<std::uint32_t>(index)};
    random_.seed(mixed);
  }
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  double normal() { return normal_(random_); }
  Eigen::Vector2d normal_pair() {
    const double x = normal();
    return {x, normal()};
  }

 private:
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

}  // namespace tribotrack::bench
