#include "vision/layers/model/ring_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>

namespace tribotrack::vision {
namespace {

constexpr int kHalf = 24, kSize = 2 * kHalf + 1;
constexpr float kCertain = 1e6F;

/// A picture of law(rho, phi) about the middle of the grid.
template <class Law>
Picture field(const Law& law) {
  Picture out(kSize, kSize);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const int u = x - kHalf, v = y - kHalf;
      out.at(x, y) = static_cast<float>(law(std::hypot(u, v), std::atan2(v, u)));
    }
  return out;
}

TEST(RingFit, WavesThatAreAlikeOnAllRingsAreReproduced) {
  const Picture values = field([](double, double phi) {
    return 0.3 - 0.2 * std::cos(phi) + 0.5 * std::sin(phi) + 0.4 * std::cos(2 * phi) -
           0.1 * std::sin(2 * phi);
  });
  const Picture fitted = ring_fit(values, Picture(kSize, kSize, kCertain), 10);
  for (std::size_t i = 0; i < fitted.levels().size(); ++i)
    ASSERT_NEAR(fitted.levels()[i], values.levels()[i], 1e-5) << i;
}

// A profile of the curvature f'' loses f'' / 12 to the width of a ring and f'' / 8 between two of them; a
// ring has more places on its outer side, which moves it by 1 / (6 rho).
TEST(RingFit, ProfilesSmoothAlongTheRadiusAreReproduced) {
  constexpr double kRim = 14, kWide = 4;
  const auto bump = [](double rho) { return std::exp(-0.5 * std::pow((rho - kRim) / kWide, 2)); };
  const Picture values = field([&](double rho, double phi) {
    return bump(rho) * (1 + 0.5 * std::cos(phi) - 0.8 * std::sin(2 * phi));
  });
  const Picture fitted = ring_fit(values, Picture(kSize, kSize, kCertain), 10);
  const double curvature = 2.3 / (kWide * kWide), slope = 2.3 * std::exp(-0.5) / kWide;
  const Picture allowed = field([&](double rho, double) {
    return 1.3 * (curvature * (1.0 / 12 + 1.0 / 8) + slope / (6 * std::max(1.0, rho)));
  });
  for (std::size_t i = 0; i < fitted.levels().size(); ++i)
    ASSERT_NEAR(fitted.levels()[i], values.levels()[i], allowed.levels()[i]) << i;
}

TEST(RingFit, ThirdHarmonicIsNotSmoothAlongTheRings) {
  const Picture values = field([](double rho, double phi) { return rho > 6 ? std::cos(3 * phi) : 0; });
  const Picture fitted = ring_fit(values, Picture(kSize, kSize, kCertain), 10);
  double rms = 0;
  for (int x = kHalf + 8; x < kSize - 8; ++x) rms += std::pow(fitted.at(x, kHalf), 2) / (kHalf - 15);
  EXPECT_LT(std::sqrt(rms), 0.1);
}

TEST(RingFit, PlacesWithoutWeightSayNothing) {
  const Picture fitted = ring_fit(Picture(kSize, kSize, 3), Picture(kSize, kSize), 1);
  for (const float level : fitted.levels()) ASSERT_EQ(level, 0);
}

// On a grid that four quarter turns leave as it is the mean of a ring stands by itself: it is W / (W + 1 /
// sd^2) of what W says.
TEST(RingFit, LittleIsKnownOfARingOfLittleWeight) {
  constexpr double kWeight = 1.0 / 64, kSd = 0.7, kLevel = 2;
  const Picture fitted = ring_fit(Picture(kSize, kSize, kLevel), Picture(kSize, kSize, kWeight), kSd);
  for (const int ring : {3, 8, 17}) {
    const Picture shares = field([&](double rho, double) { return std::max(0.0, 1 - std::abs(rho - ring)); });
    double weight = 0;
    for (const float share : shares.levels()) weight += kWeight * static_cast<double>(share);
    EXPECT_NEAR(fitted.at(kHalf + ring, kHalf), kLevel * weight / (weight + 1 / (kSd * kSd)), 1e-5) << ring;
  }
}

// Five waves along the 2 pi rho places of a ring, those beside it counting less: the variance that is left of
// the noise's is 5 sum h^2 / (sum h)^2, with sum h = 2 pi rho and sum h^2 two thirds of it.
TEST(RingFit, NoiseIsAveragedAlongTheRing) {
  constexpr double kNoise = 0.5, kRing = 20;
  constexpr int kTrials = 200;
  double square = 0;
  for (unsigned seed = 0; seed < kTrials; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> gauss(0, kNoise);
    const Picture noise = field([&](double, double) { return gauss(random); });
    const Picture fitted = ring_fit(noise, Picture(kSize, kSize, 1 / (kNoise * kNoise)), 100);
    // Places whose distance is 20 exactly.
    for (const auto& [u, v] :
         {std::pair{20, 0}, {0, 20}, {-20, 0}, {0, -20}, {12, 16}, {-16, 12}, {-12, -16}, {16, -12}})
      square += std::pow(fitted.at(kHalf + u, kHalf + v), 2) / (8 * kTrials);
  }
  const double told = kNoise * kNoise * 5 * (2.0 / 3) / (2 * std::numbers::pi * kRing);
  EXPECT_NEAR(square, told, 0.15 * told);
}

}  // namespace
}  // namespace tribotrack::vision
