#include "vision/synthesis/disc.h"

#include <gtest/gtest.h>

#include <cmath>

#include "vision/disc_by_definition.h"
#include "vision/synthesis/texture.h"

namespace tribotrack::vision {
namespace {

TEST(BlurredCircle, IsASharpDiscConvolvedWithAGaussian) {
  for (const double blur : {0.1, 0.8, 3.0})
    for (const double radius : {2.5, 8.0, 30.0, 150.0}) {
      const BlurredCircle circle{radius, blur};
      for (double x = -4.4; x < 4.4; x += 0.13) {
        const double rho = radius + x * blur;
        if (rho < 0) continue;
        EXPECT_NEAR(circle.coverage(0.6 * rho, -0.8 * rho), test::share_on_disc(rho, radius, blur), 5e-6)
            << radius << " " << blur << " " << x;
      }
    }
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

}  // namespace
}  // namespace tribotrack::vision
