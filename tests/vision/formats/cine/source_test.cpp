#include "vision/formats/cine/cine.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "vision/cine_by_hand.h"
#include "vision/recordings.h"

namespace tribotrack::vision {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class CineSourceTest : public RecordingTest {
 protected:
  std::unique_ptr<FrameSource> open(CineByHand cine, const SourceOptions& options = {}) {
    write_bytes(file("a.cine"), cine.bytes());
    return open_source(file("a.cine"), options);
  }
};

TEST_F(CineSourceTest, EightBitRowsAreStoredLastFirst) {
  const auto source = open({});
  const Picture picture = source->read(2);
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 8; ++x) EXPECT_EQ(picture.at(x, y), 100 + (3 - y) * 8 + x);
}

TEST_F(CineSourceTest, NegativeHeightMeansFirstRowFirst) {
  CineByHand cine;
  cine.height = -4;
  const Picture picture = open(cine)->read(0);
  ASSERT_EQ(picture.height(), 4);
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 8; ++x) EXPECT_EQ(picture.at(x, y), y * 8 + x);
}

TEST_F(CineSourceTest, AWindowIsThatPartOfThePicture) {
  const auto source = open({});
  const Picture whole = source->read(1);
  Picture part;
  source->read(1, {3, 1, 4, 2}, part);
  ASSERT_EQ(part.width(), 4);
  ASSERT_EQ(part.height(), 2);
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 4; ++x) EXPECT_EQ(part.at(x, y), whole.at(x + 3, y + 1));
  EXPECT_THROW(source->read(1, {5, 1, 4, 2}, part), std::invalid_argument);
  EXPECT_THROW(source->read(3, {0, 0, 1, 1}, part), std::out_of_range);
}

TEST_F(CineSourceTest, RowsEndOnWholeWords) {
  CineByHand cine;
  cine.width = 7;  // stored as 8 bytes
  EXPECT_EQ(open(cine)->read(0).at(6, 3), 6);
  EXPECT_EQ(open(cine)->read(0).at(0, 2), 8);
  cine.image_bytes = 28;  // a writer that forgot the padding
  EXPECT_EQ(open(cine)->read(0).at(0, 2), 7);
}

TEST_F(CineSourceTest, SixteenBitWords) {
  CineByHand cine;
  cine.bits_per_pixel = 16;
  cine.image_bytes = 64;
  cine.real_bits = 12;
  EXPECT_EQ(open(cine)->read(0).at(1, 3), 2 + 256 * 3);
  EXPECT_EQ(open(cine)->read(0).at(0, 2), 16 + 256 * 17);
}

TEST_F(CineSourceTest, PackedPixelsRunOnWithoutRowEndsFirstRowFirst) {
  CineByHand cine;
  cine.packing = 256;
  cine.width = 6;  // rows do not end on whole groups
  cine.image_bytes = 30;
  const auto source = open(cine);
  EXPECT_EQ(source->info().bits, 12);
  const Picture picture = source->read(0);
  for (int i = 0; i < 24; ++i) {
    const int bit = 10 * i, byte = bit / 8;  // byte i of image 0 is i
    const int code = (byte << 8 | (byte + 1)) >> (6 - bit % 8) & 1023;
    ASSERT_EQ(picture.at(i % 6, i / 6), p10_linear_levels[static_cast<std::size_t>(code)]) << i;
  }
  cine.packing = 1024;
  cine.image_bytes = 36;
  EXPECT_EQ(open(cine)->read(0).at(1, 0), (1 & 15) << 8 | 2);
  EXPECT_EQ(open(cine)->read(0).at(0, 1), 9 << 4 | 10 >> 4);
}

TEST_F(CineSourceTest, StoredColourIsHandedOutAsLuma) {
  CineByHand cine;
  cine.bits_per_pixel = 24;
  cine.image_bytes = 96;
  const auto source = open(cine);
  EXPECT_TRUE(source->info().colour);
  EXPECT_NEAR(source->read(0).at(1, 3), 0.299 * 5 + 0.587 * 4 + 0.114 * 3, 1e-4);
}

