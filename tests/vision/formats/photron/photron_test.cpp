#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "vision/formats/photron/photron.h"
#include "vision/recordings.h"

namespace tribotrack::vision {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class PhotronTest : public RecordingTest {
 protected:
  void write(const std::string& name, const std::string& text) {
    write_bytes(file(name), FileBytes(text.begin(), text.end()));
  }
  TimeBaseCandidate rate(const std::string& name, const std::string& text) {
    write(name, text);
    SourceInfo info;
    std::vector<TimeBaseCandidate> said;
    read_photron_sidecar(photron_sidecar(file("a.avi")).value()).describe(info, said);
    exposure_s = info.exposure_s;
    return said.at(0);
  }
  std::optional<double> exposure_s;
};

TEST_F(PhotronTest, TextForm) {
  auto said = rate("a.cih", "Date : 2021/4/1\r\nRecord Rate(fps) : 12500\r\nShutter Speed(s) : 1/20000\r\n");
  EXPECT_TRUE(said.accepted);
  EXPECT_EQ(said.rate_hz, 12500);
  EXPECT_DOUBLE_EQ(exposure_s.value(), 5e-5);
  said = rate("a.cih", "Record Rate(fps) : 60000\nSave Step : 36\nShutter Type2(nsec) : 1250\n");
  EXPECT_DOUBLE_EQ(said.rate_hz, 60000.0 / 36) << "one frame in 36 was saved";
  EXPECT_DOUBLE_EQ(exposure_s.value(), 1.25e-6);
  said = rate("a.cih", "Record Rate(fps) : 60000\nTrigger Mode : Random Reset\n");
  EXPECT_FALSE(said.accepted);
  EXPECT_THAT(said.reason, HasSubstr("bursts"));
}

TEST_F(PhotronTest, XmlFormBehindItsBinaryHead) {
  const auto said =
      rate("a.cihx", std::string("\0\x01\xFF junk", 8) +
                         "<cih><frameInfo><skipFrame>2</skipFrame></frameInfo><recordInfo><recordRate>500"
                         "</recordRate><shutterSpeed>50000</shutterSpeed></recordInfo></cih>");
  EXPECT_TRUE(said.accepted);
  EXPECT_EQ(said.rate_hz, 250);
  EXPECT_DOUBLE_EQ(exposure_s.value(), 2e-5);
}

TEST_F(PhotronTest, WithoutARateItIsRejectedWithTheReason) {
  for (const char* text :
       {"Total Frame : 5\r\n", "Record Rate(fps) : many\r\n", "Record Rate(fps) : 0\r\n", ""}) {
    const auto said = rate("a.cih", text);
    EXPECT_FALSE(said.accepted) << text;
    EXPECT_THAT(said.reason, HasSubstr("Record Rate"));
  }
}

TEST_F(PhotronTest, PicturesHaveTheRateToo) {
  const std::string pgm = "P5\n2 1\n255\nab";
  for (const char* name : {"shot001.pgm", "shot002.pgm"}) write(name, pgm);
  write("shot.cih", "Record Rate(fps) : 30000\n");
  for (const char* path : {"", "shot%03d.pgm"})
    EXPECT_EQ(open_source(file(path))->info().time_base.rate_hz, 30000);
  write("other.cih", "Record Rate(fps) : 1\n");
  EXPECT_EQ(open_source(file(""))->info().time_base.rate_hz, 30000) << "the one of the pictures' name";
  EXPECT_DOUBLE_EQ(open_source(file(""), {.frame_rate_hz = 50.0})->time_s(1), 0.02);
}

std::string description(int width, int height, int frames, int stored, int bits, const char* side) {
  return "#Camera Information Header\r\nRecord Rate(fps) : 1000\r\nOriginal Total Frame : 677\r\nTotal Frame "
         ": " +
         std::to_string(frames) + "\r\nStart Frame : 52\r\nImage Width : " + std::to_string(width) +
         "\r\nImage Height : " + std::to_string(height) +
         "\r\nColor Type : Mono\r\nColor Bit : " + std::to_string(stored) +
         "\r\nEffectiveBit Depth : " + std::to_string(bits) + "\r\nEffectiveBit Side : " + side + "\r\n";
}

struct Form {
  int stored, bits;
  const char* side;
};

/// 5 x 3 pixels, an odd number: frames of 12 bits begin on whole bytes.
FileBytes pixels(const Form& form, int frames) {
  FileBytes bytes;
  for (int frame = 0; frame < frames; ++frame) {
    std::uint32_t held = 0;
    for (int i = 0; i < 15; ++i) {
      auto level = static_cast<std::uint32_t>(test_level(frame, i % 5, i / 5, form.bits));
      if (*form.side == 'H') level <<= form.stored - form.bits;
      if (form.stored != 12) {
        for (int byte = 0; byte < form.stored / 8; ++byte)
          bytes.push_back(static_cast<std::uint8_t>(level >> (8 * byte)));
      } else if (i % 2 == 0) {
        bytes.push_back(static_cast<std::uint8_t>(level >> 4));
        held = level & 15;
        if (i == 14) bytes.push_back(static_cast<std::uint8_t>(held << 4));
      } else {
        bytes.push_back(static_cast<std::uint8_t>(held << 4 | level >> 8));
        bytes.push_back(static_cast<std::uint8_t>(level));
      }
    }
  }
  return bytes;
}

TEST_F(PhotronTest, BarePixelsOfEveryForm) {
  for (const Form& form : {Form{8, 8, "Lower"}, Form{12, 12, "Lower"}, Form{16, 12, "Lower"},
                           Form{16, 12, "Higher"}, Form{16, 16, "Lower"}}) {
    SCOPED_TRACE(std::to_string(form.stored) + form.side);
    write("a.cih", description(5, 3, 4, form.stored, form.bits, form.side));
    write_bytes(file("a.mraw"), pixels(form, 4));
    for (const char* name : {"a.mraw", "a.cih"}) {
      const auto source = open_source(file(name));
      EXPECT_EQ(source->info().bits, form.bits);
      EXPECT_EQ(source->number(3), 55);
      EXPECT_EQ(source->time_s(3), 0.003);
      for (int k = 0; k < 4; ++k) {
        Picture part;
        source->read(k, {1, 1, 3, 2}, part);
        for (int y = 0; y < 2; ++y)
          for (int x = 0; x < 3; ++x) ASSERT_EQ(part.at(x, y), test_level(k, x + 1, y + 1, form.bits)) << k;
      }
    }
  }
}

TEST_F(PhotronTest, WhatDoesNotFitIsNamed) {
  const Form form{8, 8, "Lower"};
  write_bytes(file("a.mraw"), pixels(form, 4));
  EXPECT_THAT(input_error(file("a.mraw")), AllOf(HasSubstr("a.mraw"), HasSubstr(".cihx")));
  write("a.cih", description(5, 3, 5, 8, 8, "Lower"));
  EXPECT_THAT(input_error(file("a.mraw")), AllOf(HasSubstr("cut short"), HasSubstr("5 frames")));
  write("a.cih", description(5, 3, 4, 36, 12, "Lower"));
  EXPECT_THAT(input_error(file("a.mraw")), HasSubstr("colour"));
  for (const auto& [width, frames] :
       {std::pair{0, 4}, std::pair{-5, 4}, std::pair{100000, 4}, std::pair{5, 0}}) {
    write("a.cih", description(width, 3, frames, 8, 8, "Lower"));
    EXPECT_THAT(input_error(file("a.mraw")), HasSubstr("a.cih"));
  }
  write("a.cih", description(5, 3, 4, 13, 13, "Lower"));
  EXPECT_THAT(input_error(file("a.mraw")), HasSubstr("Color Bit"));
}

TEST_F(PhotronTest, ANorpixSequenceIsNotDamaged) {
  write("a.seq", std::string("\xED\xFE\0\0N\0o\0r\0p\0i\0x\0", 16));
  EXPECT_THAT(input_error(file("a.seq")), AllOf(HasSubstr("StreamPix"), HasSubstr("AVI or TIFF")));
}

}  // namespace
}  // namespace tribotrack::vision
