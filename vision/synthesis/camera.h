// The camera of a synthetic scene: what acts on whole pixels, its noise, the exposure in time.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "vision/picture.h"
#include "vision/scene.h"

namespace tribotrack::vision {

// What acts on whole pixels of a synthetic scene: vignetting, flickering light, noise and the depth of the
// levels.

class SceneCamera {
 public:
  explicit SceneCamera(const Scene& scene);

  /// Mean of 1 + f sin(2 pi h t) over [time - exposure / 2, time + exposure / 2].
  double flicker(double time_s, double exposure_s) const;
  /// From light on the 8-bit scale to exact levels: 1 - vignetting (r / r_corner)^2, times 2^(bits - 8).
  void to_levels(Picture& picture) const;
  /// From exact to recorded levels: Gaussian noise of variance read^2 + shot I from seed and index alone,
  /// rounding, clipping to 0 .. 2^bits - 1.
  void record(Picture& picture, std::int64_t index) const;

 private:
  double flicker_ = 0, flicker_hz_ = 0;
  float read_variance_ = 0;       // at the recording's own depth
  float variance_per_level_ = 0;  // likewise
  float top_level_ = 255;
  std::uint64_t seed_ = 0;
  Picture gain_;
};

// Random numbers that depend on nothing but a seed, a stream and a counter: frames can be drawn in any order.

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

// The motion within one exposure as a few weighted poses.

struct ExposureNode {
  double weight = 1;  ///< share of the exposure; they add up to 1
  ScenePose pose;
};

/// Gauss-Legendre nodes over [time - exposure / 2, time + exposure / 2]: one for a scene at rest, else as
/// many as the longest path of disc, rim and platform needs against the smallest blur and the shortest
/// texture wave. Throws std::invalid_argument for a negative exposure and for a pose that is not finite.
std::vector<ExposureNode> exposure_nodes(double time_s, double exposure_s,
                                         const std::function<ScenePose(double)>& pose, double radius_px,
                                         double smallest_blur_px, double largest_wave_number,
                                         double tolerance);

// Gauss-Legendre rules for the integrals of a synthetic scene: over a pixel and over an exposure.

/// mean of f over [-1/2, 1/2] = sum weights[i] f(nodes[i]); the weights add up to 1.
struct QuadratureRule {
  std::vector<double> nodes;
  std::vector<double> weights;
};

/// Exact for polynomials up to degree 2 points - 1. Throws std::invalid_argument for fewer than one point.
QuadratureRule gauss_legendre(int points);

/// Points needed for the mean over a unit interval of an edge 0.5 erfc(x / (sqrt2 blur)), to `tolerance` of
/// its height. The error is C_n max |f^(2n)|, C_n = n!^4 / ((2n + 1) (2n)!^3), and Cramer's inequality bounds
/// the derivative by 0.435 sqrt((2n - 1)!) / blur^2n. At most 256.
int gauss_points_for_edge(double blur, double tolerance);

/// Same for the wave cos(wave_number x + phase).
int gauss_points_for_wave(double wave_number, double tolerance);

}  // namespace tribotrack::vision
