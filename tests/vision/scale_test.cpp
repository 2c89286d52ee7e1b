#include "vision/scale.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace tribotrack::vision {
namespace {

TEST(Scale, OfADiscIsItsDiameterOverTwoRadii) {
  const Scale scale = scale_from_diameter(6, 30, 0, 0);
  EXPECT_DOUBLE_EQ(scale.mm_per_px, 0.1);
  EXPECT_EQ(scale.sd, 0);
  EXPECT_EQ(scale.source, "part's diameter");
}

TEST(Scale, ItsSdHoldsTheNoiseOfTheRadiusAndTheDoubtAboutTheRim) {
  EXPECT_DOUBLE_EQ(scale_from_diameter(6, 30, 0.03, 0).sd, 0.1 * 0.03 / 30);
  EXPECT_DOUBLE_EQ(scale_from_diameter(6, 30, 0, 0.8).sd, 0.1 * (0.64 / 120) / 30);
  EXPECT_DOUBLE_EQ(scale_from_diameter(6, 30, 0.03, 2 * 1.0954451150103321).sd, 0.1 * 0.05 / 30);  // 3, 4, 5
}

TEST(Scale, NothingWithoutSizeHasOne) {
  EXPECT_THROW(scale_from_diameter(0, 30, 0, 0), std::invalid_argument);
  EXPECT_THROW(scale_from_diameter(6, 0, 0, 0), std::invalid_argument);
  EXPECT_THROW(given_scale(-1), std::invalid_argument);
  EXPECT_EQ(given_scale(0.1).sd, 0);
}

}  // namespace
}  // namespace tribotrack::vision
