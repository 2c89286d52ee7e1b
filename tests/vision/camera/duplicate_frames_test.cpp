#include "vision/duplicate_frames.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "vision/analytic_scene.h"

namespace tribotrack::vision {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pair;

/// One picture for each of the numbers; equal numbers, equal pictures.
test::RenderedSource showing(const std::vector<int>& numbers) {
  return {40, 80, static_cast<std::int64_t>(numbers.size()), [numbers](std::int64_t k) {
            Picture picture(40, 80);
            picture.at(3, 70) = static_cast<float>(numbers[static_cast<std::size_t>(k)]);
            return picture;
          }};
}

TEST(RepeatedFrames, AreFoundWhereverThePicturesDiffer) {
  auto source = showing({1, 2, 2, 3, 4, 4, 4, 5, 1});  // they differ far from the middle rows
  source.number_from(100);
  const RepeatedFrames found = find_repeated_frames(source, 1000);
  EXPECT_EQ(found.looked_at, 9);
  EXPECT_THAT(found.repeated, ElementsAre(2, 5, 6));
  EXPECT_THAT(found.still, IsEmpty());
  EXPECT_THAT(findings(found, source),
              ElementsAre(HasSubstr("3 pictures repeat the one before: image 102, 105, 106;")));
}

TEST(RepeatedFrames, ALongPauseIsNoRowOfRepeats) {
  auto source = showing({1, 2, 3, 3, 3, 3, 3, 4});
  const RepeatedFrames found = find_repeated_frames(source, 1000);
  EXPECT_THAT(found.repeated, IsEmpty());
  EXPECT_THAT(found.still, ElementsAre(Pair(2, 6)));
  EXPECT_THAT(findings(found, source), ElementsAre(HasSubstr("images 2 to 6 are one picture")));
}

TEST(RepeatedFrames, EverySecondPictureMeansALowerRate) {
  auto source = showing({1, 1, 2, 2, 3, 3, 4, 4});
  EXPECT_THAT(findings(find_repeated_frames(source, 1000), source), ElementsAre(HasSubstr("lower rate")));
}

}  // namespace
}  // namespace tribotrack::vision
