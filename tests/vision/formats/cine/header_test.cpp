#include "vision/formats/cine/cine.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "vision/cine_by_hand.h"
#include "vision/recordings.h"

namespace tribotrack::vision {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class CineHeaderTest : public RecordingTest {
 protected:
  CineHeader header_of(CineByHand cine) {
    write_bytes(file("a.cine"), cine.bytes());
    return read_cine_header(MappedFile(file("a.cine")));
  }
  std::string refusal_of(const FileBytes& bytes) {
    write_bytes(file("a.cine"), bytes);
    try {
      read_cine_header(MappedFile(file("a.cine")));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
};

TEST_F(CineHeaderTest, AFieldCountsOnlyInsideTheBlocksLength) {
  CineByHand cine;
  cine.setup_length = 0x300;  // ends just before FrameRateInt
  const CineHeader header = header_of(cine);
  EXPECT_EQ(header.integer_rate, 0u);
  EXPECT_EQ(header.short_rate, 100u);
  EXPECT_FALSE(header.exposure_s);
}

TEST_F(CineHeaderTest, ACutAnywhereIsNoticed) {
  CineByHand cine;
  const FileBytes whole = cine.bytes();
  ASSERT_EQ(refusal_of(whole), "");
  for (std::size_t length = 0; length < whole.size();
       length += length < 300 || length + 200 > whole.size() ? 1 : 97)
    ASSERT_THAT(refusal_of(FileBytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length))),
                HasSubstr("a.cine"))
        << length;
  EXPECT_THAT(refusal_of(FileBytes(whole.begin(), whole.end() - 1)),
              AllOf(HasSubstr("cut short"), HasSubstr("image -83"), HasSubstr("3 of 3")));
}

TEST_F(CineHeaderTest, WhatIsNoGreyPictureIsRefusedByName) {
  CineByHand cine;
  cine.compression = 2;
  cine.colour_filter = 3;
  EXPECT_THAT(refusal_of(cine.bytes()), AllOf(HasSubstr("colour filter mosaic"), HasSubstr("export")));
  cine = {};
  cine.compression = 1;
  EXPECT_THAT(refusal_of(cine.bytes()), HasSubstr("JPEG"));
  cine = {};
  cine.packing = 7;
  EXPECT_THAT(refusal_of(cine.bytes()), HasSubstr("biCompression 7"));
  cine = {};
  cine.bits_per_pixel = 12;
  EXPECT_THAT(refusal_of(cine.bytes()), HasSubstr("12 bits per pixel"));
}

TEST_F(CineHeaderTest, DamageIsNamed) {
  CineByHand cine;
  FileBytes bytes = cine.bytes();
  bytes[0] = 'X';
  EXPECT_THAT(refusal_of(bytes), HasSubstr("not a Phantom .cine"));
  bytes = cine.bytes();
  bytes[0x33] = 0x7F;  // width 2 thousand million
  EXPECT_THAT(refusal_of(bytes), HasSubstr("damaged"));
  bytes = cine.bytes();
  for (int i = 0; i < 4; ++i) bytes[0x14 + i] = 0xFF;  // four thousand million images
  EXPECT_THAT(refusal_of(bytes), HasSubstr("table of 4294967295 images"));
  bytes = cine.bytes();
  for (int i = 0; i < 4; ++i) bytes[0x14 + i] = 0;
  EXPECT_THAT(refusal_of(bytes), HasSubstr("no image"));
  bytes = cine.bytes();
  for (int i = 0; i < 8; ++i) bytes[cine.table + 8 + i] = 0xFF;  // second image at the end of all things
  EXPECT_THAT(refusal_of(bytes), HasSubstr("image -84"));
  bytes = cine.bytes();
  bytes[84 + 10392] = 2;  // a tagged block smaller than its own head
  bytes[84 + 10393] = 0;
  EXPECT_THAT(refusal_of(bytes), HasSubstr("tagged block"));
}

/// The file of `cine` with `bytes` of `value` written at `place`.
FileBytes changed(CineByHand cine, std::uint64_t place, std::uint64_t value, std::size_t bytes) {
  FileBytes file = cine.bytes();
  for (std::size_t i = 0; i < bytes; ++i) file[place + i] = static_cast<std::uint8_t>(value >> (8 * i));
  return file;
}

TEST_F(CineHeaderTest, SizesAreCheckedBeforeAnythingIsAllocated) {
  const auto with_size = [&](int width, int height) {
    CineByHand cine;
    cine.width = width;
    cine.height = height;
    return refusal_of(cine.bytes());
  };
  for (const auto& [width, height] : {std::pair{65535, 65535},
                                      {32768, 32768},
                                      {2147483647, 1},
                                      {0, 4},
                                      {8, 0},
                                      {-8, 4},
                                      {8, -2147483647 - 1}})
    EXPECT_THAT(with_size(width, height), AllOf(HasSubstr("damaged or too large"), HasSubstr("copy")))
        << width << " x " << height;
  EXPECT_EQ(with_size(1, 1), "");
  EXPECT_EQ(with_size(8, -4), "");
}

TEST_F(CineHeaderTest, KindsThatNobodyKnowsAreRefusedNotGuessed) {
  EXPECT_THAT(refusal_of(changed({}, 0x02, 60, 2)),
              AllOf(HasSubstr("header of 60 bytes"), HasSubstr("only one of 44"), HasSubstr("TIFF")));
  EXPECT_THAT(refusal_of(changed({}, 0x06, 65535, 2)), HasSubstr("version 65535"));
  EXPECT_THAT(refusal_of(changed({}, 0x2C, 124, 4)), HasSubstr("bitmap header of 124 bytes"));
  EXPECT_THAT(refusal_of(changed({}, 84 + 0x8E, 4, 2)), HasSubstr("setup block claims 4 bytes"));
}

TEST_F(CineHeaderTest, ImagesThatShareBytesAreRefused) {
  CineByHand cine;
  cine.bytes();  // fills in where the table lies
  const std::uint64_t second = cine.table + 8;
  EXPECT_THAT(refusal_of(changed(cine, second, cine.positions[2], 8)),
              AllOf(HasSubstr("image -84 (2 of 3) and image -83 (3 of 3)"), HasSubstr("share bytes")));
  EXPECT_THAT(refusal_of(changed(cine, second, cine.positions[0] + 1, 8)), HasSubstr("share bytes"));
  EXPECT_THAT(refusal_of(changed(cine, second, 100, 8)),
              AllOf(HasSubstr("image -84"), HasSubstr("lies in the setup block")));
  EXPECT_THAT(refusal_of(changed(cine, second, cine.table, 8)), HasSubstr("lies in the table of images"));
  EXPECT_THAT(refusal_of(changed(cine, second, 44, 8)), HasSubstr("lies in the bitmap header"));
  for (const std::uint64_t far : {std::uint64_t{1} << 63, ~std::uint64_t{0}, std::uint64_t{1} << 31})
    EXPECT_THAT(refusal_of(changed(cine, second, far, 8)), HasSubstr("image -84")) << far;
  EXPECT_THAT(refusal_of(changed(cine, second, 0, 8)), HasSubstr("image -84"));
}

TEST_F(CineHeaderTest, OtherOffsetsThatLeadAstray) {
  for (const std::uint64_t place : {0x18u, 0x1Cu, 0x20u})
    for (const std::uint64_t far : {0xFFFFFFFFu, 0x7FFFFFFFu})
      EXPECT_THAT(refusal_of(changed({}, place, far, 4)), HasSubstr("cut short or damaged"))
          << place << " " << far;
}

}  // namespace
}  // namespace tribotrack::vision
