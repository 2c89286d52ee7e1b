#include "vision/tracking/first_pass.h"

#include <gtest/gtest.h>

#include "vision/analytic_scene.h"

namespace tribotrack::vision {
namespace {

TEST(GateLamp, MeanOfThePixelsInTheCircleByHand) {
  test::RenderedSource source(20, 16, 3, [](std::int64_t k) {
    Picture p(20, 16);
    for (int y = 0; y < 16; ++y)
      for (int x = 0; x < 20; ++x) p.at(x, y) = static_cast<float>(10 * k + x + 2 * y);
    p.at(7, 6) = k == 2 ? 255.0F : p.at(7, 6);
    return p;
  });
  GateLamp lamp({7.2, 5.8, 3}, source);
  for (int k = 0; k < 3; ++k) {
    double sum = 0;
    int count = 0;
    const Picture p = source.read(k);
    for (int y = 0; y < 16; ++y)
      for (int x = 0; x < 20; ++x)
        if (std::pow(x - 7.2, 2) + std::pow(y - 5.8, 2) <= 9) {
          sum += p.at(x, y);
          ++count;
        }
    const auto sample = lamp.sample(source, k);
    EXPECT_NEAR(sample.level, sum / count, 1e-9);
    EXPECT_EQ(lamp.pixels(), count);
    EXPECT_NEAR(sample.clipped_share, k == 2 ? 1.0 / count : 0, 1e-12);
  }
}

}  // namespace
}  // namespace tribotrack::vision
