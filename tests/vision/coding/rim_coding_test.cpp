#include "vision/coding/rim_coding.h"

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

TEST(RimCoding, AllOfOneKind) {
  const auto frame = frame_where(CodedCell::Kind::still, [](double, double) { return true; });
  const RimCoding rim = rim_coding(frame, {kMiddle, kMiddle, kRadius});
  EXPECT_EQ(rim.type, 'P');
  EXPECT_DOUBLE_EQ(rim.step, 5);
  EXPECT_NEAR(rim.still.x, 1, 1e-12);
  EXPECT_NEAR(rim.still.y, 1, 1e-12);
  EXPECT_EQ(rim.moving.x, 0);
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

TEST(RimCoding, NothingOutsideThePictureOrWithoutCells) {
  EXPECT_EQ(rim_coding({'B', 0, 0, {}}, {10, 10, 5}).step, 0);
  const auto frame = frame_where(CodedCell::Kind::still, [](double, double) { return true; });
  EXPECT_EQ(rim_coding(frame, {-900, kMiddle, 100}).still.x, 0);
}

}  // namespace
}  // namespace tribotrack::vision
