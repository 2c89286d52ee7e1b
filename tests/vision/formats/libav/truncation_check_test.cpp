#include "vision/formats/libav/libav.h"

#include <gtest/gtest.h>

#include "vision/recordings.h"

namespace tribotrack::vision {
namespace {

class ContainerExtentTest : public RecordingTest {
 protected:
  std::optional<ContainerExtent> of(const std::string& bytes) {
    write_bytes(file("a"), FileBytes(bytes.begin(), bytes.end()));
    return container_extent(file("a"));
  }
};

TEST_F(ContainerExtentTest, Mp4BoxesInAllThreeSizes) {
  const std::string ftyp(
      "\0\0\0\x0C"
      "ftypisom",
      12);
  const std::string large(
      "\0\0\0\x01"
      "mdat\0\0\0\0\0\0\0\x14"
      "abcd",
      20);
  const std::string rest(
      "\0\0\0\0"
      "freexyz",
      11);
  EXPECT_EQ(of(ftyp + large + rest)->stated_end, 43u);
  EXPECT_EQ(of((ftyp + large).substr(0, 30))->stated_end, 32u);
  EXPECT_EQ(of((ftyp + large).substr(0, 30))->last_box, "mdat");
}

TEST_F(ContainerExtentTest, RiffAndItsContinuations) {
  const std::string first("RIFF\x08\0\0\0AVI abcd", 16);
  const std::string next("RIFF\x10\0\0\0AVIXabcd", 16);
  EXPECT_EQ(of(first)->stated_end, 16u);
  EXPECT_EQ(of(first + next)->stated_end, 40u);
  EXPECT_EQ(of(first + "junk behind")->stated_end, 16u);
}

TEST_F(ContainerExtentTest, MatroskaSegmentOfKnownAndUnknownSize) {
  const std::string head(
      "\x1A\x45\xDF\xA3\x82"
      "ab",
      7);
  EXPECT_EQ(of(head + std::string("\x18\x53\x80\x67\x40\x64", 6))->stated_end, 113u);
  const auto open = of(head + std::string("\x18\x53\x80\x67\x01\xFF\xFF\xFF\xFF\xFF\xFF\xFF", 12));
  ASSERT_TRUE(open);
  EXPECT_TRUE(open->unfinished);
}

TEST_F(ContainerExtentTest, OtherFilesAreNotJudged) {
  EXPECT_FALSE(of("a text that is long enough"));
  EXPECT_FALSE(of("short"));
}

}  // namespace
}  // namespace tribotrack::vision
