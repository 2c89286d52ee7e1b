#include "apps/text/input_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "apps/program.h"
#include "vision/frame_sink.h"
#include "vision/frame_source.h"

namespace tribotrack::apps {
namespace {

constexpr Sampling kSmall{.whole_up_to = 100, .ends = 20, .blocks = 5, .block = 8};

class ContentHashTest : public ProgramTest {
 protected:
  std::filesystem::path write(const std::string& name, const std::string& bytes) const {
    put(in_folder(name), bytes);
    return in_folder(name);
  }
  ContentHash hash(const std::string& bytes, const Sampling& sampling = kSmall) const {
    return hash_of_files({write("a.bin", bytes)}, sampling);
  }
};

std::string example(std::size_t size) {
  std::string bytes(size, ' ');
  for (std::size_t k = 0; k < size; ++k) bytes[k] = static_cast<char>(k * k % 251);
  return bytes;
}

/// Where a change of one byte changes the hash.
template <class Hash>
std::set<std::size_t> seen(const std::string& bytes, const Hash& hash) {
  const std::string before = hash(bytes).xxh3_128;
  std::set<std::size_t> places;
  for (std::size_t k = 0; k < bytes.size(); ++k) {
    std::string other = bytes;
    other[k] ^= 1;
    if (hash(other).xxh3_128 != before) places.insert(k);
  }
  return places;
}

TEST_F(ContentHashTest, SmallFilesAreHashedWhole) {
  const std::string bytes = example(100);
  EXPECT_EQ(hash(bytes).xxh3_128, hash_of_text(bytes));
  EXPECT_EQ(hash(bytes).sampled_bytes, 0);
  // XXH3-128 of nothing, from the reference implementation.
  EXPECT_EQ(hash("").xxh3_128, "99aa06d3014798d86001c324468d497f");
}

TEST_F(ContentHashTest, FilesFollowOneAnother) {
  EXPECT_EQ(hash_of_files({write("1", "one"), write("2", "two")}, kSmall).xxh3_128, hash_of_text("onetwo"));
}

TEST_F(ContentHashTest, OfALargeFileBothEndsAndEveryBlockCount) {
  const std::string bytes = example(200);
  // 20 at both ends and 5 blocks of 8 over the 160 between, whose first bytes are 38 apart.
  std::set<std::size_t> expected;
  for (std::size_t k = 0; k < 20; ++k) expected.insert({k, 199 - k});
  for (std::size_t block = 0; block < 5; ++block)
    for (std::size_t k = 0; k < 8; ++k) expected.insert(20 + 38 * block + k);
  EXPECT_EQ(seen(bytes, [&](const std::string& b) { return hash(b); }), expected);
  EXPECT_EQ(hash(bytes).sampled_bytes, 80);
  EXPECT_EQ(hash(bytes).xxh3_128, hash(bytes).xxh3_128);
}

TEST_F(ContentHashTest, TheTimesOfAllPicturesCount) {
  const auto path = in_folder("a.cine");
  const auto sink = vision::create_sink(path, {.width = 8, .height = 8, .frame_rate_hz = 1000});
  for (int k = 0; k < 50; ++k) sink->write(vision::Picture(8, 8, static_cast<float>(k)));
  sink->close();
  const std::string bytes = content_of(path);
  const std::uint64_t head = vision::bytes_before_pictures(path);
  ASSERT_LT(head, bytes.size() - 50 * 64);
  const Sampling few{.whole_up_to = 100, .ends = 16, .blocks = 2, .block = 8};
  const std::string before = hash(bytes, few).xxh3_128;
  const std::uint64_t tables = 50 * (8 + 4 + 8);  // times, exposures, places
  for (std::uint64_t at = head - tables; at < head; ++at) {
    std::string other = bytes;
    other[at] ^= 1;
    ASSERT_NE(hash(other, few).xxh3_128, before) << at;
  }
}

TEST_F(ContentHashTest, AnInputSaysWhatOfItWasHashed) {
  const auto large = write("large.cine", std::string((32 << 20) + 1, 'a')), small = write("small.cine", "a");
  EXPECT_EQ(hashed_recording(large).hashed, "sample of 18.0 MiB");
  EXPECT_EQ(hashed_recording(small).hashed, "");
  EXPECT_EQ(hashed_input(large).hashed, "");
  EXPECT_NE(hashed_input(large).xxh3_128, hashed_recording(large).xxh3_128);
}

}  // namespace
}  // namespace tribotrack::apps
