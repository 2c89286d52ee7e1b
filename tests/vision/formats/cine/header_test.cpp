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
  std::string refusal(const FileBytes& bytes) {
    write_bytes(file("a.cine"), bytes);
    return refusal_of([&] { read_cine_header(MappedFile(file("a.cine"))); });
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
  ASSERT_EQ(refusal(whole), "");
  for (std::size_t length = 0; length < whole.size();
       length += length < 300 || length + 200 > whole.size() ? 1 : 97)
    ASSERT_THAT(refusal(FileBytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length))),
                HasSubstr("a.cine"))
        << length;
  EXPECT_THAT(refusal(FileBytes(whole.begin(), whole.end() - 1)),
              AllOf(HasSubstr("cut short"), HasSubstr("image -83"), HasSubstr("3 of 3")));
}

TEST_F(CineHeaderTest, WhatIsNoGreyPictureIsRefusedByName) {
  CineByHand cine;
  cine.compression = 2;
  cine.colour_filter = 3;
  EXPECT_THAT(refusal(cine.bytes()), AllOf(HasSubstr("colour filter mosaic"), HasSubstr("export")));
  cine = {};
  cine.compression = 1;
  EXPECT_THAT(refusal(cine.bytes()), HasSubstr("JPEG"));
  cine = {};
  cine.packing = 7;
  EXPECT_THAT(refusal(cine.bytes()), HasSubstr("biCompression 7"));
  cine = {};
  cine.bits_per_pixel = 12;
  EXPECT_THAT(refusal(cine.bytes()), HasSubstr("12 bits per pixel"));
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
    return refusal(cine.bytes());
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

TEST_F(CineHeaderTest, DamageAndKindsThatNobodyKnowsAreRefusedByName) {
  CineByHand cine;
  cine.bytes();  // fills in where the table lies
  const std::uint64_t second = cine.table + 8, end = 84 + 10392;
  struct Damage {
    std::uint64_t place, value;
    std::size_t bytes;
    const char* named;
  };
  for (const Damage& d :
       {Damage{0x00, 'X', 1, "not a Phantom .cine"},
        Damage{0x33, 0x7F, 1, "damaged"},  // two thousand million wide
        Damage{0x14, 0xFFFFFFFF, 4, "table of 4294967295 images"}, Damage{0x14, 0, 4, "no image"},
        Damage{0x02, 60, 2, "header of 60 bytes"}, Damage{0x06, 65535, 2, "version 65535"},
        Damage{0x2C, 124, 4, "bitmap header of 124 bytes"},
        Damage{84 + 0x8E, 4, 2, "setup block claims 4 bytes"},
        Damage{end, 2, 2, "tagged block"},  // smaller than its own head
        // Where the second image lies: within another, in what is none, and nowhere.
        Damage{second, cine.positions[2], 8, "image -84 (2 of 3) and image -83 (3 of 3)"},
        Damage{second, cine.positions[0] + 1, 8, "share bytes"},
        Damage{second, 100, 8, "lies in the setup block"},
        Damage{second, cine.table, 8, "lies in the table of images"},
        Damage{second, 44, 8, "lies in the bitmap header"}, Damage{second, 0, 8, "image -84"},
        Damage{second, std::uint64_t{1} << 31, 8, "image -84"},
        Damage{second, std::uint64_t{1} << 63, 8, "image -84"},
        Damage{second, ~std::uint64_t{0}, 8, "image -84"}})
    EXPECT_THAT(refusal(changed(cine, d.place, d.value, d.bytes)), HasSubstr(d.named)) << d.value;
}

TEST_F(CineHeaderTest, OtherOffsetsThatLeadAstray) {
  for (const std::uint64_t place : {0x18u, 0x1Cu, 0x20u})
    for (const std::uint64_t far : {0xFFFFFFFFu, 0x7FFFFFFFu})
      EXPECT_THAT(refusal(changed({}, place, far, 4)), HasSubstr("cut short or damaged"))
          << place << " " << far;
}

}  // namespace
}  // namespace tribotrack::vision
