#include "vision/following/texture_patch.h"

#include <gtest/gtest.h>

#include <cmath>

#include "vision/analytic_scene.h"

namespace tribotrack::vision {
namespace {

/// A picture flat but for waves both ways in one quarter, and stronger ones under `covered`.
Picture quarter_textured(std::mt19937& random, double noise) {
  Picture p(160, 160);
  std::normal_distribution<double> normal(0, noise);
  for (int y = 0; y < 160; ++y)
    for (int x = 0; x < 160; ++x) {
      double level = 80;
      if (x >= 80 && y < 80) level += 8 * std::cos(0.8 * x) + 8 * std::cos(0.7 * y);
      if (x < 80 && y >= 80) level += 30 * std::cos(0.8 * x) + 30 * std::cos(0.7 * y);
      if (x < 80 && y < 80) level += 30 * std::cos(0.8 * x + 0.7 * y);  // one direction only
      p.at(x, y) = static_cast<float>(level + normal(random));
    }
  return p;
}

TEST(TexturePatch, TakesTheUncoveredWindowThatTellsBothDirections) {
  std::mt19937 random(8);
  TexturePatchSearch search;
  search.noise_variance = 4;
  search.covered = {{40, 120, 57}};  // all of the strongest quarter
  std::string why_not;
  const auto patch = best_texture_patch(quarter_textured(random, 2), search, why_not);
  ASSERT_TRUE(patch) << why_not;
  const double x = patch->window.x + 0.5 * patch->window.width,
               y = patch->window.y + 0.5 * patch->window.height;
  EXPECT_GT(x, 75);
  EXPECT_LT(y, 85);
  for (int v = patch->window.y; v < patch->window.y + patch->window.height; ++v)
    for (int u = patch->window.x; u < patch->window.x + patch->window.width; ++u)
      ASSERT_GT(std::hypot(u - 40, v - 120), 57);
  // The bound of the waves themselves: mean square slope 8^2 k^2 / 2 a pixel.
  const double pixels = patch->window.width * patch->window.height;
  EXPECT_NEAR(patch->limit_px, 2 / std::sqrt(pixels * 0.5 * 64 * 0.49), 0.4 * patch->limit_px);
}

TEST(TexturePatch, SaysWhyThereIsNone) {
  std::mt19937 random(9);
  Picture flat(160, 160);
  for (float& level : flat.levels()) level = 80;
  TexturePatchSearch search;
  search.noise_variance = 4;
  std::string why_not;
  EXPECT_FALSE(best_texture_patch(test::noisy(flat, 2, random), search, why_not));
  EXPECT_NE(why_not.find("texture"), std::string::npos) << why_not;
  search.covered = {{80, 80, 200}};
  EXPECT_FALSE(best_texture_patch(flat, search, why_not));
  EXPECT_NE(why_not.find("uncovered"), std::string::npos) << why_not;
}

}  // namespace
}  // namespace tribotrack::vision
