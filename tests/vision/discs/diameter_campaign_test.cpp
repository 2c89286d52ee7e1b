// A hundred renderings each: is the diameter as good as it says? Disc of 30 px, noise of 2 grey levels.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "vision/layered_scenes.h"
#include "vision/tracker.h"

namespace tribotrack::vision {
namespace {

struct DiameterErrors {
  double mean = 0, rms = 0, worst = 0, standardised = 0, sd = 0;
};

/// Errors of the diameter over `count` renderings, each with its own seed, radius and place between pixels.
template <class Change>
DiameterErrors diameters(const char* name, int count, Change change) {
  DiameterErrors out;
  for (int k = 0; k < count; ++k) {
    test::SlidingScene s;
    s.scene.read_noise = 2;
    s.scene.seed = 1000 + static_cast<std::uint64_t>(k);
    s.frames = 120;
    s.path_px = 60;
    s.scene.width = 230;
    s.scene.disc.radius_px = 30 + 0.013 * k - 0.65;
    change(s);
    test::SceneSource source(s);
    TrackOptions options;
    const MarkerAppearance& m = *s.scene.marker;
    options.marker = {MarkerChoice::Kind::circle, {m.position.x + s.circle_px, m.position.y, m.radius_px}};
    const TrackSummary summary = track(source, options).summary;
    const double error = 2 * (summary.disc.radius - s.scene.disc.radius_px);
    const double sd = 2 * summary.disc_radius_sd;
    out.mean += error / count;
    out.rms += error * error / count;
    out.worst = std::max(out.worst, std::abs(error));
    out.standardised += error * error / (sd * sd) / count;
    out.sd += sd / count;
  }
  out.rms = std::sqrt(out.rms);
  out.standardised = std::sqrt(out.standardised);
  std::printf("diameter, %s: mean error %+.4f px, rms %.4f, worst %.4f, sd told %.4f, standardised %.3f\n",
              name, out.mean, out.rms, out.worst, out.sd, out.standardised);
  std::fflush(stdout);
  return out;
}

void expect_honest(const DiameterErrors& e) {
  EXPECT_LT(e.worst, 0.03);
  EXPECT_LT(e.rms, 0.01);
  EXPECT_GT(e.standardised, 0.8);
  EXPECT_LT(e.standardised, 1.2);
}

TEST(DiameterCampaign, DISABLED_OnAPlainPlatform) {
  expect_honest(diameters("plain", 100, [](test::SlidingScene& s) { s.scene.platform.texture_rms = 0; }));
}

TEST(DiameterCampaign, DISABLED_OnABrushedPlatform) {
  expect_honest(diameters("brushed", 100, [](test::SlidingScene& s) { s.scene.platform.texture_rms = 8; }));
}

TEST(DiameterCampaign, DISABLED_OfAScratchedDiscWithAHighlight) {
  expect_honest(diameters("scratched, highlight, plain", 100, [](test::SlidingScene& s) {
    s.scene.platform.texture_rms = 0;
    s.scene.disc.scratches = 12;
    s.scene.disc.highlight = 25;
  }));
}

TEST(DiameterCampaign, DISABLED_OfAScratchedTurningDiscOnABrushedPlatform) {
  expect_honest(diameters("scratched, highlight, turning, brushed", 100, [](test::SlidingScene& s) {
    s.scene.platform.texture_rms = 8;
    s.scene.disc.scratches = 12;
    s.scene.disc.highlight = 25;
    s.spin_rad = 0.2;
  }));
}

}  // namespace
}  // namespace tribotrack::vision