TEST_F(CineSourceTest, TimesAreTheStampsElseIndexOverRateElseTheUsers) {
  CineByHand cine;
  auto source = open(cine);
  EXPECT_EQ(source->time_s(2), 0.5);  // stamped, whatever the rate says
  EXPECT_EQ(*source->info().time_base.rate_hz, 4) << "the one the times have";
  EXPECT_EQ(source->info().time_base.source, "cine time stamps");
  EXPECT_THAT(source->info().notes, ElementsAre(HasSubstr("4 Hz where 2000 Hz")));
  EXPECT_EQ(source->info().trigger_time, "2001-09-09T01:46:40.500000Z");
  EXPECT_EQ(source->number(1), -84);

  source = open(cine, {.frame_rate_hz = 50.0});
  EXPECT_EQ(source->time_s(2), 0.04);
  EXPECT_EQ(source->info().time_base.source, "--fps");
  EXPECT_THAT(source->info().notes, ::testing::Contains(HasSubstr("leave --fps out")));

  cine.stamps = false;
  EXPECT_EQ(open(cine)->time_s(2), 0.001);
  cine.rate = 0;
  EXPECT_EQ(open(cine)->time_s(2), 0.02) << "the short rate field";
  cine.short_rate = 0;
  source = open(cine);
  EXPECT_FALSE(source->info().time_base.known());
  EXPECT_THAT(source->info().time_base.why_unknown(), HasSubstr("--fps"));
  cine.stamps = true;
  source = open(cine);
  EXPECT_EQ(*source->info().time_base.rate_hz, 4);
  EXPECT_EQ(source->info().time_base.source, "cine time stamps");
}

TEST_F(CineSourceTest, OldFilesWithShortOffsetsReadLikeNewOnes) {
  CineByHand cine;
  cine.version = 0;
  cine.packing = 1024;  // packed 12 bit
  cine.real_bits = 12;
  cine.image_bytes = 48;
  const auto source = open(cine);
  EXPECT_EQ(source->info().codec, "P12L");
  EXPECT_EQ(source->info().bits, 12);
  EXPECT_EQ(source->time_s(2), 0.5) << "stamps";
  EXPECT_EQ(source->number(2), -83);
  const Picture picture = source->read(2);
  for (int i = 0; i < 32; ++i) {
    const int byte = 12 * i / 8;  // byte b of image 2 is 100 + b
    const int pair = (100 + byte) << 8 | (101 + byte);
    ASSERT_EQ(picture.at(i % 8, i / 8), (i % 2 == 0 ? pair >> 4 : pair) & 0xFFF) << i;
  }
}

TEST_F(CineSourceTest, BlackAndWhiteAreLevelsAsHandedOut) {
  CineByHand cine;
  EXPECT_FALSE(open(cine)->info().black_level);
  EXPECT_EQ(open(cine)->info().clipping_level(), 255);
  cine.black_level = 4;
  cine.white_level = 254;
  EXPECT_EQ(open(cine)->info().black_level, 4);
  EXPECT_EQ(open(cine)->info().white_level, 254);
  EXPECT_EQ(open(cine)->info().clipping_level(), 254);
  cine.packing = 256;
  cine.image_bytes = 40;
  cine.black_level = 64;
  cine.white_level = 1014;
  EXPECT_EQ(open(cine)->info().black_level, 64);
  EXPECT_EQ(open(cine)->info().white_level, 4064) << "the codes made linear";
}

TEST_F(CineSourceTest, AFramesTimeIsTheMiddleOfItsExposure) {
  CineByHand cine;
  cine.exposures = {1u << 28, 1u << 28, 1u << 28};  // 1/16 s each
  EXPECT_EQ(open(cine)->time_s(2), 0.5);
  EXPECT_TRUE(open(cine)->info().exposures_s.empty()) << "all alike";
  EXPECT_EQ(open(cine)->exposure_s(2), 1e-4) << "the header's";
  cine.exposures = {1u << 28, 1u << 29, 1u << 27};
  const auto source = open(cine);
  EXPECT_EQ(source->exposure_s(0), 1 / 16.0);
  EXPECT_EQ(source->exposure_s(2), 1 / 32.0);
  EXPECT_EQ(source->time_s(0), 0);
  EXPECT_EQ(source->time_s(1), 0.25 + 1 / 32.0);
  EXPECT_EQ(source->time_s(2), 0.5 - 1 / 64.0);
  EXPECT_THAT(source->info().notes, ::testing::Contains(HasSubstr("exposure varies")));
}

TEST_F(CineSourceTest, MissingImagesAreFoundByTheirStamps) {
  CineByHand cine;
  cine.images = 7;
  cine.rate = 64;
  cine.stamps_64ths = {10, 11, 12, 13, 17, 18, 19};
  const auto source = open(cine);
  EXPECT_EQ(source->time_s(4), 7 / 64.0);
  EXPECT_THAT(source->info().notes, ElementsAre(HasSubstr("3 frames are missing between image -82 and -81")));
}

TEST_F(CineSourceTest, AFileThatShrinksWhileReadIsAnErrorNotASignal) {
  CineByHand cine;
  cine.width = 256;
  cine.height = 128;
  cine.image_bytes = 256 * 128;
  const auto source = open(cine);
  source->read(2);
  std::filesystem::resize_file(file("a.cine"), 20000);
  EXPECT_THROW(source->read(2), InputError);
  EXPECT_THROW(source->read(0), InputError) << "what is left is no more to be trusted";
}

