// Packed pixels of Phantom recordings: P10 (10 bits, companded) and P12L (12 bits, linear).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tribotrack::vision {

/// Pixels are packed without gaps, most significant bit first: four in five bytes (P10), two in three (P12L).
constexpr std::size_t p10_bytes(std::size_t pixels) {
  return (pixels * 10 + 7) / 8;
}
constexpr std::size_t p12l_bytes(std::size_t pixels) {
  return (pixels * 12 + 7) / 8;
}

/// Pixels first .. first + levels.size() - 1 of a packed picture as 12-bit linear levels.
/// `packed` must hold them all.
void unpack_p10(std::span<const std::uint8_t> packed, std::size_t first, std::span<float> levels);
void unpack_p12l(std::span<const std::uint8_t> packed, std::size_t first, std::span<float> levels);

// The companding curve of packed 10-bit Phantom recordings.

/// 12-bit linear level of each of the 1024 codes. The codes follow about the square root of the light, so
/// that shot noise is a constant number of codes: black (linear 64) is code 64, white (linear 4064) code 1014
/// to 1015. Measured facts of the format, on which the open readers agree; never falling.
extern const std::array<std::uint16_t, 1024> p10_linear_levels;

}  // namespace tribotrack::vision
