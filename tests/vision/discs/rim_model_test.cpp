// The rim's fast sums against slow ones, and a disc followed from frame to frame against one searched anew.
#include "vision/discs/rim_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "vision/discs/disc_detection.h"
#include "vision/synthesis/camera.h"

namespace tribotrack::vision {
namespace {

double cdf(double t) {
  return 0.5 * std::erfc(-t / std::numbers::sqrt2);
}

/// The model as its definition says it.
double slow_model(const RimParameters& p, double x, double y) {
  const double u = (x - p(0)) / p(2), v = (y - p(1)) / p(2), rho = std::hypot(x - p(0), y - p(1));
  const double inside = cdf((p(2) - p(3) * p(3) / (2 * p(2)) - rho) / p(3));
  const double in = p(4) + p(5) * u + p(6) * v + p(7) * u * u + p(8) * u * v + p(9) * v * v;
  const double out = p(10) + p(11) * u + p(12) * v + p(13) * (u * u + v * v);
  return out + (in - out) * inside;
}

RimParameters some_rim() {
  RimParameters p;
  p << 30.3, 29.8, 20.4, 0.85, 170, 3, -5, 4, 2, -6, 80, 2, 1, -3;
  return p;
}

Picture rim_picture(const RimParameters& p, double noise, std::uint64_t frame) {
  const CounterRandom random(4711, frame);
  Picture out(62, 60);
  std::uint64_t k = 0;
  for (int y = 0; y < out.height(); ++y)
    for (int x = 0; x < out.width(); ++x)
      out.at(x, y) = static_cast<float>(slow_model(p, x, y) + noise * random.gaussian(k++));
  return out;
}

TEST(RimModel, NormalDistributionFromTheTableIsThatOfTheLibrary) {
  for (double t = -9.5; t < 9.5; t += 0.00137) {
    EXPECT_NEAR(normal_step(t).value, cdf(t), 1e-10) << t;
    EXPECT_NEAR(normal_step(t).density, std::exp(-0.5 * t * t) / std::sqrt(2 * std::numbers::pi), 1e-9) << t;
  }
}

TEST(RimModel, SlopesAreThoseOfTheModel) {
  const RimParameters p = some_rim();
  for (int k = 0; k < 40; ++k) {
    const double angle = 0.7 * k, rho = 17 + 0.18 * k;
    const double x = p(0) + rho * std::cos(angle), y = p(1) + rho * std::sin(angle);
    RimParameters slope;
    EXPECT_NEAR(rim_model(p, x, y, slope), slow_model(p, x, y), 1e-7);
    for (int i = 0; i < kRimParameters; ++i) {
      // A centre or radius that moves also moves what u and v are measured by, which the slopes leave out.
      if (i < 3) continue;
      constexpr double h = 1e-4;
      RimParameters up = p, down = p;
      up(i) += h;
      down(i) -= h;
      const double expected = (slow_model(up, x, y) - slow_model(down, x, y)) / (2 * h);
      EXPECT_NEAR(slope(i), expected, 1e-5 * (1 + std::abs(expected))) << i;
    }
  }
}

// In even light, where u and v do not matter, the slopes by centre and radius are the whole ones.
TEST(RimModel, SlopesByCentreAndRadiusAreThoseOfTheModelInEvenLight) {
  RimParameters p = some_rim();
  p.segment(5, 5).setZero();
  p.tail(3).setZero();
  for (int k = 0; k < 40; ++k) {
    const double angle = 0.7 * k, rho = 18.5 + 0.1 * k;
    const double x = p(0) + rho * std::cos(angle), y = p(1) + rho * std::sin(angle);
    RimParameters slope;
    rim_model(p, x, y, slope);
    for (int i = 0; i < 3; ++i) {
      constexpr double h = 1e-4;
      RimParameters up = p, down = p;
      up(i) += h;
      down(i) -= h;
      const double expected = (slow_model(up, x, y) - slow_model(down, x, y)) / (2 * h);
      EXPECT_NEAR(slope(i), expected, 1e-5 * (1 + std::abs(expected))) << i;
    }
  }
}

TEST(RimModel, SumsAreThoseOverThePixels) {
  const RimParameters p = some_rim();
  const Picture picture = rim_picture(p, 2, 0);
  RimPixels pixels = rim_pixels(picture, {p(0), p(1), p(2)}, 5);
  for (std::size_t i = 0; i < pixels.weight.size(); ++i)
    pixels.weight[i] = i % 5 == 0 ? 0.0 : 0.1 * static_cast<double>(i % 7);
  RimCovariance normal = RimCovariance::Zero();
  RimParameters gradient = RimParameters::Zero(), slope;
  double cost = 0;
  const std::vector<double> residuals = rim_residuals(p, pixels);
  for (std::size_t i = 0; i < pixels.x.size(); ++i) {
    const double r = pixels.level[i] - rim_model(p, pixels.x[i], pixels.y[i], slope);
    EXPECT_NEAR(residuals[i], r, 1e-9);
    normal += pixels.weight[i] * slope * slope.transpose();
    gradient += pixels.weight[i] * r * slope;
    cost += pixels.weight[i] * r * r;
  }
  const RimSums sums = rim_sums(p, pixels);
  EXPECT_LT((sums.normal - normal).norm(), 1e-11 * normal.norm());
  EXPECT_LT((sums.gradient - gradient).norm(), 1e-11 * normal.norm());
  EXPECT_NEAR(sums.cost, cost, 1e-11 * cost);
}

TEST(RefitDisc, FindsWhatASearchFinds) {
  RimParameters p = some_rim();
  const auto before = fit_disc(rim_picture(p, 2, 1), {p(0), p(1), p(2)}, 1);
  ASSERT_TRUE(before);
  for (std::uint64_t frame = 2; frame < 12; ++frame) {
    // It moves, and the lamp flickers.
    p(0) += 0.37;
    p(1) -= 0.21;
    p(4) = 150 + 3.0 * static_cast<double>(frame);
    const Picture picture = rim_picture(p, 2, frame);
    const auto searched = fit_disc(picture, {p(0), p(1), p(2)}, 1);
    const auto followed = refit_disc(picture, *before, {p(0) + 0.02, p(1) - 0.03}, 1);
    ASSERT_TRUE(searched && followed);
    EXPECT_NEAR(followed->circle.radius, searched->circle.radius, 0.2 * searched->radius_sd);
    EXPECT_NEAR(followed->circle.x, searched->circle.x, 0.2 * searched->centre_sd);
    EXPECT_NEAR(followed->circle.y, searched->circle.y, 0.2 * searched->centre_sd);
    EXPECT_NEAR(followed->radius_sd / searched->radius_sd, 1, 0.1);
  }
}

}  // namespace
}  // namespace tribotrack::vision
