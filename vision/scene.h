// Synthetic recordings with exactly known truth: an analytic scene integrated over pixels and exposure, never
// an interpolated picture.
//
// A disc on a platform seen from above, with a marker ring and a lamp on demand; lengths in px, angles in
// rad, grey levels on the 8-bit scale whatever the depth. A recording of a disc in circular motion:
//
//   Scene scene;
//   scene.bits = 12;
//   scene.marker = MarkerAppearance{{60, 60}};
//   const SceneRenderer renderer(scene);
//   const auto pose = [](double t) {
//     return ScenePose{{160 + 20 * std::cos(40 * t), 120 - 20 * std::sin(40 * t)}, 0.1 * t, {}};
//   };
//   for (int k = 0; k < 1000; ++k) sink->write(renderer.render(k, k / 5000.0, 20e-6, pose));
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "vision/picture.h"

namespace tribotrack::vision {

/// Where things are at one time. Pixels as seen by the camera; theta counter-clockwise with y up, rad.
struct ScenePose {
  Point disc;        ///< the disc's centre
  double theta = 0;  ///< the disc's rotation
  Point platform;    ///< the platform's displacement from its mean position
};

struct DiscAppearance {
  double radius_px = 30;
  double level = 170;            ///< grey level under scratches and highlight (8-bit scale), see Scene::bits
  double edge_blur_px = 0.8;     ///< Gaussian sd of every edge (optics), before pixel integration; >= 0.1
  int scratches = 12;            ///< disc-fixed, turn with it; alternately bright and dark
  double scratch_contrast = 15;  ///< grey levels
  double highlight = 25;         ///< lighting-fixed: does not turn; peak grey levels
  bool visible = true;
};

struct PlatformAppearance {
  double level = 80;
  double texture_rms = 8;  ///< grey levels, brushed along `brush_angle`
  double brush_angle_rad = 0.3;
  double texture_length_px = 40;  ///< correlation length along the brush
  double texture_width_px = 3;    ///< across it
};

struct MarkerAppearance {
  Point position;         ///< mean position of its centre, px
  double radius_px = 10;  ///< outer radius of the ring; the dot's is half of it
  double level = 20;      ///< dark dot on a bright ring
  double ring_level = 220;
};

/// A disc of light that does not move. It lies over everything, shines by its own light (no flicker) and
/// blinks.
struct Lamp {
  Point position;
  double radius_px = 6;
  double on_level = 230, off_level = 20;
};

struct Scene {
  int width = 320, height = 240;
  int bits = 8;  ///< levels above are on the 8-bit scale and multiplied by 2^(bits - 8)
  DiscAppearance disc;
  PlatformAppearance platform;
  std::optional<MarkerAppearance> marker;
  std::optional<Lamp> lamp;
  double vignetting = 0.0;  ///< share of brightness lost in the corners, as distance squared from the middle
  double flicker = 0.0;     ///< relative amplitude f of the light: 1 + f sin(2 pi flicker_hz t)
  double flicker_hz = 100;
  double read_noise = 1.0;  ///< sd, 8-bit grey levels
  double shot_noise = 0.0;  ///< variance per grey level, 8-bit scale: var = read^2 + shot * I
  std::uint64_t seed = 1;
  /// Throws std::invalid_argument naming the key.
  void validate() const;
};

/// Renders frames of a scene. pose(t) is called over the exposure [t - exposure/2, t + exposure/2] and must
/// be smooth in it.
///
/// A pixel is the mean over its square and over the exposure of
///   (1 - l) [(1 - a(x - c)) P(x - p) + a(x - c) D(x - c, theta)] + l lamp,
/// a, l coverages of disc and lamp, P the platform with its marker, c, p, theta the pose: by closed forms
/// where there is no edge, by Gauss-Legendre points where there is one, to about 1e-4 of the contrast. Then
/// comes what acts on whole pixels: vignetting, the exposure's mean of the flicker, noise, rounding.
class SceneRenderer {
 public:
  /// Throws std::invalid_argument naming the key, see Scene::validate.
  explicit SceneRenderer(const Scene& scene);
  const Scene& scene() const;
  /// `lamp_on_share`: fraction of the exposure during which the lamp was lit. Rounded to whole levels,
  /// clipped, noise drawn from seed and index alone: frames can be rendered in any order, on any thread.
  Picture render(std::int64_t index, double time_s, double exposure_s,
                 const std::function<ScenePose(double)>& pose, double lamp_on_share = 0) const;
  /// Same without noise, rounding and clipping.
  Picture render_exact(double time_s, double exposure_s, const std::function<ScenePose(double)>& pose,
                       double lamp_on_share = 0) const;

 private:
  struct Implementation;
  std::shared_ptr<const Implementation> implementation_;
};

}  // namespace tribotrack::vision
