// The audit of whole tracks, against the truth.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "vision/analytic_scene.h"
#include "vision/track_errors.h"
#include "vision/tracker.h"

namespace tribotrack::vision {
namespace {

using test::RenderedSource;
using test::TestScene;

Point place(std::int64_t k) {
  return {48.3 + 6 * std::cos(0.03 * static_cast<double>(k)),
          46.8 - 6 * std::sin(0.03 * static_cast<double>(k))};
}

/// Noise of 2 grey levels and, alike over blocks of 3 x 3 pixels, of `blocks`, as coding makes it.
RenderedSource recording(double blocks) {
  return {96, 96, 400, [blocks](std::int64_t k) {
            TestScene scene;
            scene.width = scene.height = 96;
            scene.discs = {{place(k).x, place(k).y, 14, 0, 150, {}}};
            std::mt19937 random(static_cast<unsigned>(100 + k));
            Picture picture = scene.render();
            std::normal_distribution<float> level(0, 1);
            if (blocks > 0)
              for (int y = 0; y < 96; y += 3)
                for (int x = 0; x < 96; x += 3) {
                  const float shift = static_cast<float>(blocks) * level(random);
                  for (int j = 0; j < 9; ++j) picture.at(x + j % 3, y + j / 3) += shift;
                }
            return test::noisy(picture, 2, random);
          }};
}

struct Tracked {
  Audit audit;
  double standardised = 0;  ///< rms of the errors over their standard deviations
  std::size_t warnings = 0;
};

Tracked tracked(double blocks) {
  RenderedSource source = recording(blocks);
  TrackOptions options;
  options.target.kind = Target::Kind::disc;
  options.target.disc = {place(0).x, place(0).y, 14};
  options.layers = Layers::off;
  const TrackResult result = track(source, options);
  const test::TrackErrors e = test::errors_of(result.track, place);
  EXPECT_EQ(e.count, 400);
  return {result.summary.audit, e.standardised, result.summary.warnings.size()};
}

/// Of both splits together.
double halves(const Audit& audit) {
  return std::hypot(audit.halves_x.value(), audit.halves_y.value()) / std::sqrt(2.0);
}

TEST(AuditOfATrack, CorrelatedNoiseIsSeenAndCounted) {
  const Tracked found = tracked(4);
  // Gain and offset take part of what is alike all over a half.
  EXPECT_GT(halves(found.audit), 1.15);
  EXPECT_GT(found.audit.high_frequency.value(), 1.3);
  EXPECT_GT(found.standardised, 0.8);
  EXPECT_LT(found.standardised, 1.2);
  EXPECT_GE(found.warnings, 1U);
}

}  // namespace
}  // namespace tribotrack::vision
