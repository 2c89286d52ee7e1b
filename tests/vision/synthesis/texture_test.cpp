#include "vision/synthesis/texture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace tribotrack::vision {
namespace {

std::vector<double> whole_numbers(int n) {
  std::vector<double> xs(n);
  std::iota(xs.begin(), xs.end(), 0.0);
  return xs;
}

PlatformAppearance brushed() {
  PlatformAppearance p;
  p.texture_rms = 8;
  p.brush_angle_rad = 0.4;
  p.texture_length_px = 30;
  p.texture_width_px = 2.5;
  return p;
}

TEST(PlatformTexture, HasTheNominalMeanSquare) {
  const PlatformTexture texture(brushed(), 3);
  double squares = 0;
  for (const auto& wave : texture.waves()) squares += wave.amplitude * wave.amplitude / 2;
  EXPECT_NEAR(std::sqrt(squares), 8, 1e-12);
  // And a picture of it, here over many correlation lengths, is that rough about zero.
  double sum = 0, sum2 = 0;
  int n = 0;
  for (double y = 0; y < 3000; y += 7.3) {
    for (double x = 0; x < 3000; x += 7.1, ++n) {
      const double b = texture.at(x, y);
      sum += b;
      sum2 += b * b;
    }
  }
  EXPECT_NEAR(sum / n, 0, 0.2);
  EXPECT_NEAR(std::sqrt(sum2 / n), 8, 0.2);
}

TEST(PlatformTexture, CorrelatesAlongAndAcrossTheBrushAsAsked) {
  // The covariance of a random sum of waves is sum a^2/2 cos(k.d), averaged here over 200 seeds.
  const double c = std::cos(0.4), s = std::sin(0.4);
  const auto covariance = [&](double along, double across) {
    const double dx = along * c + across * s;  // y down: the brush points to (cos, -sin)
    const double dy = -along * s + across * c;
    double sum = 0;
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
      const PlatformTexture texture(brushed(), seed);
      for (const auto& wave : texture.waves()) {
        sum += wave.amplitude * wave.amplitude / 2 * std::cos(wave.kx * dx + wave.ky * dy);
      }
    }
    return sum / 200;
  };
  for (const auto& [along, across] :
       {std::pair{0.0, 2.5}, {0.0, 5.0}, {30.0, 0.0}, {60.0, 0.0}, {30.0, 2.5}}) {
    const double expected = 64 * std::exp(-0.5 * (along * along / 900 + across * across / 6.25));
    EXPECT_NEAR(covariance(along, across), expected, 0.02 * 64) << along << ", " << across;
  }
}

TEST(PlatformTexture, IsFlatWithoutRoughnessAndFollowsTheSeed) {
  PlatformAppearance flat = brushed();
  flat.texture_rms = 0;
  EXPECT_EQ(PlatformTexture(flat, 1).at(3, 4), 0);
  EXPECT_EQ(PlatformTexture(brushed(), 1).at(3, 4), PlatformTexture(brushed(), 1).at(3, 4));
  EXPECT_NE(PlatformTexture(brushed(), 1).at(3, 4), PlatformTexture(brushed(), 2).at(3, 4));
}

TEST(TextureGrid, IsTheDisplacedTextureAtPoints) {
  const PlatformTexture texture(brushed(), 7);
  const std::vector<double> xs{0, 0.3, 17.25}, ys{-0.4, 5};
  const TextureGrid grid(texture, xs, ys, TextureGrid::Value::kAtPoint);
  const WeightedPoint displacement{1.0, {3.21, -1.7}};
  const auto coefficients = grid.coefficients({&displacement, 1});
  Picture picture(3, 2, 100.0F);
  grid.add_to(picture, coefficients);
  Eigen::VectorXf row;
  for (int j = 0; j < 2; ++j) {
    grid.prepare_row(coefficients, j, row);
    for (int i = 0; i < 3; ++i) {
      const double expected = texture.at(xs[i] - 3.21, ys[j] + 1.7);
      EXPECT_NEAR(grid.at(row, i), expected, 2e-5);
      EXPECT_NEAR(picture.at(i, j), 100 + expected, 4e-5);
    }
  }
}

TEST(TextureGrid, AveragesOverPixelAndExposure) {
  const PlatformTexture texture(brushed(), 7);
  const auto xs = whole_numbers(9), ys = whole_numbers(5);
  const TextureGrid grid(texture, xs, ys, TextureGrid::Value::kPixelMean);
  const std::vector<WeightedPoint> path{{0.25, {0, 0}}, {0.5, {0.7, 0.2}}, {0.25, {1.9, -0.4}}};
  Picture picture(9, 5);
  grid.add_to(picture, grid.coefficients(path));
  const int n = 64;
  for (const auto& [x, y] : {std::pair{0, 0}, {8, 4}, {3, 2}}) {
    double mean = 0;
    for (const WeightedPoint& p : path) {
      for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
          mean += p.weight / (n * n) *
                  texture.at(x + (i + 0.5) / n - 0.5 - p.point.x, y + (j + 0.5) / n - 0.5 - p.point.y);
        }
      }
    }
    EXPECT_NEAR(picture.at(x, y), mean, 2e-4);
  }
}

}  // namespace
}  // namespace tribotrack::vision
