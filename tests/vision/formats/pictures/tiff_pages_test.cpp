#include "vision/formats/pictures/tiff_pages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "vision/recordings.h"

namespace tribotrack::vision {
namespace {

using ::testing::HasSubstr;

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
