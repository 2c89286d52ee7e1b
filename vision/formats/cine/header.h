// The header of a Phantom .cine file.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "vision/io/files.h"

namespace tribotrack::vision {

/// How the pixels of a .cine lie in the file. grey16: 10, 12, 14 or 16 bits, right-aligned in 16.
enum class CinePixels { grey8, grey16, p10, p12l, bgr24, bgr48 };

/// Time of day as the camera writes it: whole seconds since 1970 above, fractions of 2^-32 s below; the two
/// lowest bits are flags and are cleared here.
using CineTime = std::uint64_t;
constexpr CineTime cine_time_mask = ~CineTime{3};

struct CineHeader {
  int width = 0, height = 0;
  CinePixels pixels = CinePixels::grey8;
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

}  // namespace tribotrack::vision
