// Phantom .cine recordings as a source of frames.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "vision/frame_sink.h"
#include "vision/frame_source.h"
#include "vision/io/files.h"

namespace tribotrack::vision {

/// Begins with the mark of a .cine file ("CI" and its header's size)?
bool looks_like_cine(const std::filesystem::path& path);

/// Where its first picture begins, after all tables; 0 where that cannot be read.
std::uint64_t cine_head_bytes(const std::filesystem::path& path);

/// Memory-mapped: reading a window of an unpacked recording touches only the rows of that window. Packed
/// 10-bit pixels are handed out as 12-bit linear levels. Times are the camera's stamp of each image where the
/// file has them, else index / capture rate.
std::unique_ptr<FrameSource> open_cine(const std::filesystem::path& path, const SourceOptions& options);

/// Version 1 (64-bit offsets), laid out as real cameras do: 8 bit and 12 in 16 bottom-up. Images are numbered
/// from 0, stamped k / rate after a fixed date, so that the same frames give the same bytes.
std::unique_ptr<FrameSink> create_cine_sink(const std::filesystem::path& path, const SinkOptions& options);

// The header of a Phantom .cine file.

enum class CinePacking { none, p10, p12l };

/// Time of day as the camera writes it: whole seconds since 1970 above, fractions of 2^-32 s below; the two
/// lowest bits are flags and are cleared here.
using CineTime = std::uint64_t;
constexpr CineTime cine_time_mask = ~CineTime{3};

struct CineHeader {
  int width = 0, height = 0;
  CinePacking packing = CinePacking::none;
  int level_bytes = 1;          ///< unpacked: 10, 12, 14 or 16 bits are right-aligned in 2
  bool bgr = false;             ///< three levels to a pixel
  bool top_down = false;        ///< packed forms are; others are stored with the last row first
  std::uint64_t row_bytes = 0;  ///< from row to row (not for the packed forms, which have no row ends)
  std::uint64_t image_bytes = 0;
  int bits = 8;  ///< significant bits of the levels as handed out
  std::int64_t first_image_number = 0;
  CineTime trigger = 0;
  std::uint32_t integer_rate = 0;  ///< FrameRateInt, 0 where absent
  std::uint32_t short_rate = 0;    ///< FrameRate of old files (16 bit)
  std::optional<double> exposure_s;
  std::uint32_t camera_version = 0;
  bool colour_filter = false;   ///< the camera sees colour, though the file calls its pictures grey
  bool shown_mirrored = false;  ///< the camera's program shows it flipped; the pixels are not
  std::vector<std::uint64_t> image_offsets;     ///< one per stored image
  std::vector<std::uint64_t> image_rooms;       ///< of each, bytes from its offset to what follows it
  std::vector<CineTime> stamps;                 ///< one per stored image, or empty
  std::vector<double> exposures_s;              ///< one per stored image, or empty
  std::optional<int> black_level, white_level;  ///< as stored: of packed 10-bit pictures, codes
};

/// Reads and checks the whole head: every table must lie inside the file, and every image must have room for
/// its pixels that belongs to nothing else; they may lie in any order. Nothing is allocated that the file
/// does not fill. Throws InputError naming what is missing, and for forms that hold no grey picture (colour
/// mosaic, JPEG). Source of the layout: the open readers (FFmpeg, PIMS, pycine, hypercine) and real
/// recordings.
CineHeader read_cine_header(const MappedFile& file);

// Packed pixels of Phantom recordings: P10 (10 bits, companded) and P12L (12 bits, linear).

/// Pixels are packed without gaps, most significant bit first: four in five bytes (P10), two in three (P12L).
constexpr std::size_t p10_bytes(std::size_t pixels) {
  return (pixels * 10 + 7) / 8;
}
constexpr std::size_t p12l_bytes(std::size_t pixels) {
  return (pixels * 12 + 7) / 8;
}

/// Pixels first .. first + levels.size() - 1 of a packed picture as 12-bit linear levels.
/// `packed` must hold them all.
using Unpack = void(std::span<const std::uint8_t> packed, std::size_t first, std::span<float> levels);
Unpack unpack_p10, unpack_p12l;
/// A window of a packed picture, whose size `picture` has.
void unpack(Unpack& row, std::span<const std::uint8_t> packed, int width, const Rect& window,
            Picture& picture);

// The companding curve of packed 10-bit Phantom recordings.

/// 12-bit linear level of each of the 1024 codes. The codes follow about the square root of the light, so
/// that shot noise is a constant number of codes: black (linear 64) is code 64, white (linear 4064) code 1014
/// to 1015. Measured facts of the format, on which the open readers agree; never falling.
extern const std::array<std::uint16_t, 1024> p10_linear_levels;

}  // namespace tribotrack::vision
