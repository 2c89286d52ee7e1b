#include "vision/formats/cine/cine.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace tribotrack::vision {
namespace {

/// Bit by bit, most significant first.
std::uint32_t bits_at(const std::vector<std::uint8_t>& bytes, std::size_t first, std::size_t count) {
  std::uint32_t value = 0;
  for (std::size_t bit = first; bit < first + count; ++bit)
    value = value << 1 | (bytes[bit / 8] >> (7 - bit % 8) & 1U);
  return value;
}

std::vector<std::uint8_t> random_bytes(std::size_t count) {
  constexpr unsigned seed = 20210401;
  std::mt19937 random(seed);
  std::vector<std::uint8_t> bytes(count);
  for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random() & 0xFF);
  return bytes;
}

TEST(P10, UnpacksEveryRunLikeBitByBitReading) {
  constexpr std::size_t pixels = 43;
  const auto packed = random_bytes(p10_bytes(pixels));
  for (std::size_t first = 0; first < pixels; ++first)
    for (std::size_t count = 0; first + count <= pixels; ++count) {
      std::vector<float> levels(count);
      unpack_p10(packed, first, levels);
      for (std::size_t i = 0; i < count; ++i)
        ASSERT_EQ(levels[i], p10_linear_levels[bits_at(packed, (first + i) * 10, 10)])
            << first << " " << count;
    }
}

TEST(P12L, UnpacksEveryRunLikeBitByBitReading) {
  constexpr std::size_t pixels = 21;
  const auto packed = random_bytes(p12l_bytes(pixels));
  for (std::size_t first = 0; first < pixels; ++first) {
    std::vector<float> levels(pixels - first);
    unpack_p12l(packed, first, levels);
    for (std::size_t i = 0; i < levels.size(); ++i)
      ASSERT_EQ(levels[i], static_cast<float>(bits_at(packed, (first + i) * 12, 12)));
  }
}

TEST(P10, CurveHasItsPublishedPoints) {
  EXPECT_EQ(p10_linear_levels[0], 2);
  EXPECT_EQ(p10_linear_levels[64], 64);      // black
  EXPECT_EQ(p10_linear_levels[1014], 4064);  // white
  EXPECT_EQ(p10_linear_levels[1023], 4095);
  for (std::size_t code = 1; code < 1024; ++code)
    EXPECT_GE(p10_linear_levels[code], p10_linear_levels[code - 1]);
}

}  // namespace
}  // namespace tribotrack::vision
