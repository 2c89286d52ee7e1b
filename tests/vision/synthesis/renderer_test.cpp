// The renderer against brute force: the scene evaluated at 32 x 32 points per pixel and 64 times per
// exposure.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "vision/disc_by_definition.h"
#include "vision/scene.h"
#include "vision/synthesis/disc.h"
#include "vision/synthesis/texture.h"

namespace tribotrack::vision {
namespace {

using Pose = std::function<ScenePose(double)>;

/// The scene at a point and a time, written down once more from the header's formulas.
class BruteForce {
 public:
  explicit BruteForce(const Scene& scene)
      : scene_(scene), disc_(scene.disc, scene.seed), texture_(scene.platform, scene.seed) {}

  double pixel(int x, int y, double time_s, double exposure_s, const Pose& pose, double lamp_on) const {
    const int points = 32;
    const int times = exposure_s > 0 ? 64 : 1;
    double sum = 0;
    for (int k = 0; k < times; ++k) {
      const ScenePose p = pose(time_s + exposure_s * ((k + 0.5) / times - 0.5));
      for (int j = 0; j < points; ++j) {
        for (int i = 0; i < points; ++i) {
          sum += point(x + (i + 0.5) / points - 0.5, y + (j + 0.5) / points - 0.5, p, lamp_on);
        }
      }
    }
    return sum / (points * points * times);
  }

 private:
  double edge(double dx, double dy, double radius) const {
    return discs_.share(std::hypot(dx, dy), radius, scene_.disc.edge_blur_px);
  }
  double point(double x, double y, const ScenePose& pose, double lamp_on) const {
    double level = scene_.platform.level;
    const double alpha =
        scene_.disc.visible ? edge(x - pose.disc.x, y - pose.disc.y, scene_.disc.radius_px) : 0;
    if (alpha < 1 - 1e-7) level += test::texture_at(texture_, x - pose.platform.x, y - pose.platform.y);
    if (scene_.marker) {
      const double dx = x - scene_.marker->position.x - pose.platform.x;
      const double dy = y - scene_.marker->position.y - pose.platform.y;
      const double dot = edge(dx, dy, scene_.marker->radius_px / 2);
      const double ring = edge(dx, dy, scene_.marker->radius_px);
      level =
          (1 - ring) * level + ring * ((1 - dot) * scene_.marker->ring_level + dot * scene_.marker->level);
    }
    if (alpha > 1e-9) {
      level = (1 - alpha) * level + alpha * disc_.colour(x - pose.disc.x, y - pose.disc.y,
                                                         std::cos(pose.theta), std::sin(pose.theta));
    }
    if (scene_.lamp) {
      const double share =
          edge(x - scene_.lamp->position.x, y - scene_.lamp->position.y, scene_.lamp->radius_px);
      const double light =
          scene_.lamp->off_level + lamp_on * (scene_.lamp->on_level - scene_.lamp->off_level);
      level = (1 - share) * level + share * light;
    }
    return level;
  }

