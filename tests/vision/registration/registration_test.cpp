#include "vision/registration/registration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "vision/analytic_scene.h"

namespace tribotrack::vision {
namespace {

using test::TestScene;

constexpr double kRadius = 12, kContrast = 90, kBlur = 0.7;

TestScene plain_scene(double x, double y) {
  TestScene scene;
  scene.width = scene.height = 48;
  scene.blur = kBlur;
  scene.discs = {{x, y, kRadius, 0, scene.ground + kContrast, {}}};
  return scene;
}

/// Cramer-Rao bound of one coordinate, from derivatives of the exact picture by central differences.
double exact_bound(double variance) {
  constexpr double h = 0.01;
  const Picture a = plain_scene(24 + h, 24).render();
  const Picture b = plain_scene(24 - h, 24).render();
  double information = 0;
  for (std::size_t k = 0; k < a.levels().size(); ++k) {
    const double slope = (a.levels()[k] - b.levels()[k]) / (2 * h);
    information += slope * slope;
  }
  return std::sqrt(variance / information);
}

TemplateRegistration registration_of(const Picture& first, double variance, bool rotation = false,
                                     double margin = 3, Circle disc = {24, 24, kRadius}) {
  RegistrationOptions options;
  options.noise_variance = variance;
  options.rotation = rotation;
  return TemplateRegistration(first, disc_pattern(first, disc, margin), options);
}

TEST(Registration, BoundIsThatOfTheExactPicture) {
  const auto registration = registration_of(plain_scene(24, 24).render(), 1.0);
  EXPECT_NEAR(std::sqrt(registration.limit()(0, 0)) / exact_bound(1.0), 1, 0.01);
  // and of the closed form for a thin blurred rim, sigma/A sqrt(1.128 s/R) with s^2 plus the pixel's 1/12.
  const double s = std::sqrt(kBlur * kBlur + 1.0 / 12);
  EXPECT_NEAR(exact_bound(1.0) / (std::sqrt(1.128 * s / kRadius) / kContrast), 1, 0.03);
}

TEST(Registration, WithoutNoiseHardlyAnyPeakLocking) {
  auto registration = registration_of(plain_scene(24, 24).render(), 1.0 / 12);
  double squares = 0, sine = 0, cosine = 0;
  int n = 0;
  for (double d = -0.5; d < 0.499; d += 0.05) {
    const Registration r = registration.refine(plain_scene(24 + d, 24 - 0.6 * d).render(), 0, 0, {});
    ASSERT_TRUE(r.converged);
    const double error = r.pose.dx - d;
    squares += error * error;
    sine += 2 * error * std::sin(2 * std::numbers::pi * d);
    cosine += 2 * error * std::cos(2 * std::numbers::pi * d);
    ++n;
  }
  EXPECT_LT(std::sqrt(squares / n), 4e-4);
  EXPECT_LT(std::hypot(sine, cosine) / n, 5e-4);
}

struct Scatter {
  double rms = 0, standardised = 0, locking = 0;
  int n = 0;
};

/// Registers `n` pictures with random displacements against one noisy template; the mean offset, which one
/// template's noise makes constant, is removed.
Scatter scatter(double sigma, int n, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-1, 1);
  const double variance = sigma * sigma + 1.0 / 12;
  std::vector<double> errors, sigmas, fractions;
  constexpr int kTemplates = 4;
  for (int t = 0; t < kTemplates; ++t) {
    auto registration = registration_of(test::noisy(plain_scene(24, 24).render(), sigma, random), variance);
    std::vector<double> ex, ey;
    for (int k = 0; k < n / kTemplates; ++k) {
      const double dx = place(random);
      const double dy = place(random);
      const Picture picture = test::noisy(plain_scene(24 + dx, 24 + dy).render(), sigma, random);
      const Registration r = registration.refine(picture, 0, 0, {});
      EXPECT_TRUE(r.converged);
      ex.push_back(r.pose.dx - dx);
      ey.push_back(r.pose.dy - dy);
      sigmas.push_back(std::sqrt(r.covariance(0, 0)));
      sigmas.push_back(std::sqrt(r.covariance(1, 1)));
      fractions.push_back(dx);
      fractions.push_back(dy);
    }
    double mx = 0, my = 0;
    for (std::size_t k = 0; k < ex.size(); ++k) {
      mx += ex[k] / static_cast<double>(ex.size());
      my += ey[k] / static_cast<double>(ex.size());
    }
    for (std::size_t k = 0; k < ex.size(); ++k) {
      errors.push_back(ex[k] - mx);
      errors.push_back(ey[k] - my);
    }
  }
  Scatter out;
  double c = 0, s = 0;
  for (std::size_t k = 0; k < errors.size(); ++k) {
    out.rms += errors[k] * errors[k];
    out.standardised += errors[k] * errors[k] / (sigmas[k] * sigmas[k]);
    c += 2 * errors[k] * std::cos(2 * std::numbers::pi * fractions[k]);
    s += 2 * errors[k] * std::sin(2 * std::numbers::pi * fractions[k]);
  }
  out.n = static_cast<int>(errors.size());
  out.rms = std::sqrt(out.rms / out.n);
  out.standardised = std::sqrt(out.standardised / out.n);
  out.locking = std::hypot(c, s) / out.n;
  return out;
}

class RegistrationNoise : public testing::TestWithParam<double> {};

TEST_P(RegistrationNoise, ErrorIsAtTheBoundAndSigmaSaysSo) {
  const double sigma = GetParam();
  const Scatter found = scatter(sigma, 1600, 4711);
  const double bound = exact_bound(sigma * sigma + 1.0 / 12);
  EXPECT_LT(found.rms, 1.1 * bound);
  EXPECT_GT(found.rms, 0.95 * bound);
  EXPECT_GT(found.standardised, 0.95);
  EXPECT_LT(found.standardised, 1.05);
  // Peak locking: a sine of the fraction, above what noise alone would show (rms sqrt(2/n) of the scatter).
  EXPECT_LT(found.locking, 5e-4 + 2.5 * found.rms * std::sqrt(2.0 / found.n));
}

INSTANTIATE_TEST_SUITE_P(Levels, RegistrationNoise, testing::Values(1.0, 3.0));

TEST(Registration, RotationIsFoundWithItsSense) {
  std::mt19937 random(5);
  TestScene scene = plain_scene(24, 24);
  scene.discs[0].texture = test::random_waves(random, 12, 7, 18);
  auto registration = registration_of(scene.render(), 1.0 / 12, true);
  // Counter-clockwise as seen: the analytic scene turns the same way (y up).
  for (const double theta : {0.05, -0.2, 0.3}) {
    scene.discs[0].theta = theta;
    scene.discs[0].x = 24.37;
    scene.discs[0].y = 24.81;
    const Registration r = registration.refine(scene.render(), 0, 0, {});
    ASSERT_TRUE(r.converged);
    EXPECT_NEAR(r.pose.theta, theta, 2e-3);
    EXPECT_NEAR(r.pose.dx, 0.37, 4e-3);
    EXPECT_NEAR(r.pose.dy, 0.81, 4e-3);
  }
  const Picture turned = registration.at({0, 0, std::numbers::pi / 2}, registration.pattern().window);
  // A quarter turn counter-clockwise takes the right-hand side to the top.
  const Picture straight = registration.at({}, registration.pattern().window);
  const int middle = (turned.width() - 1) / 2;
  for (int k = -8; k <= 8; ++k)
    EXPECT_NEAR(turned.at(middle + 2, middle - k), straight.at(middle + k, middle + 2), 1e-2);
}

TEST(Registration, ThingsThatAreNotTheDiscAreTrimmed) {
  auto registration = registration_of(plain_scene(24, 24).render(), 1.0);
  Picture glare = plain_scene(24.4, 24.2).render();
  for (int y = 18; y < 23; ++y)
    for (int x = 28; x < 36; ++x) glare.at(x, y) = 255;  // across the rim
  const Registration r = registration.refine(glare, 0, 0, {});
  ASSERT_TRUE(r.converged);
  EXPECT_NEAR(r.pose.dx, 0.4, 0.02);
  EXPECT_NEAR(r.pose.dy, 0.2, 0.02);
}

TEST(Registration, ANeighbourInTheRimIsLeftOutOfTheTemplate) {
  TestScene scene = plain_scene(24, 24);
  scene.width = 72;
  scene.discs.push_back({24 + 2 * kRadius + 1, 24, kRadius, 0, 170, {}});  // 1 px apart
  const Pattern p = disc_pattern(scene.render(), {24, 24, kRadius});
  EXPECT_EQ(p.weights.at(24 + 14 - p.window.x, 24 - p.window.y), 0);
  EXPECT_EQ(p.weights.at(24 - 14 - p.window.x, 24 - p.window.y), 1);
  EXPECT_EQ(p.weights.at(24 + 8 - p.window.x, 24 - p.window.y), 1);
}

TEST(Registration, SigmaGrowsWithAResidualThatIsNotNoise) {
  std::mt19937 random(6);
  TestScene scene = plain_scene(24, 24);
  auto registration = registration_of(scene.render(), 1.0 / 12);
  const double quiet = registration.refine(plain_scene(24.3, 24.3).render(), 0, 0, {}).covariance(0, 0);
  scene.ground_texture = test::random_waves(random, 12, 6, 8);
  scene.discs[0].x = scene.discs[0].y = 24.3;
  const Registration r = registration.refine(scene.render(), 0, 0, {});
  ASSERT_TRUE(r.converged);
  EXPECT_GT(r.excess_rms, 1);
  EXPECT_GT(r.covariance(0, 0), 25 * quiet);
  // The error made is of the size said.
  EXPECT_LT(std::abs(r.pose.dx - 0.3), 4 * std::sqrt(r.covariance(0, 0)));
}

TEST(Registration, NoConvergenceIsSaidNotGuessed) {
  auto registration = registration_of(plain_scene(24, 24).render(), 1.0);
  const Registration far = registration.refine(plain_scene(40, 24).render(), 0, 0, {});
  EXPECT_TRUE(!far.converged || far.ncc < 0.5);
  EXPECT_FALSE(registration.refine(Picture(48, 48, 80), 0, 0, {}).converged);
}

}  // namespace
}  // namespace tribotrack::vision
