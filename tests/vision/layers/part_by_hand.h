// The model of vision/layers/model/state.h written out: a disc with a blurred rim, marks and a shadow over a
// ground of waves, all known at every place, so that windows of it owe nothing to interpolation.
#pragma once

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "vision/analytic_scene.h"
#include "vision/layers/model/ground.h"
#include "vision/layers/model/part.h"
#include "vision/layers/model/state.h"

namespace tribotrack::vision::test {

struct PartByHand {
  double radius = 20, blur = 1.5;
  int half = 32;
  double shadow = 0;  ///< of the ground's light that it takes, to the right of the part
  double kappa = 0;   ///< px^2
  static constexpr Rect region{0, 0, 180, 130};  ///< of the platform

  Waves waves;      ///< of the ground about its level
  double mean = 0;  ///< mean G over the region

  PartByHand() {
    std::mt19937 random(11);
    waves = random_waves(random, 12, 8, 8);
    for (int y = 0; y < region.height; ++y)
      for (int x = 0; x < region.width; ++x)
        mean += ground_level(region.x + x, region.y + y) / (region.width * region.height);
  }

  double ground_level(double x, double y) const { return 70 + waves(x, y); }
  double share(double u, double v) const {
    const double beside = 0.5 * std::erfc((radius - std::hypot(u, v)) / (blur * std::numbers::sqrt2));
    return beside * (1 - shadow * std::exp(-0.5 * (std::pow(u - radius - 2, 2) + v * v) / 25));
  }
  double face(double u, double v) const {
    return 120 + 25 * std::exp(-0.5 * (std::pow(u - 7, 2) + std::pow(v + 5, 2)) / 6);
  }
  /// F.
  double level(double u, double v) const { return (1 - share(u, v)) * face(u, v) + share(u, v) * mean; }

  /// I at a pixel of the camera.
  double seen(const LayeredState& s, double x, double y) const {
    constexpr double kStep = 1e-4;
    const double u = x - s.centre.x, v = y - s.centre.y, gx = x - s.ground.x, gy = y - s.ground.y;
    double below = share(u, v) * ground_level(gx, gy);
    if (kappa > 0)
      below += kappa / (4 * kStep * kStep) *
               ((share(u + kStep, v) - share(u - kStep, v)) *
                    (ground_level(gx + kStep, gy) - ground_level(gx - kStep, gy)) +
                (share(u, v + kStep) - share(u, v - kStep)) *
                    (ground_level(gx, gy + kStep) - ground_level(gx, gy - kStep)));
    return s.gain * (1 + s.slope_x * u + s.slope_y * v) * (level(u, v) - share(u, v) * mean) +
           s.ground_gain * below;
  }

  /// Its window of `reach` px about the part, with white noise.
  KeptWindow window(const LayeredState& s, int reach, double noise, std::mt19937& random) const {
    std::normal_distribution<double> gauss(0, 1);
    KeptWindow w;
    w.state = s;
    w.x = static_cast<int>(std::lround(s.centre.x)) - reach;
    w.y = static_cast<int>(std::lround(s.centre.y)) - reach;
    w.picture = Picture(2 * reach + 1, 2 * reach + 1);
    for (int j = 0; j <= 2 * reach; ++j)
      for (int i = 0; i <= 2 * reach; ++i)
        w.picture.at(i, j) = static_cast<float>(seen(s, w.x + i, w.y + j) + noise * gauss(random));
    w.spline = QuinticSpline(w.picture);
    return w;
  }

  /// The ground's picture, known from `frames` frames of this noise.
  GroundPicture ground(double noise_variance, int frames = 4) const {
    Picture picture(region.width, region.height);
    for (int y = 0; y < region.height; ++y)
      for (int x = 0; x < region.width; ++x)
        picture.at(x, y) = static_cast<float>(ground_level(region.x + x, region.y + y));
    GroundPicture out(region);
    for (int k = 0; k < frames; ++k) out.add(picture, region.x, region.y, {}, {-1000, -1000, 1});
    out.finish(noise_variance);
    return out;
  }

  /// Its two pictures, and the variance of white noise.
  PartPictures pictures(double variance) const {
    const int size = 2 * half + 1;
    const auto v = static_cast<float>(variance);
    PartPictures out{half, Picture(size, size), Picture(size, size), Picture(size, size, v), kappa};
    for (int j = 0; j < size; ++j)
      for (int i = 0; i < size; ++i) {
        out.level.at(i, j) = static_cast<float>(level(i - half, j - half));
        out.share.at(i, j) = static_cast<float>(share(i - half, j - half));
      }
    return out;
  }
};

/// What the model's rooms take of windows.
inline std::vector<const KeptWindow*> pointers_to(const std::vector<KeptWindow>& windows) {
  std::vector<const KeptWindow*> out;
  for (const KeptWindow& w : windows) out.push_back(&w);
  return out;
}

/// A state by the number of a frame: the part winds over the region, the platform circles.
inline LayeredState state_of(int k) {
  LayeredState s;
  s.centre = {90 + 31.4 * std::sin(0.37 * k), 65 + 14.3 * std::cos(0.23 * k)};
  s.ground = {4.3 * std::cos(0.9 * k), 4.1 * std::sin(1.1 * k)};
  return s;
}

}  // namespace tribotrack::vision::test
