
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "vision/formats/libav/libav.h"
#include "vision/recordings.h"

namespace tribotrack::vision {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;

class ContainmentTest : public RecordingTest {
 protected:
  static SinkOptions options() { return {.width = 48, .height = 32, .frame_rate_hz = 240}; }
  std::string refusal(const std::string& text, const std::string& name = "a.mp4") {
    write_bytes(file(name), FileBytes(text.begin(), text.end()));
    return input_error(file(name));
  }
};

std::size_t place_of(const FileBytes& bytes, const std::string& word) {
  return static_cast<std::size_t>(std::search(bytes.begin(), bytes.end(), word.begin(), word.end()) -
                                  bytes.begin());
}

TEST_F(ContainmentTest, WhatLeadsElsewhereIsNotFollowed) {
  write_recording(file("secret.mkv"), options(), 3);
  const std::string target = file("secret.mkv").string();
  for (const std::string& text :
       {"#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\n" + target + "\n#EXT-X-ENDLIST\n",
        "ffconcat version 1.0\nfile " + target + "\n",
        std::string("v=0\no=- 0 0 IN IP4 127.0.0.1\nc=IN IP4 127.0.0.1\nm=video 5004 RTP/AVP 26\n"),
        std::string("<?xml version=\"1.0\"?><MPD xmlns=\"urn:mpeg:dash:schema:mpd:2011\"></MPD>")})
    EXPECT_THAT(refusal(text), AllOf(HasSubstr("a.mp4"), HasSubstr("no video"))) << text;
}

TEST_F(ContainmentTest, OtherContainersAreNamedWithTheRemedy) {
  const std::string gif(
      "GIF89a\x08\x00\x08\x00\x80\x00\x00\x00\x00\x00\xFF\xFF\xFF!\xF9\x04\x00\x0A\x00\x00"
      "\x00,\x00\x00\x00\x00\x08\x00\x08\x00\x00\x02\x07\x84\x8F\xA9\xCB\xED]\x00;",
      48);
  EXPECT_THAT(refusal(gif, "a.gif"),
              AllOf(HasSubstr("no video of a kind that is read"), HasSubstr("MP4"), HasSubstr("ffmpeg -i")));
}

TEST_F(ContainmentTest, OtherCodingsAreNamedWithTheRemedy) {
  if (std::system("ffmpeg -version > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "no ffmpeg to write such a video with";
  const std::string command =
      "ffmpeg -v error -y -f lavfi -i color=gray:s=64x48:r=25:d=0.2 -c:v flv1 " + file("a.avi").string();
  ASSERT_EQ(std::system(command.c_str()), 0);
  EXPECT_THAT(input_error(file("a.avi")),
              AllOf(HasSubstr("the coding flv"), HasSubstr("not read"), HasSubstr("ffmpeg -i")));
}

TEST_F(ContainmentTest, SizesAreCheckedBeforeDecoding) {
  EXPECT_THAT(refusal("YUV4MPEG2 W10000 H10000 F25:1 Ip A1:1 C420\nFRAME\n....", "a.y4m"),
              AllOf(HasSubstr("10000 x 10000"), HasSubstr("too large")));
  EXPECT_EQ(refusal("YUV4MPEG2 W2 H2 F25:1 Ip A1:1 Cmono\nFRAME\nabcd", "a.y4m"), "");
}

TEST_F(ContainmentTest, ATableOfFramesIsNotBelieved) {
  write_recording(file("a.mp4"), options(), 40);
  FileBytes bytes = read_bytes(file("a.mp4"));
  const auto put = [&](std::size_t at, std::uint32_t value) {
    for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<std::uint8_t>(value >> (24 - 8 * i));
  };
  // stsz: version, size of all samples, count; stts: version, entries, count, step; stsc: ..., samples a
  // chunk.
  constexpr std::uint32_t many = 0x0FFFFFFF;
  put(place_of(bytes, "stsz") + 8, 1);
  put(place_of(bytes, "stsz") + 12, many);
  put(place_of(bytes, "stts") + 12, many);
  put(place_of(bytes, "stsc") + 16, many);
  write_bytes(file("a.mp4"), bytes);
  EXPECT_THAT(input_error(file("a.mp4")), HasSubstr("a.mp4"));
}

TEST_F(ContainmentTest, ADamagedFrameIsNamedByItsNumber) {
  write_recording(file("a.mkv"), options(), 40);
  FileBytes bytes = read_bytes(file("a.mkv"));
  for (std::size_t i = 0; i < 8; ++i) bytes[bytes.size() / 2 + i] ^= 0x5A;
  write_bytes(file("a.mkv"), bytes);
  EXPECT_THAT(input_error(file("a.mkv")), ContainsRegex("frame [0-9]+ \\(packet [0-9]+ of 40\\)"));
}

TEST(Containment, OnlyWholeNamesCount) {
  EXPECT_TRUE(is_coding_read("h264"));
  EXPECT_TRUE(is_coding_read("qtrle"));
  EXPECT_FALSE(is_coding_read("h26"));
  EXPECT_FALSE(is_coding_read("tiff"));
  EXPECT_FALSE(is_coding_read(""));
}

}  // namespace
}  // namespace tribotrack::vision
