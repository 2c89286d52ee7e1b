#include "vision/layers/learning.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include "vision/layers/part_by_hand.h"

namespace tribotrack::vision {
namespace {

using test::PartByHand;
using test::state_of;

constexpr double kNoise = 1.5;
constexpr int kBeyond = 6;

/// Of the light at a place of the picture: more to the right.
double light_at(const Point& place) {
  return 1 + 4e-4 * (place.x - 90);
}

/// Px rms of the windows' centres without the mean, after learning from starts that are off by some noise.
double error_of(const PartByHand& part, int count, bool even_light, double* sigma) {
  std::mt19937 random(5);
  std::normal_distribution<double> off(0, 0.01);
  std::vector<KeptWindow> windows;
  std::vector<Point> truth;
  for (int k = 0; k < count; ++k) {
    LayeredState s = state_of(k);
    s.gain = s.ground_gain = light_at(s.centre);
    windows.push_back(part.window(s, part.half + kBeyond, kNoise, random));
    truth.push_back(s.centre);
    windows.back().state.centre.x += off(random);
    windows.back().state.centre.y += off(random);
    windows.back().state.gain = windows.back().state.ground_gain = 1;
  }
  GroundPicture ground = part.ground(kNoise * kNoise, 40);
  LayeredRegistration registration(ground);
  LearningOptions options;
  options.radius = part.radius;
  options.blur = part.blur;
  options.noise_variance = kNoise * kNoise;
  options.hidden = part.radius + 6 * part.blur;
  options.even_light = even_light;
  const LearntPart learnt = learn_part(windows, ground, registration, options);
  EXPECT_EQ(learnt.explained, windows.size());
  *sigma = learnt.sigma;
  Point mean;
  double square = 0;
  for (std::size_t k = 0; k < windows.size(); ++k) {
    const Point e{windows[k].state.centre.x - truth[k].x, windows[k].state.centre.y - truth[k].y};
    square += e.x * e.x + e.y * e.y;
    mean.x += e.x;
    mean.y += e.y;
  }
  return std::sqrt((square - (mean.x * mean.x + mean.y * mean.y) / count) / (2 * count));
}

// Where the ground shows no texture, alpha and the light cannot be told apart window by window: nothing may
// run away, whatever the number of windows.
TEST(Learning, SettlesOnEvenGroundFromAnyNumberOfWindows) {
  for (const double texture : {0.0, 0.3})
    for (const int count : {24, 48, 96, 100, 128}) {
      const PartByHand part(texture);
      double sigma = 0;
      const double error = error_of(part, count, true, &sigma);
      std::printf("texture %.1f, %3d windows: %.5f px, sigma %.5f px\n", texture, count, error, sigma);
      EXPECT_LT(error, 1.25 * sigma) << texture << " " << count;
    }
}

TEST(Learning, SettlesOverTexture) {
  for (const int count : {48, 100}) {
    const PartByHand part(8);
    double sigma = 0;
    const double error = error_of(part, count, false, &sigma);
    std::printf("%3d windows: %.5f px, sigma %.5f px\n", count, error, sigma);
    EXPECT_LT(error, 1.25 * sigma) << count;
  }
}

}  // namespace
}  // namespace tribotrack::vision
