// Little-endian numbers in the bytes of a file.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace tribotrack::vision {

static_assert(std::endian::native == std::endian::little, "file readers assume a little-endian machine");

/// The number at `offset`; the bytes must be there.
template <typename Number>
Number load(std::span<const std::uint8_t> bytes, std::size_t offset) {
  Number number;
  std::memcpy(&number, bytes.data() + offset, sizeof number);
  return number;
}

template <typename Number>
void store(std::span<std::uint8_t> bytes, std::size_t offset, Number number) {
  std::memcpy(bytes.data() + offset, &number, sizeof number);
}

}  // namespace tribotrack::vision
