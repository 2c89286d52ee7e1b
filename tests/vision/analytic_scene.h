// Test pictures that owe nothing to our own interpolation: a disc with a Gaussian-blurred edge and textures
// as sums of cosines, integrated over each pixel by quadrature.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <numbers>
#include <random>
#include <vector>

#include "vision/frame_source.h"
#include "vision/picture.h"

namespace tribotrack::vision::test {

/// sum of amplitude * cos(kx x + ky y + phase)
struct Wave {
  double amplitude, kx, ky, phase;
};

struct Waves {
  std::vector<Wave> waves;
  double operator()(double x, double y) const {
    double sum = 0;
    for (const Wave& w : waves) sum += w.amplitude * std::cos(w.kx * x + w.ky * y + w.phase);
    return sum;
  }
};

/// `count` waves with wavelengths of min_length .. 3 min_length px and the given rms.
inline Waves random_waves(std::mt19937& random, int count, double min_length, double rms) {
  std::uniform_real_distribution<double> angle(0, 2 * std::numbers::pi);
  std::uniform_real_distribution<double> length(min_length, 3 * min_length);
  Waves out;
  for (int k = 0; k < count; ++k) {
    const double k_size = 2 * std::numbers::pi / length(random);
    const double direction = angle(random);
    out.waves.push_back({rms * std::sqrt(2.0 / count), k_size * std::cos(direction),
                         k_size * std::sin(direction), angle(random)});
  }
  return out;
}

struct TestDisc {
  double x = 0, y = 0, radius = 12, theta = 0;
  double level = 150;
  Waves texture = {};  ///< turns with the disc
};

/// A Gaussian-blurred disc edge has no closed form; to second order in s / R it is the blurred straight edge
/// moved inwards by s^2 / (2 rho). At R = 12 and s = 0.7 the next term is below 1e-4 of the contrast.
inline double disc_share(double rho, double radius, double blur) {
  const double inward = rho > 1 ? blur * blur / (2 * rho) : 0;
  return 0.5 * std::erfc((rho - radius + inward) / (std::numbers::sqrt2 * blur));
}

struct TestScene {
  int width = 96, height = 96;
  double ground = 60;
  double blur = 0.7;  ///< optics; the pixel comes on top by integration
  Waves ground_texture;
  std::vector<TestDisc> discs;

  double level(double x, double y) const {
    double value = ground + ground_texture(x, y);
    for (const TestDisc& d : discs) {
      const double dx = x - d.x;
      const double dy = y - d.y;
      const double rho = std::hypot(dx, dy);
      if (rho > d.radius + 8 * blur) continue;
      const double share = disc_share(rho, d.radius, blur);
      double inside = d.level;
      if (!d.texture.waves.empty()) {
        const double c = std::cos(d.theta);
        const double s = std::sin(d.theta);
        inside += d.texture(c * dx - s * dy, s * dx + c * dy);
      }
      value += share * (inside - value);
    }
    return value;
  }

  /// Mean over each pixel, 3 x 3 Gauss points (exact to degree 5 in each direction).
  Picture render() const {
    constexpr double kNode = 0.3872983346207417;  // sqrt(3/5)/2
    constexpr double nodes[3] = {-kNode, 0, kNode};
    constexpr double shares[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
    Picture out(width, height);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        double sum = 0;
        for (int j = 0; j < 3; ++j)
          for (int i = 0; i < 3; ++i) sum += shares[i] * shares[j] * level(x + nodes[i], y + nodes[j]);
        out.at(x, y) = static_cast<float>(sum);
      }
    return out;
  }
};

/// Adds noise, rounds to whole levels and clips to 8 bits.
inline Picture noisy(const Picture& exact, double sigma, std::mt19937& random) {
  std::normal_distribution<double> normal(0, 1);
  Picture out = exact;
  for (float& level : out.levels())
    level = static_cast<float>(std::clamp(std::round(level + sigma * normal(random)), 0.0, 255.0));
  return out;
}

/// Frames made on demand.
class RenderedSource : public FrameSource {
 public:
  RenderedSource(int width, int height, std::int64_t frames, std::function<Picture(std::int64_t)> render)
      : render_(std::move(render)) {
    info_.path = "rendered";
    info_.width = width;
    info_.height = height;
    info_.bits = 8;
    info_.frame_count = frames;
    info_.time_base.rate_hz = 1000;
    info_.time_base.source = "test";
  }
  void named(const std::string& path) { info_.path = path; }
  void number_from(std::int64_t first) { info_.first_number = first; }
  void fill(std::int64_t index, const Rect& window, Picture& picture) override {
    const Picture& frame = rendered(index);
    for (int y = 0; y < window.height; ++y)
      std::copy_n(frame.row(window.y + y).begin() + window.x, window.width, picture.row(y).begin());
  }

 private:
  /// Several passes see the same frames: up to kKept pixels are kept.
  const Picture& rendered(std::int64_t index) {
    if (const auto it = frames_.find(index); it != frames_.end()) return it->second;
    const std::int64_t pixels = static_cast<std::int64_t>(info_.width) * info_.height;
    if (static_cast<std::int64_t>(frames_.size() + 1) * pixels > kKept) frames_.clear();
    return frames_.emplace(index, render_(index)).first->second;
  }

  static constexpr std::int64_t kKept = 25'000'000;
  std::function<Picture(std::int64_t)> render_;
  std::map<std::int64_t, Picture> frames_;
};

}  // namespace tribotrack::vision::test
