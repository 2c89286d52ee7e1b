#include "vision/coding/coded_errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace tribotrack::vision {
namespace {

constexpr int kCells = 128;
constexpr double kMiddle = 0.5 * kCells * CodedFrame::kCell, kRadius = 400;

/// Cells whose middle fulfils a condition are of one kind, the others are coded by themselves.
template <class Condition>
CodedFrame frame_where(CodedCell::Kind kind, const Condition& condition) {
  CodedFrame frame{'P', kCells, kCells, {}};
  for (int row = 0; row < kCells; ++row)
    for (int column = 0; column < kCells; ++column) {
      const double x = (column + 0.5) * CodedFrame::kCell - kMiddle,
                   y = (row + 0.5) * CodedFrame::kCell - kMiddle;
      frame.cells.push_back({condition(x, y) ? kind : CodedCell::Kind::intra, 5});
    }
  return frame;
}

/// Within 45 degrees of the x axis: the integral of cos^2 is pi/4 + 1/2 on either side, that of sin^2 pi/4 -
/// 1/2.
TEST(RimCoding, EdgesAcrossCount) {
  const auto frame =
      frame_where(CodedCell::Kind::moving, [](double x, double y) { return std::abs(x) > std::abs(y); });
  const RimCoding rim = rim_coding(frame, {kMiddle, kMiddle, kRadius});
  EXPECT_NEAR(rim.moving.x, 0.5 + 1 / std::numbers::pi, 0.02);
  EXPECT_NEAR(rim.moving.y, 0.5 - 1 / std::numbers::pi, 0.02);
  EXPECT_EQ(rim.still.x, 0);
}

constexpr int kSide = 64;
const Circle kAll{32, 32, 200};

/// A vertical edge, blurred with sd 0.75 px, in the middle of a column of blocks; or a horizontal one.
Picture edge(double contrast, bool horizontal = false) {
  Picture picture(kSide, kSide);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const double off = (horizontal ? y : x) - 27.5;
      picture.at(x, y) = static_cast<float>(50 + 0.5 * contrast * std::erfc(-off / (0.75 * std::sqrt(2.0))));
    }
  return picture;
}

/// The slope of a step c has the mean coefficient c in a block of 8 x 8 px, and sqrt(2) c at the most.
TEST(DeadZone, OfAStraightEdgeLiesBetweenItsMeanAndItsLargestCoefficient) {
  const Point unnoticed = unnoticed_motion(edge(100), kAll, -1);
  EXPECT_GT(unnoticed.x, 1 / (std::sqrt(2.0) * 100));
  EXPECT_LT(unnoticed.x, 1.0 / 100);
}

TEST(DeadZone, TurnsWithThePicture) {
  const Point down = unnoticed_motion(edge(100), kAll, -1),
              across = unnoticed_motion(edge(100, true), kAll, -1);
  EXPECT_NEAR(down.x, across.y, 1e-9);
  EXPECT_EQ(down.y, 0) << "an edge tells nothing of a motion along itself";
}

}  // namespace
}  // namespace tribotrack::vision
