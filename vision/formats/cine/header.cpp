#include "vision/formats/cine/cine.h"
#include "vision/formats/cine/layout.h"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>
#include <string>

#include "vision/io/files.h"
#include "vision/picture.h"

namespace tribotrack::vision {
namespace {

using Bytes = std::span<const std::uint8_t>;
namespace at = cine_layout;

/// 0 where the block ends before it.
template <typename Number>
Number field(Bytes block, std::size_t offset) {
  return offset + sizeof(Number) > block.size() ? Number{} : load<Number>(block, offset);
}

void read_bitmap(const MappedFile& file, Bytes bitmap, CineHeader& header) {
  const auto width = load<std::int32_t>(bitmap, at::bitmap_width);
  const auto height = load<std::int32_t>(bitmap, at::bitmap_height);
  require_sensible_size(file.path(), width, std::abs(std::int64_t{height}));  // below 0: top row first
  header.width = width;
  header.height = height < 0 ? -height : height;

  const auto bits = load<std::uint16_t>(bitmap, at::bitmap_bits);
  const auto packing = load<std::uint32_t>(bitmap, at::bitmap_packing);
  const auto pixels = static_cast<std::size_t>(header.width) * static_cast<std::size_t>(header.height);
  if (packing == at::packed_10 || packing == at::packed_12_linear) {
    header.packing = packing == at::packed_10 ? CinePacking::p10 : CinePacking::p12l;
    header.top_down = true;
    header.bits = 12;
    header.image_bytes = packing == at::packed_10 ? p10_bytes(pixels) : p12l_bytes(pixels);
    return;
  }
  if (packing != at::unpacked)
    refuse(file.path(),
           "packs its pixels in a form (biCompression {}) that is not known here; export it as uncompressed "
           ".cine or TIFF",
           packing);
  if (bits != 8 && bits != 16 && bits != 24 && bits != 48)
    refuse(file.path(),
           "is damaged or of an unknown kind: {} bits per pixel, where 8, 16, 24 or 48 are known; export "
           "it as TIFF",
           bits);
  header.bgr = bits > 16;
  header.level_bytes = bits % 16 == 0 ? 2 : 1;
  header.top_down = height < 0;
  header.bits = 8 * header.level_bytes;
  // Rows of a bitmap end on whole 32-bit words; a writer that forgot that shows in the image's size.
  const std::uint64_t tight = static_cast<std::uint64_t>(header.width) * bits / 8;
  const std::uint64_t padded = (tight + 3) / 4 * 4;
  const auto stated = load<std::uint32_t>(bitmap, at::bitmap_image_bytes);
  const auto rows = static_cast<std::uint64_t>(header.height);
  header.row_bytes = stated >= tight * rows && stated < padded * rows ? tight : padded;
  header.image_bytes = header.row_bytes * rows;
}

int significant_bits(const CineHeader& header, std::uint32_t real_bits, std::uint32_t levels) {
  if (header.packing != CinePacking::none || header.level_bytes == 1) return header.bits;
  if (real_bits >= 8 && real_bits <= 16) return static_cast<int>(real_bits);
  if (levels > 256 && levels <= 65536 && std::has_single_bit(levels)) return std::countr_zero(levels);
  return 16;
}

void refuse_colour_mosaic(const MappedFile& file, std::uint16_t compression, std::uint32_t filter) {
  if (compression == at::lead_jpeg)
    refuse(file.path(),
           "holds JPEG pictures (LEAD), which are not read; export it as uncompressed .cine or TIFF");
  if (compression != at::grey_or_rgb && compression != at::colour_mosaic)
    refuse(file.path(),
           "is compressed in a form (Compression {}) that is not known here; export it as uncompressed .cine "
           "or TIFF",
           compression);
  if (compression == at::colour_mosaic)
    refuse(file.path(),
           "is a raw recording of a colour camera (colour filter mosaic, type {}): neighbouring pixels see "
           "different colours, so it is not a grey picture and nothing is measured in it; export it from the "
           "camera's program as grey .cine or as TIFF",
           filter);
}

/// Walks the tagged blocks for the images' time stamps and exposures.
void read_tagged_blocks(const MappedFile& file, std::uint64_t begin, std::uint64_t end, std::size_t count,
                        CineHeader& header) {
  while (begin + at::block_head_bytes <= end) {
    const Bytes head = file.bytes(begin, at::block_head_bytes, "a tagged block");
    const auto size = load<std::uint32_t>(head, 0);
    const auto type = load<std::uint16_t>(head, 4);
    if (size < at::block_head_bytes || size > end - begin)
      refuse(file.path(), "is damaged: the tagged block at byte {} claims {} bytes; copy the recording again",
             begin, size);
    const Bytes body = file.bytes(begin, size, "a tagged block").subspan(at::block_head_bytes);
    if (type == at::time_block && body.size() >= count * sizeof(CineTime)) {
      header.stamps.resize(count);
      for (std::size_t i = 0; i < count; ++i)
        header.stamps[i] = load<CineTime>(body, i * sizeof(CineTime)) & cine_time_mask;
    }
    if (type == at::exposure_block && body.size() >= count * sizeof(std::uint32_t)) {
      header.exposures_s.resize(count);
      for (std::size_t i = 0; i < count; ++i)
        header.exposures_s[i] = load<std::uint32_t>(body, i * sizeof(std::uint32_t)) * 0x1p-32;
      if (!header.exposure_s) header.exposure_s = header.exposures_s.front();
    }
    begin += size;
  }
}

constexpr std::uint64_t least_annotation = 8;

std::string image_name(const CineHeader& header, std::size_t index) {
  return "image " + std::to_string(header.first_image_number + static_cast<std::int64_t>(index)) + " (" +
         std::to_string(index + 1) + " of " + std::to_string(header.image_offsets.size()) + ")";
}

void read_image_table(const MappedFile& file, std::uint64_t position, std::uint32_t count, bool wide,
                      CineHeader& header) {
  const std::uint64_t entry = wide ? 8 : 4;
  const Bytes table =
      file.bytes(position, entry * count, "the table of " + std::to_string(count) + " images");
  header.image_offsets.resize(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint64_t offset =
        wide ? load<std::uint64_t>(table, i * entry) : load<std::uint32_t>(table, i * entry);
    const std::uint64_t needed = least_annotation + header.image_bytes;
    if (offset < at::file_header_bytes || offset > file.size() || needed > file.size() - offset)
      refuse(file.path(),
             "is cut short or damaged: {} should take bytes {} to {}, but the file has {}; copy or save the "
             "recording again",
             image_name(header, i), offset, offset + needed, file.size());
    header.image_offsets[i] = offset;
  }
}

/// Bytes of the head, with what they are.
struct Stretch {
  std::uint64_t begin = 0, length = 0;
  const char* what = "";
};

/// Images may lie in any order, but no two in the same bytes, nor in those of the head.
void give_images_room(const MappedFile& file, std::span<const Stretch> head, CineHeader& header) {
  const std::vector<std::uint64_t>& offsets = header.image_offsets;
  const std::uint64_t needed = least_annotation + header.image_bytes;
  std::vector<std::size_t> order(offsets.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return offsets[i]; });
  header.image_rooms.resize(offsets.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::size_t i = order[k];
    for (const Stretch& part : head)
      if (offsets[i] < part.begin + part.length && part.begin < offsets[i] + needed)
        refuse(file.path(), "is damaged: {} at byte {} lies in {}; copy or save the recording again",
               image_name(header, i), offsets[i], part.what);
    const bool last = k + 1 == order.size();
    header.image_rooms[i] = (last ? file.size() : offsets[order[k + 1]]) - offsets[i];
    if (header.image_rooms[i] < needed)
      refuse(file.path(), "is damaged: {} and {} share bytes from {} on; copy or save the recording again",
             image_name(header, i), image_name(header, order[k + 1]), offsets[order[k + 1]]);
  }
}

}  // namespace