TEST_F(CineSourceTest, AnyByteOfTheHeadMayBeWrong) {
  CineByHand cine;
  const FileBytes whole = cine.bytes();
  std::size_t refused = 0;
  for (std::size_t i = 0; i < whole.size(); i += i < 90 || i > 84 + 10392 ? 1 : 61)
    for (const std::uint8_t wrong : {std::uint8_t{0}, std::uint8_t{0x7F}, std::uint8_t{0xFF}}) {
      FileBytes bytes = whole;
      bytes[i] = wrong;
      write_bytes(file("a.cine"), bytes);
      std::string error;
      ASSERT_NO_THROW(error = input_error(file("a.cine"))) << "byte " << i;
      if (!error.empty()) {
        ++refused;
        ASSERT_THAT(error, HasSubstr("a.cine")) << "byte " << i;
      }
    }
  EXPECT_GT(refused, 50u);
}

// Real recordings, by several cameras; their numbers were read out of the files by hand.
class RealCineTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (real_data().empty()) GTEST_SKIP() << "TRIBOTRACK_REAL_DATA names no folder";
  }
  std::unique_ptr<FrameSource> open(const char* name) { return open_source(real_data() / "cine" / name); }
  static double mean(const Picture& picture) {
    double sum = 0;
    for (const float level : picture.levels()) sum += level;
    return sum / static_cast<double>(picture.levels().size());
  }
};

TEST_F(RealCineTest, EightBits) {
  const auto source = open("phantom_v1610.cine");
  const SourceInfo& info = source->info();
  EXPECT_EQ(info.width, 256);
  EXPECT_EQ(info.height, 128);
  EXPECT_EQ(info.bits, 8);
  EXPECT_EQ(info.frame_count, 6);
  EXPECT_EQ(info.first_number, -85);
  EXPECT_EQ(*info.time_base.rate_hz, 100);
  EXPECT_DOUBLE_EQ(*info.exposure_s, 3e-3);
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(source->time_s(k), k / 100.0, 2e-9);
}

TEST_F(RealCineTest, TwelveInSixteenBits) {
  const auto source = open("phantom_v611_raw_16bpp.cine");
  const SourceInfo& info = source->info();
  EXPECT_EQ(info.bits, 12);
  EXPECT_EQ(info.frame_count, 6);
  EXPECT_EQ(info.first_number, 151325);
  EXPECT_EQ(*info.time_base.rate_hz, 2000);
  EXPECT_DOUBLE_EQ(*info.exposure_s, 1e-4);
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(source->time_s(k), k / 2000.0, 2e-9);
  EXPECT_NEAR(mean(source->read(0)), 554.170, 1e-3);
}

TEST_F(RealCineTest, PackedTenBits) {
  const auto source = open("packed_12bpp.cine");
  EXPECT_EQ(source->info().bits, 12);
  EXPECT_EQ(source->info().first_number, 60);
  EXPECT_EQ(*source->info().time_base.rate_hz, 100);
  EXPECT_DOUBLE_EQ(*source->info().exposure_s, 99e-6);
  EXPECT_EQ(source->info().trigger_time, "2015-07-24T15:55:38.229863Z");

  const auto other = open("twente_p10_235frames.cine");
  EXPECT_EQ(other->info().width, 256);
  EXPECT_EQ(other->info().height, 32);
  EXPECT_EQ(other->info().frame_count, 235);
  for (int k = 0; k < 234; ++k) EXPECT_NEAR(other->time_s(k), k / 100.0, 1e-6);
  // Its last image was stamped 292 days later and is blank: kept, and said.
  EXPECT_THAT(other->info().notes, ::testing::Contains(HasSubstr("image 234")));
  EXPECT_TRUE(other->info().exposures_s.empty()) << "that image's exposure has no say";
}

TEST_F(CineSourceTest, ImagesMayLieInAnyOrder) {
  CineByHand cine;
  FileBytes bytes = cine.bytes();
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t i = 0; i < 8; ++i)
      bytes[cine.table + 8 * k + i] = static_cast<std::uint8_t>(cine.positions[2 - k] >> (8 * i));
  write_bytes(file("a.cine"), bytes);
  const auto source = open_source(file("a.cine"));
  EXPECT_EQ(source->read(0).at(0, 3), 100);
  EXPECT_EQ(source->read(2).at(0, 3), 0);
}

TEST_F(CineSourceTest, AnAnnotationEndsBeforeTheNextImage) {
  CineByHand cine;
  FileBytes bytes = cine.bytes();
  bytes[cine.positions[1]] = 9;  // one byte more than the image before it leaves
  write_bytes(file("a.cine"), bytes);
  const auto source = open_source(file("a.cine"));
  source->read(0);
  EXPECT_THAT(input_error(file("a.cine")),
              AllOf(HasSubstr("annotation of image -84 claims 9 bytes"), HasSubstr("8 to 8")));
}

}  // namespace
}  // namespace tribotrack::vision
