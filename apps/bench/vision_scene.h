// The benchmarks' rendered recordings: a disc goes round beside a marker, over a platform that rests or over
// a textured one that moves.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "vision/cramer_rao_bound.h"
#include "vision/scene.h"

namespace tribotrack::bench {

class BenchScene {
 public:
  static constexpr double kMarker = 26, kMarkerRadius = 12;  ///< px

  /// `texture`: of the platform, grey levels rms; without it rests. Pictures as small as they can be.
  BenchScene(double radius, double texture)
      : BenchScene(radius, texture, 2 * (static_cast<int>(std::ceil(radius)) + 22) + 61,
                   2 * (static_cast<int>(std::ceil(radius)) + 22) + 1, 125) {}
  BenchScene(double radius, double texture, int width, int height, int poses) : poses_(poses) {
    scene_.width = width;
    scene_.height = height;
    scene_.disc.radius_px = radius;
    scene_.disc.edge_blur_px = 0.7;
    scene_.disc.scratches = 0;
    scene_.disc.highlight = 0;
    scene_.platform.texture_rms = texture;
    scene_.marker = vision::MarkerAppearance{{kMarker, kMarker}, kMarkerRadius};
  }

  const vision::Scene& scene() const { return scene_; }
  int poses() const { return poses_; }  ///< of one turn; they come again
  bool textured() const { return scene_.platform.texture_rms > 0; }
  vision::ScenePose pose(int frame) const {
    const double turn = 2 * std::numbers::pi * (frame % poses_) / poses_;
    vision::ScenePose p;
    p.disc = {scene_.width / 2.0 + 29.7 + 3.7 * std::cos(3 * turn),
              scene_.height / 2.0 - 0.6 + 3.7 * std::sin(3 * turn)};
    if (textured()) p.platform = {5.6 * std::cos(5 * turn), -5.6 * std::sin(5 * turn)};
    return p;
  }
  std::function<vision::ScenePose(double)> at(int frame) const {
    return [p = pose(frame)](double) { return p; };
  }
  vision::Circle part(int frame) const {
    const vision::ScenePose p = pose(frame);
    return {p.disc.x, p.disc.y, scene_.disc.radius_px};
  }
  vision::Circle marker(int frame) const {
    const vision::ScenePose p = pose(frame);
    return {kMarker + p.platform.x, kMarker + p.platform.y, kMarkerRadius};
  }
  /// The poses of the first `frames` frames, without noise.
  std::vector<vision::Picture> render(int frames) const {
    const vision::SceneRenderer renderer(scene_);
    std::vector<vision::Picture> exact;
    for (int k = 0; k < std::min(poses_, frames); ++k) exact.push_back(renderer.render_exact(0, 0, at(k)));
    return exact;
  }
  /// The Cramer-Rao bound under this noise, px, rms over the path and both coordinates.
  double bound(double noise) const {
    vision::Scene noisy = scene_;
    noisy.read_noise = noise;
    const vision::SceneRenderer renderer(noisy);
    constexpr int kSamples = 8;
    double variance = 0;
    for (int k = 0; k < kSamples; ++k)
      variance += vision::position_bound(renderer, 0, 0, at(k * poses_ / kSamples)).trace() / (2 * kSamples);
    return std::sqrt(variance);
  }

 private:
  vision::Scene scene_;
  int poses_;
};

}  // namespace tribotrack::bench
