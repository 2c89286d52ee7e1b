// What a chamfer hides of a disc's outer edge: closed forms where it does not show, a drawn ring where it
// does.
#include "vision/edge/radius.h"

#include <gtest/gtest.h>

#include <cmath>

#include "vision/analytic_scene.h"

namespace tribotrack::vision {
namespace {

constexpr double kTop = 56, kGround = 60, kNoise = 2;

/// A bright top with a ring about it whose level goes from dark to half as bright, as under one lamp.
test::RenderedSource chamfered(double width, std::int64_t frames) {
  return {
      160, 160, frames, [width](std::int64_t k) {
        test::TestScene scene;
        scene.width = scene.height = 160;
        scene.ground = kGround;
        scene.discs = {{80, 80, kTop + width, 0, 75, {{{25, 0.03, 0.02, 0.4}}}}, {80, 80, kTop, 0, 150, {}}};
        std::mt19937 noise(static_cast<unsigned>(40 + k));
        return test::noisy(scene.render(), kNoise, noise);
      }};
}

OuterEdge edge_of(double width, double seen, const std::optional<double>& known = std::nullopt,
                  Point centre = {80, 80}) {
  test::RenderedSource source = chamfered(width, 4);
  SeenFrames frames;
  for (std::int64_t k = 0; k < 4; ++k) frames.push_back({k, centre, {}});
  return outer_edge(source, frames, seen, 0.8, kNoise * kNoise, known);
}

TEST(OuterEdge, IsSeenBehindAWideChamferWhateverEdgeAFitTook) {
  for (const double seen : {kTop + 0.4, kTop + 2}) {
    const OuterEdge edge = edge_of(3.6, seen);
    ASSERT_TRUE(edge.measured) << seen;
    EXPECT_NEAR(seen + edge.beyond, kTop + 3.6, 2 * edge.beyond_sd) << seen;
    EXPECT_NEAR(edge.widest, 3.6, 0.6) << seen;
    EXPECT_LT(edge.beyond_sd, 0.01 * kTop);
  }
}

// The edge that is seen may be the top's on one side and the outer one on the other; and a width from the
// drawing does not beat what shows.
TEST(OuterEdge, IsSeenAboutAnotherCentreAndBehindAChamferThatIsKnown) {
  for (const std::optional<double> known :
       {std::optional<double>(), std::optional(0.06), std::optional(0.07)}) {
    const OuterEdge edge = edge_of(3.6, kTop + 0.4, known, {81.2, 79.2});
    ASSERT_TRUE(edge.measured);
    EXPECT_NEAR(kTop + 0.4 + edge.beyond, kTop + 3.6, edge.beyond_sd) << known.value_or(0);
    EXPECT_NEAR(edge.widest, 3.6, 0.6) << known.value_or(0);
  }
}

TEST(OuterEdge, MayLieAnywhereBehindAChamferThatDoesNotShow) {
  for (const double width : {0.0, 2.0}) {
    const OuterEdge edge = edge_of(width, kTop);
    EXPECT_FALSE(edge.measured) << width;
    EXPECT_DOUBLE_EQ(edge.widest, 3);
    EXPECT_NEAR(edge.beyond, width, 2 * edge.beyond_sd) << width;
  }
}

TEST(OuterEdge, OfASmallDiscOrAKnownChamferTakesNoPicture) {
  test::RenderedSource source = chamfered(0, 0);
  const OuterEdge unknown =
      outer_edge(source, {}, 30, 0.8, 1, std::nullopt);  // 7 % of 30 px, falling linearly
  EXPECT_NEAR(unknown.beyond, 2.1 / 3, 1e-12);
  EXPECT_NEAR(unknown.beyond_sd, 2.1 / std::sqrt(18.0), 1e-12);
  const OuterEdge known = outer_edge(source, {}, 150, 0.8, 1, 1.2 / 150);
  EXPECT_NEAR(known.beyond, 0.6, 1e-12);
  EXPECT_NEAR(known.beyond_sd, 1.2 / std::sqrt(8.0), 1e-12);
  const OuterEdge sharp = outer_edge(source, {}, 150, 0.8, 1, 0);
  EXPECT_EQ(sharp.beyond, 0);
  EXPECT_EQ(sharp.beyond_sd, 0);
}

}  // namespace
}  // namespace tribotrack::vision
