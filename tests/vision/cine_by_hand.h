// A .cine file put together byte by byte, without any of the program's own code.
#pragma once

#include <cstdint>
#include <vector>

namespace tribotrack::vision {

struct CineByHand {
  int version = 1;
  int compression = 0;
  int width = 8, height = 4;
  int bits_per_pixel = 8;
  std::uint32_t packing = 0;
  std::int32_t first_image = -85;
  std::uint32_t images = 3;
  std::uint32_t rate = 2000, short_rate = 100, colour_filter = 0, real_bits = 8;
  std::uint32_t exposure_ns = 100000;
  std::uint16_t setup_length = 10392;
  bool mark = true, stamps = true;
  std::uint32_t image_bytes = 32;
  std::uint32_t annotation = 8;

  std::int32_t black_level = 0, white_level = 0;
  std::vector<std::uint64_t> stamps_64ths;  ///< instead of the quarters of a second, in 1/64 s
  std::vector<std::uint32_t> exposures;     ///< of each image, in 2^-32 s

  // Filled by bytes():
  std::uint32_t table = 0;
  std::vector<std::uint64_t> positions;

  /// Byte i of image k is (k * 50 + i) mod 256.
  std::vector<std::uint8_t> bytes() {
    std::vector<std::uint8_t> file;
    const auto put = [&](std::uint64_t at, std::uint64_t value, int count) {
      if (file.size() < at + static_cast<std::uint64_t>(count))
        file.resize(at + static_cast<std::uint64_t>(count));
      for (int i = 0; i < count; ++i)
        file[at + static_cast<std::uint64_t>(i)] = static_cast<std::uint8_t>(value >> (8 * i));
    };
    const std::uint32_t setup = 84;
    put(0, 0x4943, 2);
    put(2, 44, 2);
    put(4, static_cast<std::uint64_t>(compression), 2);
    put(6, static_cast<std::uint64_t>(version), 2);
    put(0x10, static_cast<std::uint32_t>(first_image), 4);
    put(0x14, images, 4);
    put(0x18, 44, 4);
    put(0x1C, setup, 4);
    put(0x24, 0x80000003, 4);  // half a second and both flags
    put(0x28, 1000000000, 4);  // 2001-09-09T01:46:40Z
    put(0x2C, 40, 4);
    put(0x30, static_cast<std::uint32_t>(width), 4);
    put(0x34, static_cast<std::uint32_t>(height), 4);
    put(0x38, 1, 2);
    put(0x3A, static_cast<std::uint64_t>(bits_per_pixel), 2);
    put(0x3C, packing, 4);
    put(0x40, image_bytes, 4);
    put(setup + setup_length - 1u, 0, 1);
    put(setup, short_rate, 2);
    if (mark) put(setup + 0x8C, 0x5453, 2), put(setup + 0x8E, setup_length, 2);
    const auto put_inside = [&](std::uint32_t at, std::uint32_t value) {
      if (at + 4 <= setup_length) put(setup + at, value, 4);
    };
    put_inside(0x300, rate);
    put_inside(0x328, colour_filter);
    put_inside(0x380, real_bits);
    put_inside(0x620, exposure_ns);
    put_inside(0x1664, static_cast<std::uint32_t>(black_level));
    put_inside(0x1668, static_cast<std::uint32_t>(white_level));
    std::uint64_t next = file.size();
    if (stamps) {
      put(next, 8 + 8 * images, 4);
      put(next + 4, 1002, 2);
      put(next + 6, 1, 2);
      // A quarter of a second apart from 2001-09-09T01:46:39.75 on, flags set.
      for (std::uint32_t k = 0; k < images; ++k) {
        const std::uint64_t quarters = 1000000000ull * 4 - 1 + k;
        const std::uint64_t stamp =
            stamps_64ths.empty() ? quarters << 30 : (1000000000ull << 32) + (stamps_64ths[k] << 26);
        put(next + 8 + 8 * k, stamp | 1, 8);
      }
      next = file.size();
    }
    if (!exposures.empty()) {
      put(next, 8 + 4 * images, 4);
      put(next + 4, 1003, 2);
      put(next + 6, 1, 2);
      for (std::uint32_t k = 0; k < images; ++k) put(next + 8 + 4 * k, exposures[k], 4);
      next = file.size();
    }
    table = static_cast<std::uint32_t>(next);
    put(0x20, table, 4);
    const std::uint64_t entry = version == 1 ? 8 : 4;
    put(next + entry * images - 1, 0, 1);
    for (std::uint32_t k = 0; k < images; ++k) {
      const std::uint64_t position = file.size();
      positions.push_back(position);
      put(table + entry * k, position, static_cast<int>(entry));
      put(position, annotation, 4);
      put(position + annotation - 4, image_bytes, 4);
      for (std::uint32_t i = 0; i < image_bytes; ++i) put(position + annotation + i, (k * 50 + i) & 0xFF, 1);
    }
    return file;
  }
};

}  // namespace tribotrack::vision
