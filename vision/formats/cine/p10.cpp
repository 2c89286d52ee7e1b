#include "vision/formats/cine/p10.h"

#include <algorithm>
#include <array>

#include "vision/formats/cine/p10_table.h"

namespace tribotrack::vision {
namespace {

constexpr std::uint32_t code_mask = 0x3FF;

std::uint32_t p10_code_at(std::span<const std::uint8_t> packed, std::size_t pixel) {
  const std::size_t bit = pixel * 10;
  const std::size_t byte = bit / 8;
  const auto pair = static_cast<std::uint32_t>(packed[byte] << 8 | packed[byte + 1]);
  return pair >> (6 - bit % 8) & code_mask;
}

std::array<float, 1024> table_as_float() {
  std::array<float, 1024> table;
  std::copy(p10_linear_levels.begin(), p10_linear_levels.end(), table.begin());
  return table;
}

}  // namespace

void unpack_p10(std::span<const std::uint8_t> packed, std::size_t first, std::span<float> levels) {
  static const std::array<float, 1024> linear = table_as_float();
  std::size_t i = 0;
  for (; i < levels.size() && (first + i) % 4 != 0; ++i) levels[i] = linear[p10_code_at(packed, first + i)];
  const std::uint8_t* group = packed.data() + (first + i) / 4 * 5;
  for (; i + 4 <= levels.size(); i += 4, group += 5) {
    levels[i] = linear[static_cast<std::size_t>(group[0] << 2 | group[1] >> 6)];
    levels[i + 1] = linear[static_cast<std::size_t>((group[1] & 0x3F) << 4 | group[2] >> 4)];
    levels[i + 2] = linear[static_cast<std::size_t>((group[2] & 0x0F) << 6 | group[3] >> 2)];
    levels[i + 3] = linear[static_cast<std::size_t>((group[3] & 0x03) << 8 | group[4])];
  }
  for (; i < levels.size(); ++i) levels[i] = linear[p10_code_at(packed, first + i)];
}

void unpack_p12l(std::span<const std::uint8_t> packed, std::size_t first, std::span<float> levels) {
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const std::size_t pixel = first + i;
    const std::uint8_t* pair = packed.data() + pixel / 2 * 3;
    levels[i] =
        static_cast<float>(pixel % 2 == 0 ? pair[0] << 4 | pair[1] >> 4 : (pair[1] & 0x0F) << 8 | pair[2]);
  }
}

std::uint16_t p10_code(double linear_12bit) {
  const auto above = std::lower_bound(p10_linear_levels.begin(), p10_linear_levels.end(), linear_12bit);
  if (above == p10_linear_levels.begin()) return 0;
  const auto below = above == p10_linear_levels.end() || *above - linear_12bit > linear_12bit - *(above - 1)
                         ? above - 1
                         : above;
  return static_cast<std::uint16_t>(
      std::lower_bound(p10_linear_levels.begin(), p10_linear_levels.end(), *below) -
      p10_linear_levels.begin());
}

void pack_p10(std::span<const std::uint16_t> codes, std::span<std::uint8_t> packed) {
  std::fill(packed.begin(), packed.end(), std::uint8_t{0});
  for (std::size_t i = 0; i < codes.size(); ++i) {
    const std::size_t bit = i * 10;
    const auto pair = static_cast<std::uint32_t>(codes[i] & code_mask) << (6 - bit % 8);
    packed[bit / 8] = static_cast<std::uint8_t>(packed[bit / 8] | pair >> 8);
    packed[bit / 8 + 1] = static_cast<std::uint8_t>(packed[bit / 8 + 1] | (pair & 0xFF));
  }
}

}  // namespace tribotrack::vision
