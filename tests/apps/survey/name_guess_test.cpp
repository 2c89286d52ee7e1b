#include "apps/survey/survey_text.h"

#include <gtest/gtest.h>

#include <numbers>

#include "apps/text/angle.h"

namespace tribotrack::apps {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

NameGuess guess(const std::string& name) {
  return guesses_from({name}).front();
}

void expect_degrees(const std::string& name, double phi, double dtau) {
  const NameGuess found = guess(name);
  ASSERT_FALSE(found.phi_text.empty() || found.dtau_text.empty()) << name;
  EXPECT_NEAR(*parse_angle(found.phi_text), phi * kDegree, 1e-12) << name;
  EXPECT_NEAR(*parse_angle(found.dtau_text), dtau * kDegree, 1e-12) << name;
}

TEST(NameGuess, DegreesAsLabsWriteThem) {
  expect_degrees("phi045_dtau060", 45, 60);
  expect_degrees("PHI-45_DTAU-60", 45, 60);
  expect_degrees("phi000_dtau060_again", 0, 60);
  expect_degrees("45deg_60deg", 45, 60);
  expect_degrees("run 3, phi=45deg, dtau=60deg", 45, 60);
  expect_degrees("p45_d60", 45, 60);
  expect_degrees("phi=-45deg dtau=60deg", -45, 60);
  expect_degrees("2021-05-11_phase_90_tau_120", 90, 120);
  expect_degrees("disc_phi22p5_dtau60", 22.5, 60);
  expect_degrees("phi22.5_dtau60.0", 22.5, 60);
  expect_degrees("phi0deg_dtau5deg", 0, 5);
}

TEST(NameGuess, RadiansWhereTheyAreSaidOrFractions) {
  const NameGuess said = guess("phi0.785rad_dtau1.05rad");
  EXPECT_DOUBLE_EQ(*parse_angle(said.phi_text), 0.785);
  EXPECT_EQ(said.phi_text, "0.785");
  const NameGuess fractions = guess("phi0.785_dtau1.05");
  EXPECT_DOUBLE_EQ(*parse_angle(fractions.dtau_text), 1.05);
}

TEST(NameGuess, OneNameSettlesTheUnitOfAll) {
  const auto guesses = guesses_from({"phi0_dtau5", "phi90_dtau5"});
  ASSERT_NE(guesses[0].dtau_text, "");
  EXPECT_NEAR(*parse_angle(guesses[0].dtau_text), 5 * kDegree, 1e-12);
  EXPECT_EQ(guess("phi0_dtau5").phi_text, "") << "by itself it may be either";
}

TEST(NameGuess, WhatIsNotThereIsNotGuessed) {
  for (const char* name : {"recording7", "IMG_20210511", "trial_45", "disc6mm", "update12", "cam1_0045"}) {
    const NameGuess found = guess(name);
    EXPECT_TRUE(found.phi_text.empty() && found.dtau_text.empty()) << name;
  }
  EXPECT_EQ(guess("phi045").phi_text, "45deg");
  EXPECT_EQ(guess("phi045").dtau_text, "");
}

TEST(NameGuess, FrameRatesAndSlides) {
  EXPECT_DOUBLE_EQ(*guess("phi045_dtau060_240fps").frame_rate_hz, 240);
  EXPECT_DOUBLE_EQ(*guess("slide_1000Hz").frame_rate_hz, 1000);
  EXPECT_FALSE(guess("phi045_dtau060").frame_rate_hz);
  EXPECT_TRUE(guess("free_slide_2").free_slide);
  EXPECT_TRUE(guess("Incline 20deg").free_slide);
  EXPECT_FALSE(guess("phi045").free_slide);
}

}  // namespace
}  // namespace tribotrack::apps
