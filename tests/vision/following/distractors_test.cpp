#include "vision/following/prediction.h"

#include <gtest/gtest.h>

namespace tribotrack::vision {
namespace {

TEST(Distractors, KnownOnesExplainTheirCandidatesAndMoveWithThem) {
  Distractors others(10);
  others.add({0, 0});
  for (int k = 1; k <= 20; ++k) EXPECT_TRUE(others.unexplained({{6.0 * k, 0}}).empty()) << k;
  EXPECT_DOUBLE_EQ(others.places()[0].x, 120);
}

TEST(Distractors, NearestPairFirstAndOneEach) {
  Distractors others(10);
  others.add({0, 0});
  const auto left = others.unexplained({{8, 0}, {1, 0}});
  ASSERT_EQ(left.size(), 1U);
  EXPECT_DOUBLE_EQ(left[0].x, 8);  // the part, close by, is not swallowed
}

TEST(Distractors, CoveredOneKeepsItsPlace) {
  Distractors others(10);
  others.add({50, 50});
  EXPECT_EQ(others.unexplained({{100, 100}}).size(), 1U);
  EXPECT_TRUE(others.unexplained({{51, 50}}).empty());
}

TEST(Distractors, ThatAllJumpByMoreThanAQuarterOfTheirDistanceAreSaidTo) {
  for (const double jump : {2.0, 9.0}) {
    Distractors others(15);
    std::vector<Point> seen;
    for (int k = 0; k < 5; ++k) {
      others.add({20.0 * k, 0});
      seen.push_back({20 * k + jump, 0});
    }
    EXPECT_TRUE(others.unexplained(seen).empty());
    EXPECT_EQ(others.all_moved(), jump > 5);
  }
}

}  // namespace
}  // namespace tribotrack::vision
