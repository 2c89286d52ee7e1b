// Where the fields of a Phantom .cine file lie: byte offsets, all little endian.
#pragma once

#include <cstddef>
#include <cstdint>

namespace tribotrack::vision::cine_layout {

// File header, at 0.
inline constexpr std::size_t file_header_bytes = 44;
inline constexpr std::size_t header_size = 0x02, compression = 0x04, version = 0x06;
inline constexpr std::size_t first_movie_image = 0x08, total_image_count = 0x0C;
inline constexpr std::size_t first_image_number = 0x10, image_count = 0x14;
inline constexpr std::size_t bitmap_offset = 0x18, setup_offset = 0x1C, image_table_offset = 0x20;
inline constexpr std::size_t trigger_time = 0x24;

// Compression.
inline constexpr std::uint16_t grey_or_rgb = 0, lead_jpeg = 1, colour_mosaic = 2;

// Bitmap header, offsets within it.
inline constexpr std::size_t bitmap_bytes = 40;
inline constexpr std::size_t bitmap_width = 4, bitmap_height = 8, bitmap_planes = 12, bitmap_bits = 14;
inline constexpr std::size_t bitmap_packing = 16, bitmap_image_bytes = 20;
inline constexpr std::size_t bitmap_pels_per_metre = 24, bitmap_levels = 36;
inline constexpr std::uint32_t unpacked = 0, packed_10 = 256, packed_12_linear = 1024;

// Setup block, offsets within it; a field exists only inside the block's own length.
inline constexpr std::size_t short_rate = 0x00, setup_mark = 0x8C, setup_length = 0x8E;
inline constexpr std::uint16_t setup_mark_value = 0x5453;  // "ST"
inline constexpr std::size_t flip_horizontal = 0x2F4, flip_vertical = 0x2F8;
inline constexpr std::size_t integer_rate = 0x300, camera_version = 0x318, colour_filter = 0x328;
inline constexpr std::size_t real_bits = 0x380, exposure_ns = 0x620;
inline constexpr std::size_t black_level = 0x1664, white_level = 0x1668, playback_rate = 0x1B40;
inline constexpr std::size_t recorded_bits = 0x2780;
inline constexpr std::size_t modern_setup_bytes = 10392;

// Tagged blocks between the setup block and the image table: u32 size with this head, u16 type, u16 reserved.
inline constexpr std::size_t block_head_bytes = 8;
inline constexpr std::uint16_t time_block = 1002, exposure_block = 1003;

}  // namespace tribotrack::vision::cine_layout
