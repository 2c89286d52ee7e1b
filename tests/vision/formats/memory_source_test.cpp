#include <gtest/gtest.h>

#include <stdexcept>

#include "vision/frame_source.h"

namespace tribotrack::vision {
namespace {

/// Level = 100 frame + 10 y + x.
std::vector<Picture> numbered(int count) {
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
  MemorySource source(numbered(3), 500, 12);
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
  EXPECT_THROW(MemorySource(numbered(1), 0), std::invalid_argument);
  EXPECT_THROW(MemorySource({Picture(4, 3), Picture(3, 4)}, 500), std::invalid_argument);
  MemorySource source(numbered(2), 500);
  Picture window;
  EXPECT_THROW(source.read(2, {0, 0, 1, 1}, window), std::out_of_range);
  EXPECT_THROW(source.read(0, {3, 0, 2, 1}, window), std::invalid_argument);
}

}  // namespace
}  // namespace tribotrack::vision
