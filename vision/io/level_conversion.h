// Stored pixels to grey levels, a row at a time.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>

namespace tribotrack::vision {

/// Luma of ITU-R BT.601 in integers, so that a grey stored in colour comes back exactly.
constexpr float luma(std::uint32_t red, std::uint32_t green, std::uint32_t blue) {
  return static_cast<float>((19595.0 * red + 38470.0 * green + 7471.0 * blue) / 65536.0);
}

/// In the processor's widest vectors: most of what tracking in an uncompressed recording spends on reading.
void copy_levels(const std::uint8_t* stored, std::span<float> levels);

/// 16-bit little-endian words at any address.
inline std::uint16_t word_at(const std::uint8_t* stored, std::size_t i) {
  std::uint16_t word;
  std::memcpy(&word, stored + 2 * i, sizeof word);
  return word;
}

inline void copy_levels_16(const std::uint8_t* stored, std::span<float> levels) {
  for (std::size_t i = 0; i < levels.size(); ++i) levels[i] = static_cast<float>(word_at(stored, i));
}

inline void luma_of_bgr(const std::uint8_t* stored, std::span<float> levels) {
  for (std::size_t i = 0; i < levels.size(); ++i)
    levels[i] = luma(stored[3 * i + 2], stored[3 * i + 1], stored[3 * i]);
}

inline void luma_of_bgr_16(const std::uint8_t* stored, std::span<float> levels) {
  for (std::size_t i = 0; i < levels.size(); ++i)
    levels[i] = luma(word_at(stored, 3 * i + 2), word_at(stored, 3 * i + 1), word_at(stored, 3 * i));
}

}  // namespace tribotrack::vision
