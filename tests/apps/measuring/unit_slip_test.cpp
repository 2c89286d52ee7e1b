#include "apps/measuring/unit_slip.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace tribotrack::apps {
namespace {

TEST(UnitSlip, NamesTheUsualOnes) {
  EXPECT_EQ(likely_slip("angular_frequency_rad_s", 9.995, 62.8), "9.995 is 62.8 rad/s in Hz");
  EXPECT_EQ(likely_slip("angular_frequency_rad_s", 394.6, 62.8), "394.6 is 62.8 rad/s times 2 pi");
  EXPECT_EQ(likely_slip("angular_frequency_rad_s", 100, 62.8), "100 ms is the period of 62.83 rad/s");
  EXPECT_EQ(likely_slip("amplitude_mm", 0.198, 0.28), "0.198 is 0.28 mm as its root mean square");
  EXPECT_EQ(likely_slip("amplitude_y_mm", 0.028, 0.28), "0.028 is 0.28 mm in cm");
  EXPECT_EQ(likely_slip("diameter_mm", 0.006, 6.02), "0.006 is 6 mm in metres");
  EXPECT_EQ(likely_slip("phase_shift_rad", 0.25, std::numbers::pi / 2), "0.25 is 1.571 rad in turns");
  EXPECT_EQ(likely_slip("phase_shift_rad", 270, -std::numbers::pi / 2), "270 is 4.712 rad in degrees");
}

TEST(UnitSlip, NamesNoneWhereNoneFits) {
  EXPECT_EQ(likely_slip("amplitude_mm", 0.4, 0.28), "");
  EXPECT_EQ(likely_slip("angular_frequency_rad_s", 50, 62.8), "");
  EXPECT_EQ(likely_slip("angular_frequency_rad_s", 0, 62.8), "");
}

}  // namespace
}  // namespace tribotrack::apps
