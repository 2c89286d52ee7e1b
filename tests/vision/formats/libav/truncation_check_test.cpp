#include <gtest/gtest.h>

#include "vision/formats/libav/libav.h"
#include "vision/recordings.h"

namespace tribotrack::vision {
namespace {

class MatroskaEndTest : public RecordingTest {
 protected:
  std::optional<std::uint64_t> of(const std::string& bytes) {
    write_bytes(file("a"), FileBytes(bytes.begin(), bytes.end()));
    return matroska_end(file("a"));
  }
};

TEST_F(MatroskaEndTest, SegmentOfKnownAndUnknownSize) {
  const std::string head(
      "\x1A\x45\xDF\xA3\x82"
      "ab",
      7);
  EXPECT_EQ(of(head + std::string("\x18\x53\x80\x67\x40\x64", 6)), 113u);
  EXPECT_EQ(of(head + std::string("\x18\x53\x80\x67\x01\xFF\xFF\xFF\xFF\xFF\xFF\xFF", 12)), kUnfinished);
}

TEST_F(MatroskaEndTest, OtherFilesAreNotJudged) {
  EXPECT_FALSE(of("a text that is long enough"));
  EXPECT_FALSE(of("short"));
}

}  // namespace
}  // namespace tribotrack::vision