CineHeader read_cine_header(const MappedFile& file) {
  CineHeader header;
  const Bytes head = file.bytes(0, at::file_header_bytes, "the .cine header");
  if (head[0] != 'C' || head[1] != 'I')
    refuse(file.path(),
           "is not a Phantom .cine (it does not begin with 'CI'); check the file and its extension");
  const auto version = load<std::uint16_t>(head, at::version);
  if (version > 1)
    refuse(file.path(), "is a .cine of version {}, but only 0 and 1 are known; export it as TIFF", version);
  const auto header_size = load<std::uint16_t>(head, at::header_size);
  if (header_size != at::file_header_bytes)
    refuse(file.path(),
           "has a header of {} bytes, but only one of {} is known: it is damaged or of another kind of "
           ".cine; copy it again, or export it as TIFF",
           header_size, at::file_header_bytes);
  const auto count = load<std::uint32_t>(head, at::image_count);
  if (count == 0) refuse(file.path(), "holds no image (its header counts 0); save the recording again");
  header.first_image_number = load<std::int32_t>(head, at::first_image_number);
  header.trigger = load<CineTime>(head, at::trigger_time) & cine_time_mask;

  const auto bitmap_position = load<std::uint32_t>(head, at::bitmap_offset);
  const Bytes bitmap = file.bytes(bitmap_position, at::bitmap_bytes, "the bitmap header");
  if (const auto size = load<std::uint32_t>(bitmap, 0); size != at::bitmap_bytes)
    refuse(file.path(),
           "has a bitmap header of {} bytes, but only one of {} is known: it is damaged or of another kind "
           "of .cine; copy it again, or export it as TIFF",
           size, at::bitmap_bytes);
  const auto setup_position = load<std::uint32_t>(head, at::setup_offset);
  const Bytes setup_head = file.bytes(setup_position, at::setup_length + 2, "the setup block");
  const bool marked = load<std::uint16_t>(setup_head, at::setup_mark) == at::setup_mark_value;
  const auto length = marked ? load<std::uint16_t>(setup_head, at::setup_length) : at::setup_mark;
  if (length < at::setup_mark)
    refuse(file.path(),
           "is damaged: its setup block claims {} bytes, less than what every one holds; copy the recording "
           "again",
           length);
  const Bytes setup = file.bytes(setup_position, length, "the setup block");

  refuse_colour_mosaic(file, load<std::uint16_t>(head, at::compression),
                       field<std::uint32_t>(setup, at::colour_filter));
  read_bitmap(file, bitmap, header);
  header.bits = significant_bits(header, field<std::uint32_t>(setup, at::real_bits),
                                 load<std::uint32_t>(bitmap, at::bitmap_levels));
  header.short_rate = field<std::uint16_t>(setup, at::short_rate);
  header.integer_rate = field<std::uint32_t>(setup, at::integer_rate);
  header.camera_version = field<std::uint32_t>(setup, at::camera_version);
  header.colour_filter = field<std::uint32_t>(setup, at::colour_filter) != 0;
  header.shown_mirrored = field<std::uint32_t>(setup, at::flip_horizontal) != 0 ||
                          field<std::uint32_t>(setup, at::flip_vertical) != 0;
  const auto black = field<std::int32_t>(setup, at::black_level),
             white = field<std::int32_t>(setup, at::white_level);
  if (white > black && black >= 0 && white <= 65535) {
    header.black_level = black;
    header.white_level = white;
  }
  if (const auto exposure = field<std::uint32_t>(setup, at::exposure_ns); exposure > 0)
    header.exposure_s = exposure * 1e-9;

  const auto table = load<std::uint32_t>(head, at::image_table_offset);
  read_image_table(file, table, count, version == 1, header);
  const std::array<Stretch, 4> head_parts = {
      {{0, at::file_header_bytes, "the file header"},
       {bitmap_position, at::bitmap_bytes, "the bitmap header"},
       {setup_position, length, "the setup block"},
       {table, std::uint64_t{count} * (version == 1 ? 8 : 4), "the table of images"}}};
  give_images_room(file, head_parts, header);
  if (marked) read_tagged_blocks(file, setup_position + length, table, count, header);
  return header;
}

}  // namespace tribotrack::vision
