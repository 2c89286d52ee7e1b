#include "apps/text/heading.h"

#include <gtest/gtest.h>

#include <numbers>

namespace tribotrack::apps {
namespace {

void expect(const char* text, const char* quantity, const char* unit, bool sd = false) {
  const Heading heading = heading_of(text);
  EXPECT_EQ(heading.quantity, quantity) << text;
  EXPECT_EQ(heading.unit, unit) << text;
  EXPECT_EQ(heading.sd, sd) << text;
}

TEST(Heading, QuantityAndUnitInEverySpelling) {
  for (const char* text :
       {"phi_deg", "phi (deg)", "phi [\xc2\xb0]", "PHI_DEG", "phi, degrees", "\xcf\x86 (\xc2\xb0)"})
    expect(text, "phi", "deg");
  for (const char* text :
       {"v_mm_s", "v (mm/s)", "V [mm/s]", "v mm s^-1", "v (mm\xc2\xb7s\xe2\x81\xbb\xc2\xb9)"})
    expect(text, "v", "mm/s");
  expect("\xce\x94\xcf\x84 [rad]", "dtau", "rad");
  expect("angular_frequency_rad_s", "angular_frequency", "rad/s");
  expect("Time (ms)", "time", "ms");
  expect("amplitude (\xc2\xb5m)", "amplitude", "um");
  expect("alpha_model_rad", "alpha_model", "rad");
}

TEST(Heading, TheSdIsMarkedAnywhere) {
  for (const char* text : {"alpha_sd_deg", "alpha_deg_sd", "sd_alpha_deg", "sd alpha (deg)",
                           "\xcf\x83 alpha (deg)", "alpha std [deg]"})
    expect(text, "alpha", "deg", true);
  expect("sigma_x_px", "x", "px", true);
}

TEST(Heading, AUnitIsNeverTheFirstWord) {
  expect("v", "v", "");
  expect("t", "t", "");
  expect("m", "m", "");
  expect("", "", "");
  expect("alpha", "alpha", "");
}

TEST(Heading, UnitsInSi) {
  EXPECT_DOUBLE_EQ(*si_per("deg", Dimension::angle), std::numbers::pi / 180);
  EXPECT_EQ(si_per("mm/s", Dimension::velocity), 1e-3);
  EXPECT_EQ(si_per("mv", Dimension::voltage), 1e-3);
  EXPECT_EQ(si_per("mm", Dimension::velocity), std::nullopt);
  EXPECT_EQ(si_per("furlong", Dimension::length), std::nullopt);
}

}  // namespace
}  // namespace tribotrack::apps
