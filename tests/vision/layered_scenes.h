// Recordings of rendered scenes with their truth, for the tests of the layered pass. The renderer integrates
// analytic scenes and owes nothing to our interpolation.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "vision/cramer_rao_bound.h"
#include "vision/frame_source.h"
#include "vision/scene.h"
#include "vision/track_errors.h"

namespace tribotrack::vision::test {

/// A disc that slides along x over a platform that circles (2.8 px), with a marker at the left.
struct SlidingScene {
  Scene scene;
  int frames = 240;
  double path_px = 150;
  double spin_rad = 0;  ///< over the whole recording
  double circle_px = 2.8;

  SlidingScene() {
    scene.width = 300;
    scene.height = 110;
    scene.disc.radius_px = 30;
    scene.disc.scratches = 0;
    scene.disc.highlight = 0;
    scene.platform.level = 70;
    scene.platform.texture_rms = 6;
    scene.read_noise = 1.2;
    scene.marker = MarkerAppearance{{22, 30}, 12};
    scene.seed = 77;
  }
  ScenePose pose(double frame) const {
    ScenePose p;
    p.platform = {circle_px * std::cos(0.25 * frame), -circle_px * std::sin(0.25 * frame)};
    const double share = frame / frames;
    p.disc = {85.3 + path_px * share + 0.8 * p.platform.x, 56.4 + 4 * share + 0.8 * p.platform.y};
    p.theta = spin_rad * share;
    return p;
  }
  Point truth(std::int64_t frame) const { return pose(static_cast<double>(frame)).disc; }
  /// Cramer-Rao bound of a coordinate, rms of the two, px; of a frame midway.
  double bound() const {
    const SceneRenderer renderer(scene);
    const Eigen::Matrix2d c = position_bound(renderer, 0, 0, [&](double) { return pose(0.5 * frames); });
    return std::sqrt(0.5 * c.trace());
  }
};

/// A sliding scene's recording.
class SceneSource : public MemorySource {
 public:
  explicit SceneSource(const SlidingScene& scene) : MemorySource(rendered(scene), 250, scene.scene.bits) {}

 private:
  static std::vector<Picture> rendered(const SlidingScene& scene) {
    const SceneRenderer renderer(scene.scene);
    std::vector<Picture> pictures;
    for (int k = 0; k < scene.frames; ++k)
      pictures.push_back(renderer.render(k, 0, 0, [&](double) { return scene.pose(k); }));
    return pictures;
  }
};

inline TrackErrors errors_of(const Track& track, const SlidingScene& scene) {
  return errors_of(track, [&](std::int64_t frame) { return scene.truth(frame); });
}

}  // namespace tribotrack::vision::test
