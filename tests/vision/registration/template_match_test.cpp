#include "vision/registration/pattern.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "vision/analytic_scene.h"

namespace tribotrack::vision {
namespace {

/// The definition, in double, term by term.
double slow_zncc(const MaskedTemplate& t, const Picture& picture, int x, int y) {
  double w = 0, mt = 0, mi = 0;
  for (int j = 0; j < t.levels.height(); ++j)
    for (int i = 0; i < t.levels.width(); ++i) {
      w += t.weights.at(i, j);
      mt += static_cast<double>(t.weights.at(i, j)) * t.levels.at(i, j);
      mi += static_cast<double>(t.weights.at(i, j)) * picture.at(x + i, y + j);
    }
  mt /= w;
  mi /= w;
  double tt = 0, ii = 0, ti = 0;
  for (int j = 0; j < t.levels.height(); ++j)
    for (int i = 0; i < t.levels.width(); ++i) {
      const double a = t.levels.at(i, j) - mt;
      const double b = picture.at(x + i, y + j) - mi;
      tt += t.weights.at(i, j) * a * a;
      ii += t.weights.at(i, j) * b * b;
      ti += t.weights.at(i, j) * a * b;
    }
  return ii > 0 ? ti / std::sqrt(tt * ii) : 0;
}

MaskedTemplate cut(const Picture& picture, int x, int y, int size, bool round) {
  MaskedTemplate t{Picture(size, size), Picture(size, size)};
  const double middle = 0.5 * (size - 1);
  for (int j = 0; j < size; ++j)
    for (int i = 0; i < size; ++i) {
      t.levels.at(i, j) = picture.at(x + i, y + j);
      t.weights.at(i, j) = !round || std::hypot(i - middle, j - middle) <= middle ? 1.0F : 0.0F;
    }
  return t;
}

Picture random_picture(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  const test::Waves waves = test::random_waves(random, 40, 5, 40);
  std::normal_distribution<double> normal(0, 5);
  Picture picture(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) picture.at(x, y) = static_cast<float>(128 + waves(x, y) + normal(random));
  return picture;
}

TEST(TemplateMatcher, ScoreIsTheDefinition) {
  for (const unsigned seed : {1U, 2U}) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const Picture picture = random_picture(60, 50, seed);
    for (const bool round : {true, false}) {
      const MaskedTemplate t = cut(picture, 20, 15, 17, round);
      const TemplateMatcher matcher(t);
      for (int y = 0; y <= 50 - 17; y += 5)
        for (int x = 0; x <= 60 - 17; x += 3)
          EXPECT_NEAR(matcher.score(picture, x, y), slow_zncc(t, picture, x, y), 2e-6);
      EXPECT_NEAR(matcher.score(picture, 20, 15), 1, 1e-6);
    }
  }
}

TEST(TemplateMatcher, SearchFindsEveryCopyInTheWholePicture) {
  for (const double radius : {9.0, 20.0, 45.0}) {
    SCOPED_TRACE(testing::Message() << "radius " << radius);
    test::TestScene scene;
    scene.width = 400;
    scene.height = 300;
    scene.discs = {{70.3, 81.7, radius}, {301.2, 71.9, radius}, {200.6, 219.4, radius}};
    const Picture picture = scene.render();
    const int size = static_cast<int>(2 * radius) + 7;
    const int x0 = 70 - size / 2;
    const int y0 = 82 - size / 2;
    const TemplateMatcher matcher(cut(picture, x0, y0, size, true));
    const auto found = matcher.search(picture, 0.8, radius, 10);
    ASSERT_EQ(found.size(), 3U);
    EXPECT_EQ(found[0].x, x0);
    EXPECT_EQ(found[0].y, y0);
    for (const auto& disc : scene.discs) {
      const bool seen = std::any_of(found.begin(), found.end(), [&](const Match& m) {
        return std::hypot(m.x - x0 + 70.3 - disc.x, m.y - y0 + 81.7 - disc.y) < 1.0;
      });
      EXPECT_TRUE(seen) << disc.x << ", " << disc.y;
    }
  }
}

}  // namespace
}  // namespace tribotrack::vision
