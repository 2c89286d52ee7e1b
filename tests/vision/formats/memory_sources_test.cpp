#include <gtest/gtest.h>

#include <cstdint>
#include <stdexcept>
#include <vector>

#include "vision/frame_source.h"

namespace tribotrack::vision {
namespace {

/// Level = 100 frame + 10 row + column, of three frames of 3 x 4 pixels.
const std::vector<std::uint16_t> kNumbered = [] {
  std::vector<std::uint16_t> levels;
  for (int k = 0; k < 3; ++k)
    for (int y = 0; y < 3; ++y)
      for (int x = 0; x < 4; ++x) levels.push_back(static_cast<std::uint16_t>(100 * k + 10 * y + x));
  return levels;
}();
const FrameStack kStack{kNumbered.data(), 2, 3, 4, 3, 24, 8, 2};

std::vector<Picture> pictures() {
  std::vector<Picture> frames(3, Picture(4, 3));
  for (std::size_t k = 0; k < 3; ++k)
    std::copy_n(kNumbered.begin() + static_cast<std::ptrdiff_t>(12 * k), 12, frames[k].levels().begin());
  return frames;
}

TEST(MemorySources, HandOutWindowsInAnyOrderAndRefuseReadsBeyondThem) {
  StackSource stack(kStack, 500, 12);
  MemorySource memory(pictures(), 500, 12);
  for (FrameSource* source : std::vector<FrameSource*>{&stack, &memory}) {
    EXPECT_EQ(source->info().width, 4);
    EXPECT_EQ(source->info().height, 3);
    EXPECT_EQ(source->info().bits, 12);
    EXPECT_EQ(source->info().frame_count, 3);
    EXPECT_FALSE(source->info().decoded);
    EXPECT_EQ(source->time_s(2), 2.0 / 500);
    Picture window;
    source->read(2, {1, 1, 2, 2}, window);
    EXPECT_EQ(window.width(), 2);
    EXPECT_EQ(window.height(), 2);
    EXPECT_EQ(window.at(0, 0), 211);
    EXPECT_EQ(window.at(1, 1), 222);
    EXPECT_EQ(source->read(0).at(3, 2), 23);
    EXPECT_THROW(source->read(3, {0, 0, 1, 1}, window), std::out_of_range);
    EXPECT_THROW(source->read(0, {3, 0, 2, 1}, window), std::invalid_argument);
  }
}

// The same memory from behind, copied only when it is read: last frame first, upside down, mirrored, every
// other column; and levels of one byte.
TEST(StackSource, FollowsStridesOfEitherSignAndSizesOfLevels) {
  std::vector<std::uint16_t> levels = kNumbered;
  StackSource source({levels.data() + 35, 2, 3, 2, 3, -24, -8, -4}, 500, 16);
  levels[35] = 777;
  EXPECT_EQ(source.read(0).at(0, 0), 777);
  EXPECT_EQ(source.read(0).at(1, 0), 221);
  EXPECT_EQ(source.read(0).at(0, 2), 203);
  EXPECT_EQ(source.read(2).at(1, 2), 1);
  const std::vector<std::uint8_t> bytes = {1, 2, 255, 4};
  StackSource narrow({bytes.data(), 1, 1, 2, 2, 4, 2, 1}, 500, 8);
  EXPECT_EQ(narrow.read(0).at(0, 1), 255);
  EXPECT_EQ(narrow.read(0).at(1, 1), 4);
}

TEST(MemorySources, RefuseWhatIsNoRecording) {
  FrameStack empty = kStack, floats = kStack;
  empty.frames = 0;
  floats.bytes_per_level = 4;
  EXPECT_THROW(StackSource(empty, 500, 16), std::invalid_argument);
  EXPECT_THROW(StackSource(floats, 500, 16), std::invalid_argument);
  EXPECT_THROW(StackSource(kStack, 0, 16), std::invalid_argument);
  for (const int bits : {0, 17}) EXPECT_THROW(StackSource(kStack, 500, bits), std::invalid_argument);
  EXPECT_THROW(MemorySource({}, 500), std::invalid_argument);
  EXPECT_THROW(MemorySource(pictures(), 0), std::invalid_argument);
  EXPECT_THROW(MemorySource({Picture(4, 3), Picture(3, 4)}, 500), std::invalid_argument);
}

}  // namespace
}  // namespace tribotrack::vision
