// The shift of a picture that is known exactly: a sum of waves, moved.
#include "vision/platform_motion/coarse_shift.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace tribotrack::vision {
namespace {

/// Waves of 12 to 40 px in all directions.
class Waves {
 public:
  explicit Waves(double coarser) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> length(12, 40), turn(0, 2 * std::numbers::pi);
    for (int k = 0; k < 40; ++k) {
      const double number = 2 * std::numbers::pi / (coarser * length(random)), direction = turn(random);
      waves_.push_back({number * std::cos(direction), number * std::sin(direction), turn(random)});
    }
  }
  Picture moved_by(const Point& shift, int width, int height) const {
    Picture out(width, height);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        double level = 100;
        for (const Wave& w : waves_)
          level += 3 * std::cos(w.x * (x - shift.x) + w.y * (y - shift.y) + w.phase);
        out.row(y)[static_cast<std::size_t>(x)] = static_cast<float>(level);
      }
    return out;
  }

 private:
  struct Wave {
    double x, y, phase;
  };
  std::vector<Wave> waves_;
};

TEST(CoarseShift, FindsFractionsOfAPixelBetweenTheBins) {
  const Waves waves(1);
  const CoarseShift shift(waves.moved_by({0, 0}, 200, 160), {}, 1e-3);
  ASSERT_EQ(shift.bin(), 1);
  for (const Point& truth : {Point{3.35, -2.35}, Point{-4.35, 5.65}, Point{0.35, 0}, Point{0, -0.35}}) {
    const Point found = shift.of(waves.moved_by(truth, 200, 160), {});
    EXPECT_NEAR(found.x, truth.x, 0.15);
    EXPECT_NEAR(found.y, truth.y, 0.15);
  }
}

TEST(CoarseShift, OfALargePictureIsInItsOwnPixels) {
  const Waves waves(3);
  const CoarseShift shift(waves.moved_by({0, 0}, 700, 400), {}, 1e-3);
  ASSERT_EQ(shift.bin(), 2);
  const Point found = shift.of(waves.moved_by({10.7, -6.7}, 700, 400), {});
  EXPECT_NEAR(found.x, 10.7, 0.3);
  EXPECT_NEAR(found.y, -6.7, 0.3);
}

}  // namespace
}  // namespace tribotrack::vision
