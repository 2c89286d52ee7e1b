#include "vision/io/picture_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "vision/recordings.h"

namespace tribotrack::vision {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class StatedSizeTest : public RecordingTest {
 protected:
  std::string refusal_of(const FileBytes& bytes, const std::string& name = "a.png") {
    write_bytes(file(name), bytes);
    try {
      require_decodable_picture(file(name));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
};

FileBytes of(const std::string& text) {
  return FileBytes(text.begin(), text.end());
}

std::string big(std::uint32_t value, int bytes) {
  std::string text;
  for (int i = bytes; i-- > 0;) text += static_cast<char>(std::uint64_t{value} >> std::min(63, 8 * i));
  return text;
}

std::string little(std::uint32_t value, int bytes) {
  std::string text = big(value, bytes);
  return std::string(text.rbegin(), text.rend());
}

FileBytes png(std::uint32_t width, std::uint32_t height) {
  return of("\x89PNG\r\n\x1a\n" + big(13, 4) + "IHDR" + big(width, 4) + big(height, 4) + big(0, 20));
}

FileBytes bmp(std::uint32_t width, std::uint32_t height) {
  return of("BM" + std::string(12, '\0') + little(40, 4) + little(width, 4) + little(height, 4) +
            std::string(28, '\0'));
}

FileBytes jpeg(std::uint32_t width, std::uint32_t height) {
  return of("\xFF\xD8\xFF\xE0" + big(4, 2) + "ab" + "\xFF\xFF\xC2" + big(11, 2) + "\x08" + big(height, 2) +
            big(width, 2) + "\x01" + big(0, 8));
}

FileBytes pgm(std::uint32_t width, std::uint32_t height) {
  return of("P5 # made by hand\n" + std::to_string(width) + "\n" + std::to_string(height) + " 255\n....");
}

FileBytes tiff(std::uint32_t width, std::uint32_t height, std::uint32_t tile = 0) {
  std::string text = "II" + little(42, 2) + little(8, 4) + little(4, 2);
  for (const auto& [tag, value] : {std::pair{256u, width}, {257u, height}, {322u, tile}, {323u, tile}})
    text += little(tag, 2) + little(4, 2) + little(1, 4) + little(value, 4);
  return of(text + little(0, 4));
}

TEST_F(StatedSizeTest, EveryKindStatesItsSize) {
  for (const auto picture : {png, bmp, jpeg, pgm}) {
    EXPECT_EQ(refusal_of(picture(160, 120)), "");
    EXPECT_THAT(refusal_of(picture(65535, 65535)),
                AllOf(HasSubstr("65535 x 65535"), HasSubstr("damaged or too large"), HasSubstr("copy")));
    EXPECT_THAT(refusal_of(picture(0, 240)), HasSubstr("0 x 240"));
    EXPECT_THAT(refusal_of(picture(8000, 8000)), AllOf(HasSubstr("8000 x 8000"), HasSubstr("has only")))
        << "64 million pixels out of a hundred bytes";
  }
  EXPECT_EQ(refusal_of(tiff(320, 240)), "");
  EXPECT_THAT(refusal_of(tiff(65535, 65535)), HasSubstr("65535 x 65535"));
  EXPECT_THAT(refusal_of(tiff(320, 240, 1 << 20)), HasSubstr("1048576 x 1048576")) << "a tile";
  EXPECT_THAT(refusal_of(bmp(320, 0x80000000)), HasSubstr("320 x 2147483648")) << "top row first";
}

TEST_F(StatedSizeTest, WhatOpenCvWouldReadByOtherDecodersIsRefused) {
  for (const char* head : {"#?RADIANCE\n\n-Y 8 +X 8\n", "\x59\xA6\x6A\x95 sun raster", "RIFF....WEBPVP8 ",
                           "NITF02.10 of GDAL", "v/1\x01 OpenEXR", "P7\nWIDTH 8\n", "...."})
    EXPECT_THAT(refusal_of(of(head)), AllOf(HasSubstr("neither PNG"), HasSubstr("a.png"))) << head;
}

TEST_F(StatedSizeTest, AHeadCutShortIsRefused) {
  for (const auto picture : {png, bmp, jpeg})
    for (const std::size_t length : {4u, 9u, 14u}) {
      FileBytes bytes = picture(320, 240);
      bytes.resize(length);
      EXPECT_NE(refusal_of(bytes), "") << length;
    }
  EXPECT_THAT(refusal_of(of("P5 320")), HasSubstr("before it states its size"));
}

TEST_F(StatedSizeTest, ASourceAsksBeforeItDecodes) {
  write_bytes(file("a.png"), png(65535, 65535));
  EXPECT_THAT(input_error(file("a.png")), HasSubstr("65535 x 65535"));
  std::filesystem::create_directory(file("frames"));
  write_bytes(file("frames/1.png"), png(65535, 65535));
  EXPECT_THAT(input_error(file("frames")), HasSubstr("65535 x 65535"));
}

/// A chain of pages with one entry each, classic or large, in either byte order.
FileBytes chain(int pages, bool large, bool big_endian) {
  FileBytes file;
  const auto put = [&](std::uint64_t value, int count) {
    for (int i = 0; i < count; ++i)
      file.push_back(static_cast<std::uint8_t>(value >> (8 * (big_endian ? count - 1 - i : i))));
  };
  file.assign(2, big_endian ? 'M' : 'I');
  put(large ? 43 : 42, 2);
  if (large) put(8, 2), put(0, 2);
  const std::uint64_t link = large ? 8 : 4, page_bytes = large ? 36 : 18;
  const std::uint64_t first = file.size() + link;
  put(first, static_cast<int>(link));
  for (int page = 1; page <= pages; ++page) {
    put(1, large ? 8 : 2);
    file.resize(file.size() + (large ? 20 : 12));
    put(page < pages ? first + page_bytes * static_cast<std::uint64_t>(page) : 0, static_cast<int>(link));
  }
  return file;
}

class TiffPagesTest : public RecordingTest {
 protected:
  std::string refusal() {
    try {
      count_tiff_pages(file("a.tif"));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
};

TEST_F(TiffPagesTest, EveryFormCountsItsChainAndNoticesACut) {
  for (const bool large : {false, true})
    for (const bool big_endian : {false, true}) {
      const FileBytes whole = chain(5, large, big_endian);
      write_bytes(file("a.tif"), whole);
      EXPECT_EQ(count_tiff_pages(file("a.tif")), 5) << large << big_endian;
      for (std::size_t length = 0; length < whole.size(); ++length) {
        write_bytes(file("a.tif"),
                    FileBytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length)));
        ASSERT_THAT(refusal(), HasSubstr("a.tif")) << length;
      }
    }
}

TEST_F(TiffPagesTest, ARingIsDamageNotForever) {
  FileBytes bytes = chain(2, false, false);
  bytes[bytes.size() - 4] = 8;  // the last page leads back to the first
  write_bytes(file("a.tif"), bytes);
  EXPECT_THAT(refusal(), HasSubstr("circular"));
}

TEST_F(TiffPagesTest, NoTiff) {
  write_bytes(file("a.tif"), FileBytes(20, 'x'));
  EXPECT_THAT(refusal(), HasSubstr("not a TIFF"));
}

TEST_F(TiffPagesTest, DirectoriesThatOverlapAreDamage) {
  // Each page of 200 entries begins four bytes after the one before it.
  FileBytes bytes = {'I', 'I', 42, 0, 8, 0, 0, 0};
  bytes.resize(6000);
  for (std::size_t page = 8; page < 1000; page += 4) {
    bytes[page] = 200;
    const std::size_t link = page + 2 + 200 * 12, next = page + 4;
    bytes[link] = static_cast<std::uint8_t>(next);
    bytes[link + 1] = static_cast<std::uint8_t>(next >> 8);
  }
  write_bytes(file("a.tif"), bytes);
  EXPECT_THAT(refusal(), HasSubstr("shares bytes with others"));
}

}  // namespace
}  // namespace tribotrack::vision