  Scene scene_;
  DiscLayer disc_;
  PlatformTexture texture_;
  mutable test::TabulatedDiscs discs_;
};

Scene plain(int width, int height, double radius) {
  Scene scene;
  scene.width = width;
  scene.height = height;
  scene.disc.radius_px = radius;
  scene.disc.level = 170;
  scene.disc.scratches = 0;
  scene.disc.highlight = 0;
  scene.platform.level = 80;
  scene.platform.texture_rms = 0;
  scene.read_noise = 0;
  return scene;
}

Pose at_rest(Point disc, double theta = 0, Point platform = {}) {
  return [=](double) { return ScenePose{disc, theta, platform}; };
}

/// The largest difference from brute force over `count` pixels drawn from those within `reach` of `centre`.
double worst_difference(const Scene& scene, double time_s, double exposure_s, const Pose& pose, Point centre,
                        double inner, double outer, int count, double lamp_on = 0) {
  const SceneRenderer renderer(scene);
  const Picture picture = renderer.render_exact(time_s, exposure_s, pose, lamp_on);
  const BruteForce reference(scene);
  std::mt19937 random(99);
  std::uniform_int_distribution<int> any_x(0, scene.width - 1), any_y(0, scene.height - 1);
  double worst = 0;
  for (int tries = 0; count > 0 && tries < 1000000; ++tries) {
    const int x = any_x(random), y = any_y(random);
    const double rho = std::hypot(x - centre.x, y - centre.y);
    if (rho < inner || rho > outer) continue;
    --count;
    const double expected = reference.pixel(x, y, time_s, exposure_s, pose, lamp_on);
    worst = std::max(worst, std::abs(picture.at(x, y) - expected));
  }
  EXPECT_EQ(count, 0) << "no pixels to compare";
  return worst;
}

constexpr double kContrast = 90;

TEST(SceneRenderer, DiscRimAgreesWithBruteForce) {
  for (const double blur : {0.25, 0.5, 0.8, 1.5}) {
    Scene scene = plain(41, 33, 11.3);
    scene.disc.edge_blur_px = blur;
    // Brute force itself errs by h^2/24 times the curvature, most for the sharpest edge.
    const double own = kContrast * 0.25 / (blur * blur) / (24 * 32 * 32) * 2;
    EXPECT_LT(worst_difference(scene, 0, 0, at_rest({19.37, 15.81}), {19.37, 15.81}, 9, 14, 400),
              1e-4 * kContrast + own)
        << blur;
  }
}

TEST(SceneRenderer, MotionBlurAgreesWithBruteForce) {
  // Disc, rotation, platform and its mark all move, the disc along a curve, by up to three pixels in the
  // exposure.
  Scene scene = plain(61, 45, 13);
  scene.disc.scratches = 12;
  scene.disc.highlight = 25;
  scene.platform.texture_rms = 10;
  scene.marker = MarkerAppearance{{9.4, 35.3}, 8, 20, 220};
  for (const double path : {0.05, 0.7, 3.0}) {
    const Pose pose = [path](double t) {
      const double u = t - 0.5;  // the exposure is [0, 1] s
      return ScenePose{{29.2 + path * u, 20.6 + 0.4 * path * u * u},
                       0.3 + 0.05 * path * u,
                       {-0.6 * path * u, 0.3 * path * u}};
    };
    EXPECT_LT(worst_difference(scene, 0.5, 1, pose, {29.2, 20.6}, 10, 17, 10), 0.005) << path;
    EXPECT_LT(worst_difference(scene, 0.5, 1, pose, {29.2, 20.6}, 0, 9, 10), 0.005) << path;
    EXPECT_LT(worst_difference(scene, 0.5, 1, pose, {9.4, 35.3}, 0, 12, 12), 0.006) << path;
  }
}

TEST(SceneRenderer, DiscHidesMarkerAndLampLiesOnTop) {
  Scene scene = plain(61, 45, 10);
  scene.platform.texture_rms = 8;
  scene.disc.scratches = 12;
  scene.disc.highlight = 25;
  scene.marker = MarkerAppearance{{20.4, 21.3}, 8, 20, 220};
  scene.lamp = Lamp{{37, 22}, 5, 230, 20};
  const Pose pose = at_rest({29.7, 22.4}, 0.2, {0.4, 0.3});
  EXPECT_LT(worst_difference(scene, 0, 0, pose, {29.7, 22.4}, 0, 20, 150, 0.35), 0.005);
}

TEST(SceneRenderer, ScratchesTurnAndTheHighlightStays) {
  // A quarter turn counter-clockwise seen with y up: what was right of the centre comes to lie above it.
  Scene scene = plain(61, 61, 20);
  scene.disc.scratches = 10;
  const SceneRenderer scratched(scene);
  const Picture a = scratched.render_exact(0, 0, at_rest({30, 30}, 0));
  const Picture b = scratched.render_exact(0, 0, at_rest({30, 30}, M_PI / 2));
  double difference = 0;
  for (int y = 0; y < 61; ++y) {
    for (int x = 0; x < 61; ++x) {
      const int right = x - 30, up = 30 - y;
      ASSERT_NEAR(b.at(30 - up, 30 - right), a.at(x, y), 1e-4);
      difference = std::max(difference, std::abs(static_cast<double>(b.at(x, y)) - a.at(x, y)));
    }
  }
  EXPECT_GT(difference, 5);

  scene.disc.scratches = 0;
  scene.disc.highlight = 25;
  const SceneRenderer lit(scene);
  const Picture c = lit.render_exact(0, 0, at_rest({30, 30}, 0));
  const Picture d = lit.render_exact(0, 0, at_rest({30, 30}, 2.1));
  for (std::size_t i = 0; i < c.levels().size(); ++i) ASSERT_EQ(c.levels()[i], d.levels()[i]);
  EXPECT_NEAR(c.at(23, 23), 170 + 25, 0.3);
  EXPECT_LT(c.at(44, 44), 173);
}

TEST(SceneRenderer, DiscPartlyOrFullyOutside) {
  Scene scene = plain(31, 23, 8);
  scene.disc.scratches = 6;
  scene.disc.highlight = 20;
  Scene wide = scene;
  wide.width = 71;
  wide.height = 63;
  const SceneRenderer cut(scene), whole(wide);
  for (const Point c : {Point{0, 0}, {-3.3, 11}, {30.9, 22.2}, {15, -7.6}, {-20, 5}, {38.2, 30.1}}) {
    const Picture a = cut.render_exact(0, 0, at_rest(c, 0.3));
    const Picture b = whole.render_exact(0, 0, at_rest({c.x + 20, c.y + 20}, 0.3));
    for (int y = 0; y < 23; ++y) {
      for (int x = 0; x < 31; ++x) ASSERT_NEAR(a.at(x, y), b.at(x + 20, y + 20), 1e-4);
    }
  }
  const Picture nothing = cut.render_exact(0, 0, at_rest({1e9, -1e9}));
  for (const float level : nothing.levels()) ASSERT_EQ(level, 80.0F);
}

TEST(SceneRenderer, VignettingAndFlicker) {
  Scene scene = plain(41, 31, 5);
  scene.disc.visible = false;
  scene.vignetting = 0.3;
  const Picture dark = SceneRenderer(scene).render_exact(0, 0, at_rest({}));
  EXPECT_FLOAT_EQ(dark.at(20, 15), 80);
  EXPECT_FLOAT_EQ(dark.at(0, 0), 56);
  EXPECT_FLOAT_EQ(dark.at(40, 30), 56);
  EXPECT_NEAR(dark.at(40, 15), 80 * (1 - 0.3 * 400 / 625), 1e-4);

  scene.vignetting = 0;
  scene.flicker = 0.1;
  scene.flicker_hz = 100;
  const SceneRenderer flickering(scene);
  EXPECT_NEAR(flickering.render_exact(2.5e-3, 0, at_rest({})).at(3, 3), 88, 1e-4);
  // Mean of the sine over the exposure, by brute force.
  const double time = 1.1e-3, exposure = 3e-3;
  double mean = 0;
  for (int k = 0; k < 10000; ++k) {
    mean += 1 + 0.1 * std::sin(2 * M_PI * 100 * (time + exposure * ((k + 0.5) / 10000 - 0.5)));
  }
  EXPECT_NEAR(flickering.render_exact(time, exposure, at_rest({})).at(3, 3), 80 * mean / 10000, 1e-4);
  EXPECT_NEAR(flickering.render_exact(0.3, 0.01, at_rest({})).at(3, 3), 80, 1e-4);  // a whole period
}

TEST(SceneRenderer, NoiseHasTheStatedMeanAndVariance) {
  for (const int bits : {8, 12}) {
    for (const auto& [read, shot] : {std::pair{1.5, 0.0}, {0.0, 0.05}, {2.0, 0.03}}) {
      Scene scene = plain(400, 300, 5);
      scene.disc.visible = false;
      scene.bits = bits;
      scene.platform.level = 100.3;
      scene.read_noise = read;
      scene.shot_noise = shot;
      const Picture picture = SceneRenderer(scene).render(3, 0, 0, at_rest({}));
      const double scale = std::ldexp(1.0, bits - 8);
      const double n = 400.0 * 300;
      double sum = 0, squares = 0;
      for (const float level : picture.levels()) {
        ASSERT_EQ(level, std::floor(level));
        const double d = level - 100.3 * scale;
        sum += d;
        squares += d * d;
      }
      // Rounding adds 1/12, whatever the depth.
      const double variance = (read * read + shot * 100.3) * scale * scale + 1.0 / 12;
      EXPECT_NEAR(sum / n, 0, 4 * std::sqrt(variance / n)) << bits << " " << read << " " << shot;
      EXPECT_NEAR(squares / n, variance, 4 * variance * std::sqrt(2 / n))
          << bits << " " << read << " " << shot;
    }
  }
}

TEST(SceneRenderer, FramesDependOnSeedAndIndexAlone) {
  Scene scene = plain(64, 48, 9);
  scene.read_noise = 2;
  const SceneRenderer renderer(scene), again(scene);
  const Pose pose = at_rest({30, 20});
  const auto same = [](const Picture& a, const Picture& b) {
    return std::ranges::equal(a.levels(), b.levels());
  };
  const Picture seventh = renderer.render(7, 0, 0, pose);
  renderer.render(2, 0, 0, pose);
  EXPECT_TRUE(same(seventh, renderer.render(7, 0, 0, pose)));
  EXPECT_TRUE(same(seventh, again.render(7, 0, 0, pose)));
  EXPECT_FALSE(same(seventh, renderer.render(8, 0, 0, pose)));
  EXPECT_FALSE(same(renderer.render(-1, 0, 0, pose), renderer.render(1, 0, 0, pose)));
  scene.seed = 2;
  EXPECT_FALSE(same(seventh, SceneRenderer(scene).render(7, 0, 0, pose)));
}

}  // namespace
}  // namespace tribotrack::vision
