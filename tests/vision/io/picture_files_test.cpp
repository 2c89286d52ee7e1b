#include "vision/io/picture_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "vision/recordings.h"

namespace tribotrack::vision {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class PictureKindTest : public RecordingTest {
 protected:
  std::string refusal(const FileBytes& bytes) {
    write_bytes(file("a.png"), bytes);
    return refusal_of([&] { require_decodable_picture(file("a.png")); });
  }
};

FileBytes of(const std::string& text) {
  return FileBytes(text.begin(), text.end());
}

TEST_F(PictureKindTest, WhatOpenCvWouldReadByOtherDecodersIsRefused) {
  for (const char* head : {"#?RADIANCE\n\n-Y 8 +X 8\n", "\x59\xA6\x6A\x95 sun raster", "RIFF....WEBPVP8 ",
                           "NITF02.10 of GDAL", "v/1\x01 OpenEXR", "P7\nWIDTH 8\n", "...."})
    EXPECT_THAT(refusal(of(head)), AllOf(HasSubstr("neither PNG"), HasSubstr("a.png"))) << head;
}

/// A bitmap of zeros: of all kinds the one without a checksum or an end.
FileBytes bmp(std::uint32_t width, std::uint32_t height) {
  FileBytes file(54, 0);
  const auto put = [&](std::size_t at, std::uint32_t value) {
    for (std::size_t i = 0; i < 4; ++i) file[at + i] = static_cast<std::uint8_t>(value >> (8 * i));
  };
  file[0] = 'B', file[1] = 'M', file[26] = 1, file[28] = 24;
  put(10, 54), put(14, 40), put(18, width), put(22, height);
  return file;
}

// Where the library has no limit of its own, as in these tests, what is decoded is judged.
TEST_F(PictureKindTest, SizesBeyondSenseAreRefused) {
  for (const auto& [width, height] : {std::pair{65535u, 65535u}, {40000u, 4u}}) {
    write_bytes(file("a.bmp"), bmp(width, height));
    EXPECT_THAT(input_error(file("a.bmp")), AllOf(HasSubstr("a.bmp"), HasSubstr("crop")));
    std::filesystem::create_directory(file("frames"));
    write_bytes(file("frames/1.bmp"), bmp(width, height));
    EXPECT_THAT(input_error(file("frames")), AllOf(HasSubstr("1.bmp"), HasSubstr("crop")));
  }
}

FileBytes tiff(std::uint32_t width, std::uint32_t height, std::uint32_t tile = 0) {
  FileBytes file{'I', 'I', 42, 0, 8, 0, 0, 0, 4, 0};
  const auto put = [&](std::uint32_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) file.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  };
  for (const auto& [tag, value] : {std::pair{256u, width}, {257u, height}, {322u, tile}, {323u, tile}})
    put(tag, 2), put(4, 2), put(1, 4), put(value, 4);
  put(0, 4);
  return file;
}

TEST_F(PictureKindTest, APageOfATiffStatesItsSize) {
  EXPECT_EQ(refusal(tiff(320, 240)), "");
  EXPECT_THAT(refusal(tiff(65535, 65535)), AllOf(HasSubstr("65535 x 65535"), HasSubstr("copy")));
  EXPECT_THAT(refusal(tiff(8000, 8000)), HasSubstr("has only")) << "64 million pixels out of 62 bytes";
  EXPECT_THAT(refusal(tiff(320, 240, 1 << 20)), HasSubstr("1048576 x 1048576")) << "a tile";
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
    return refusal_of([&] { count_tiff_pages(file("a.tif")); });
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
