#include <gtest/gtest.h>

#include <cstdint>
#include <stdexcept>
#include <vector>

#include "vision/frame_source.h"

namespace tribotrack::vision {
namespace {

/// Level = 100 frame + 10 row + column, of three frames of 3 x 4 pixels.
std::vector<std::uint16_t> numbered() {
  std::vector<std::uint16_t> levels;
  for (int k = 0; k < 3; ++k)
    for (int y = 0; y < 3; ++y)
      for (int x = 0; x < 4; ++x) levels.push_back(static_cast<std::uint16_t>(100 * k + 10 * y + x));
  return levels;
}

FrameStack stack_of(const std::vector<std::uint16_t>& levels) {
  return {levels.data(), 2, 3, 4, 3, 24, 8, 2};
}

TEST(StackSource, HandsOutWindowsOfWhatLiesInMemory) {
  const auto levels = numbered();
  StackSource source(stack_of(levels), 500, 12);
  EXPECT_EQ(source.info().width, 4);
  EXPECT_EQ(source.info().height, 3);
  EXPECT_EQ(source.info().bits, 12);
  EXPECT_EQ(source.info().frame_count, 3);
  EXPECT_FALSE(source.info().decoded);
  EXPECT_EQ(source.time_s(2), 2.0 / 500);
  Picture window;
  source.read(2, {1, 1, 2, 2}, window);
  EXPECT_EQ(window.at(0, 0), 211);
  EXPECT_EQ(window.at(1, 1), 222);
}

TEST(StackSource, CopiesNothingBeforeItIsRead) {
  auto levels = numbered();
  StackSource source(stack_of(levels), 500, 16);
  levels[0] = 777;
  EXPECT_EQ(source.read(0).at(0, 0), 777);
}

// The same memory from behind: last frame first, upside down, mirrored, every other column.
TEST(StackSource, FollowsStridesOfEitherSign) {
  const auto levels = numbered();
  FrameStack stack{levels.data() + 35, 2, 3, 2, 3, -24, -8, -4};
  StackSource source(stack, 500, 16);
  EXPECT_EQ(source.read(0).at(0, 0), 223);
  EXPECT_EQ(source.read(0).at(1, 0), 221);
  EXPECT_EQ(source.read(0).at(0, 2), 203);
  EXPECT_EQ(source.read(2).at(1, 2), 1);
  Picture window;
  source.read(1, {1, 1, 1, 1}, window);
  EXPECT_EQ(window.at(0, 0), 111);
}

TEST(StackSource, ReadsLevelsOfOneByte) {
  const std::vector<std::uint8_t> levels = {1, 2, 255, 4};
  StackSource source({levels.data(), 1, 1, 2, 2, 4, 2, 1}, 500, 8);
  EXPECT_EQ(source.read(0).at(0, 1), 255);
  EXPECT_EQ(source.read(0).at(1, 1), 4);
}

TEST(StackSource, RefusesWhatIsNoRecordingAndReadsBeyondIt) {
  const auto levels = numbered();
  const FrameStack stack = stack_of(levels);
  FrameStack empty = stack, floats = stack;
  empty.frames = 0;
  floats.bytes_per_level = 4;
  EXPECT_THROW(StackSource(empty, 500, 16), std::invalid_argument);
  EXPECT_THROW(StackSource(floats, 500, 16), std::invalid_argument);
  EXPECT_THROW(StackSource(stack, 0, 16), std::invalid_argument);
  EXPECT_THROW(StackSource(stack, 500, 17), std::invalid_argument);
  EXPECT_THROW(StackSource(stack, 500, 0), std::invalid_argument);
  StackSource source(stack, 500, 16);
  Picture window;
  EXPECT_THROW(source.read(3, {0, 0, 1, 1}, window), std::out_of_range);
  EXPECT_THROW(source.read(0, {3, 0, 2, 1}, window), std::invalid_argument);
}

/// Level = 100 frame + 10 y + x.
std::vector<Picture> pictures(int count) {
  std::vector<Picture> frames;
  for (int k = 0; k < count; ++k) {
    Picture frame(4, 3);
    for (int y = 0; y < 3; ++y)
      for (int x = 0; x < 4; ++x) frame.at(x, y) = static_cast<float>(100 * k + 10 * y + x);
    frames.push_back(frame);
  }
  return frames;
}

TEST(MemorySource, HandsOutWindowsOfItsPicturesInAnyOrder) {
  MemorySource source(pictures(3), 500, 12);
  EXPECT_EQ(source.info().width, 4);
  EXPECT_EQ(source.info().height, 3);
  EXPECT_EQ(source.info().bits, 12);
  EXPECT_EQ(source.info().frame_count, 3);
  EXPECT_FALSE(source.info().decoded);
  EXPECT_EQ(source.time_s(2), 2.0 / 500);
  Picture window;
  source.read(2, {1, 1, 2, 2}, window);
  EXPECT_EQ(window.width(), 2);
  EXPECT_EQ(window.height(), 2);
  EXPECT_EQ(window.at(0, 0), 211);
  EXPECT_EQ(window.at(1, 1), 222);
  EXPECT_EQ(source.read(0).at(3, 2), 23);
}

TEST(MemorySource, RefusesWhatIsNoRecordingAndReadsBeyondIt) {
  EXPECT_THROW(MemorySource({}, 500), std::invalid_argument);
  EXPECT_THROW(MemorySource(pictures(1), 0), std::invalid_argument);
  EXPECT_THROW(MemorySource({Picture(4, 3), Picture(3, 4)}, 500), std::invalid_argument);
  MemorySource source(pictures(2), 500);
  Picture window;
  EXPECT_THROW(source.read(2, {0, 0, 1, 1}, window), std::out_of_range);
  EXPECT_THROW(source.read(0, {3, 0, 2, 1}, window), std::invalid_argument);
}

}  // namespace
}  // namespace tribotrack::vision
