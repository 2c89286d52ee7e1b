#include "vision/discs/disc_detection.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "vision/analytic_scene.h"

namespace tribotrack::vision {
namespace {

using test::TestScene;

TestScene scene_with(double x, double y, double radius, double level, int size) {
  TestScene scene;
  scene.width = scene.height = size;
  scene.ground = 80;
  scene.discs = {{x, y, radius, 0, level, {}}};
  return scene;
}

TEST(DiscFit, CleanPictureGivesCentreAndRadius) {
  for (const double radius : {8.0, 12.3, 30.7, 90.2}) {
    for (const double level : {170.0, 20.0}) {
      const int size = static_cast<int>(2 * radius) + 41;
      const double x = size / 2.0 + 0.31;
      const double y = size / 2.0 - 0.43;
      const auto fit = fit_disc(scene_with(x, y, radius, level, size).render(), {x, y, radius}, 3);
      ASSERT_TRUE(fit) << radius;
      EXPECT_NEAR(fit->circle.x, x, 0.005) << radius;
      EXPECT_NEAR(fit->circle.y, y, 0.005) << radius;
      EXPECT_NEAR(fit->circle.radius, radius, 0.01) << radius;
      EXPECT_NEAR(fit->blur, std::sqrt(0.49 + 1.0 / 12), 0.03);
      EXPECT_GT(fit->contrast * (level - 80), 0);
      EXPECT_GT(fit->coverage, 0.98);
    }
  }
}

TEST(DiscFit, ClickTwoPixelsOffIsMadeExact) {
  const Picture picture = scene_with(60.3, 58.8, 30.4, 170, 120).render();
  for (int k = 0; k < 27; ++k) {
    const Circle click{60.3 + 2 * (k % 3 - 1), 58.8 + 2 * (k / 3 % 3 - 1), 30.4 + 2 * (k / 9 - 1)};
    const auto fit = fit_disc(picture, click, 3);
    ASSERT_TRUE(fit) << k;
    EXPECT_NEAR(fit->circle.x, 60.3, 0.01) << k;
    EXPECT_NEAR(fit->circle.y, 58.8, 0.01) << k;
    EXPECT_NEAR(fit->circle.radius, 30.4, 0.01) << k;
  }
}

TEST(DiscFit, RadiusSdIsRight) {
  std::mt19937 random(77);
  double standardised = 0;
  constexpr int n = 150;
  for (int k = 0; k < n; ++k) {
    const double radius = 14 + 0.01 * k;
    const Picture picture = test::noisy(scene_with(30.2, 29.7, radius, 150, 60).render(), 3, random);
    const auto fit = fit_disc(picture, {30, 30, 15}, 3);
    ASSERT_TRUE(fit);
    const double z = (fit->circle.radius - radius) / fit->radius_sd;
    standardised += z * z / n;
  }
  // The scatter of an rms over 150 draws is 6 %.
  EXPECT_NEAR(std::sqrt(standardised), 1, 0.18);
}

TEST(DiscFit, DefocusIsMeasuredNotMistakenForRadius) {
  TestScene scene = scene_with(50.2, 50.9, 30, 170, 101);
  scene.blur = 3;
  const auto fit = fit_disc(scene.render(), {50, 51, 30}, 3);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->circle.radius, 30, 0.03);
  EXPECT_NEAR(fit->blur, std::sqrt(9 + 1.0 / 12), 0.05);
}

// A wide chamfer about the top, parted from it by a dark line, a shadow beside it: the fit stays at one of
// the edges, and as sharp as that is.
TEST(DiscFit, StaysAtTheEdgeOfAChamfer) {
  constexpr double kOuter = 150;
  std::mt19937 random(6);
  for (const double line : {42.0, 60.0})
    for (const double lamp : {20.0, 30.0}) {
      TestScene scene = scene_with(160, 178, 156, 15, 340);  // the shadow
      scene.ground = 57;
      scene.discs.push_back({170.3, 169.6, kOuter, 0, 80, {{{lamp, 0.008, -0.008, -std::numbers::pi / 2}}}});
      scene.discs.push_back({170.3, 169.6, 145, 0, line, {}});
      scene.discs.push_back({168.8, 170.7, 143.4, 0, 137, {}});
      const Picture picture = test::noisy(scene.render(), 3, random);
      for (const double capture : {4.5, 18.0}) {
        const auto fit = fit_disc(picture, {170, 170, kOuter}, capture);
        ASSERT_TRUE(fit);
        EXPECT_NEAR(fit->circle.radius, kOuter, 0.15) << line << ", " << lamp;
        EXPECT_NEAR(fit->circle.x, 170.3, 0.15) << line << ", " << lamp;
        EXPECT_LT(fit->blur, 1) << line << ", " << lamp;
      }
    }
}

TEST(DiscFit, NoRimNoCircle) {
  std::mt19937 random(8);
  TestScene scene;
  scene.discs.clear();
  EXPECT_FALSE(fit_disc(test::noisy(scene.render(), 2, random), {48, 48, 20}, 3));
}

TEST(FindDiscs, MarkerIsFoundApartFromTheDisc) {
  std::mt19937 random(100);
  TestScene scene = scene_with(190, 130, 40, 170, 320);
  scene.discs.push_back({60.4, 70.8, 13, 0, 220, {}});  // bright ring
  scene.discs.push_back({60.4, 70.8, 9, 0, 20, {}});    // dark dot in it
  scene.ground_texture = test::random_waves(random, 15, 6, 8);
  const Picture picture = test::noisy(scene.render(), 2, random);
  const auto disc = find_discs(picture, {}, 1);
  ASSERT_EQ(disc.size(), 1U);
  EXPECT_NEAR(disc[0].circle.radius, 40, 0.3);
  DiscSearch search;
  search.min_radius = 3;
  search.keep_out = disc[0].circle;
  const auto marker = find_discs(picture, search, 1);
  ASSERT_EQ(marker.size(), 1U);
  EXPECT_NEAR(marker[0].circle.x, 60.4, 0.2);
  EXPECT_NEAR(marker[0].circle.y, 70.8, 0.2);
}

/// Nothing that is as large is missed, and the first is the same.
TEST(FindDiscs, SearchesForLessFindTheSame) {
  std::mt19937 random(5);
  for (const double radius : {9.0, 22.0, 47.0, 75.0}) {
    TestScene scene = scene_with(130.4, 121.7, radius, 170, 400);
    scene.height = 300;
    scene.discs.push_back({300.2, 190.6, 0.85 * radius, 0, 150, {}});
    scene.discs.push_back({40.3, 250.8, 8, 0, 20, {}});
    const Picture picture = test::noisy(scene.render(), 2, random);
    DiscSearch large;
    large.beside_best = 0.75;
    const auto all = find_discs(picture, {}, 30), some = find_discs(picture, large, 30);
    ASSERT_GE(all.size(), 2U) << radius;
    ASSERT_GE(some.size(), 2U) << radius;
    for (std::size_t k = 0; k < 2; ++k) {
      EXPECT_NEAR(some[k].circle.x, all[k].circle.x, 1e-3) << radius;
      EXPECT_NEAR(some[k].circle.radius, all[k].circle.radius, 1e-3) << radius;
    }
  }
}

TEST(FindDiscs, NothingRoundNothingFound) {
  std::mt19937 random(101);
  TestScene scene;
  scene.width = scene.height = 200;
  scene.ground_texture = test::random_waves(random, 30, 10, 15);
  EXPECT_TRUE(find_discs(test::noisy(scene.render(), 2, random), {}, 3).empty());
}

}  // namespace
}  // namespace tribotrack::vision
