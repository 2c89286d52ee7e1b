#include "vision/formats/pictures/pictures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "vision/recordings.h"

namespace tribotrack::vision {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class PictureSourceTest : public RecordingTest {};

/// A grey PGM, whose whole description is three numbers in its head.
FileBytes pgm(int width, int height, std::uint8_t first) {
  std::string head = "P5\n";
  head += std::to_string(width) + " " + std::to_string(height) + "\n255\n";
  FileBytes bytes(head.begin(), head.end());
  for (int i = 0; i < width * height; ++i) bytes.push_back(static_cast<std::uint8_t>(first + i));
  return bytes;
}

/// An uncompressed little-endian 16-bit grey TIFF of several pages, put together by hand.
FileBytes tiff_16(int width, int height, int pages) {
  FileBytes file = {'I', 'I', 42, 0, 0, 0, 0, 0};
  const auto put = [&](std::uint32_t value, int count) {
    for (int i = 0; i < count; ++i) file.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  };
  std::size_t link = 4;
  for (int page = 0; page < pages; ++page) {
    const auto pixels = static_cast<std::uint32_t>(file.size());
    for (int i = 0; i < width * height; ++i) put(static_cast<std::uint32_t>(1000 * page + 7 * i), 2);
    const auto directory = static_cast<std::uint32_t>(file.size());
    for (std::size_t i = 0; i < 4; ++i) file[link + i] = static_cast<std::uint8_t>(directory >> (8 * i));
    const std::uint32_t entries[][3] = {{256, 4, static_cast<std::uint32_t>(width)},
                                        {257, 4, static_cast<std::uint32_t>(height)},
                                        {258, 3, 16},
                                        {259, 3, 1},
                                        {262, 3, 1},
                                        {273, 4, pixels},
                                        {277, 3, 1},
                                        {278, 4, static_cast<std::uint32_t>(height)},
                                        {279, 4, static_cast<std::uint32_t>(2 * width * height)}};
    put(9, 2);
    for (const auto& entry : entries) put(entry[0], 2), put(entry[1], 2), put(1, 4), put(entry[2], 4);
    link = file.size();
    put(0, 4);
  }
  return file;
}

TEST_F(PictureSourceTest, ASequenceHasItsNumbersAndNoRateOfItsOwn) {
  for (int k = 0; k < 4; ++k)
    write_bytes(file(std::to_string(98 + k) + ".pgm"), pgm(6, 5, static_cast<std::uint8_t>(10 * k)));
  for (const auto& path : {file(""), file("%d.pgm")}) {
    const auto source = open_source(path);
    EXPECT_EQ(source->info().width, 6);
    EXPECT_EQ(source->info().height, 5);
    EXPECT_EQ(source->info().bits, 8);
    EXPECT_EQ(source->info().frame_count, 4);
    EXPECT_EQ(source->info().first_number, 98);
    EXPECT_FALSE(source->info().time_base.known());
    EXPECT_THAT(source->info().time_base.why_unknown(), HasSubstr("--fps"));
    Picture part;
    source->read(3, {2, 1, 3, 4}, part);
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < 3; ++x) EXPECT_EQ(part.at(x, y), 30 + (y + 1) * 6 + x + 2);
  }
  EXPECT_EQ(open_source(file(""), {.frame_rate_hz = 50.0})->time_s(3), 0.06);
}

TEST_F(PictureSourceTest, AFrameOfAnotherSizeIsNamed) {
  write_bytes(file("f1.pgm"), pgm(6, 5, 0));
  write_bytes(file("f2.pgm"), pgm(5, 6, 0));
  EXPECT_THAT(input_error(file("")), AllOf(HasSubstr("f2.pgm"), HasSubstr("5 x 6"), HasSubstr("6 x 5")));
}

TEST_F(PictureSourceTest, ADamagedPictureIsNamed) {
  write_bytes(file("f1.pgm"), pgm(6, 5, 0));
  write_bytes(file("f2.pgm"), {'n', 'o'});
  EXPECT_THAT(input_error(file("")), AllOf(HasSubstr("f2.pgm"), HasSubstr("cannot be decoded")));
  write_bytes(file("f2.pgm"), {});
  EXPECT_THAT(input_error(file("")), AllOf(HasSubstr("f2.pgm"), HasSubstr("empty")));
}

TEST_F(PictureSourceTest, PagesOfAStackInAnyOrder) {
  write_bytes(file("a.tif"), tiff_16(7, 3, 45));
  const auto source = open_source(file("a.tif"));
  EXPECT_EQ(source->info().format, "tiff stack");
  EXPECT_EQ(source->info().bits, 16);
  ASSERT_EQ(source->info().frame_count, 45);
  for (const int page : {0, 1, 2, 44, 20, 3, 19, 44, 0}) {
    const Picture picture = source->read(page);
    for (int y = 0; y < 3; ++y)
      for (int x = 0; x < 7; ++x) ASSERT_EQ(picture.at(x, y), 1000 * page + 7 * (y * 7 + x)) << page;
  }
}

TEST(RealPictures, MechanismAndSpeckle) {
  if (real_data().empty()) GTEST_SKIP() << "TRIBOTRACK_REAL_DATA names no folder";
  const auto mechanism = open_source(real_data() / "mechanism");
  EXPECT_EQ(mechanism->info().frame_count, 56);
  EXPECT_EQ(mechanism->info().first_number, 4870);
  EXPECT_EQ(mechanism->info().width, 640);
  EXPECT_EQ(mechanism->info().height, 480);
  const auto speckle = open_source(real_data() / "dic_sample5" / "Sample5 Reference.tif");
  EXPECT_EQ(speckle->info().frame_count, 1);
  EXPECT_EQ(speckle->info().bits, 8);
}

}  // namespace
}  // namespace tribotrack::vision
