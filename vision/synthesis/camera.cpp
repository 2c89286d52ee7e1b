#include "vision/synthesis/camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "vision/synthesis/noise.h"

namespace tribotrack::vision {
namespace {

constexpr std::uint64_t kNoiseStream = 0x6e015e0000000000u;  // away from the streams of the appearance

}  // namespace

SceneCamera::SceneCamera(const Scene& scene)
    : flicker_(scene.flicker),
      flicker_hz_(scene.flicker_hz),
      seed_(scene.seed),
      gain_(scene.width, scene.height) {
  const double scale = std::ldexp(1.0, scene.bits - 8);
  read_variance_ = static_cast<float>(scene.read_noise * scene.read_noise * scale * scale);
  variance_per_level_ = static_cast<float>(scene.shot_noise * scale);
  top_level_ = static_cast<float>(std::ldexp(1.0, scene.bits) - 1);
  const double x_middle = (scene.width - 1) / 2.0;
  const double y_middle = (scene.height - 1) / 2.0;
  const double corner = std::max(1.0, x_middle * x_middle + y_middle * y_middle);
  for (int y = 0; y < scene.height; ++y) {
    for (int x = 0; x < scene.width; ++x) {
      const double r2 = (x - x_middle) * (x - x_middle) + (y - y_middle) * (y - y_middle);
      gain_.at(x, y) = static_cast<float>(scale * (1 - scene.vignetting * r2 / corner));
    }
  }
}

double SceneCamera::flicker(double time_s, double exposure_s) const {
  const double half_turn = std::numbers::pi * flicker_hz_ * exposure_s;
  const double smoothing = std::abs(half_turn) < 1e-9 ? 1.0 : std::sin(half_turn) / half_turn;
  return 1 + flicker_ * smoothing * std::sin(2 * std::numbers::pi * flicker_hz_ * time_s);
}

void SceneCamera::to_levels(Picture& picture) const {
  for (std::size_t i = 0; i < picture.levels().size(); ++i) picture.levels()[i] *= gain_.levels()[i];
}

void SceneCamera::record(Picture& picture, std::int64_t index) const {
  const CounterRandom random(seed_, kNoiseStream + static_cast<std::uint64_t>(index));
  const bool noisy = read_variance_ > 0 || variance_per_level_ > 0;
  const std::span<float> levels = picture.levels();
  for (std::size_t i = 0; i < levels.size(); ++i) {
    float level = levels[i];
    if (noisy) {
      const float variance = read_variance_ + variance_per_level_ * std::max(level, 0.0F);
      level += std::sqrt(variance) * random.gaussian(i);
    }
    levels[i] = static_cast<float>(static_cast<int>(std::clamp(level, 0.0F, top_level_) + 0.5F));
  }
}

}  // namespace tribotrack::vision
