#include "vision/formats/pictures/stated_size.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <optional>
#include <string_view>

#include "vision/formats/pictures/tiff_pages.h"
#include "vision/io/in_quotes.h"
#include "vision/io/little_endian.h"
#include "vision/io/mapped_file.h"
#include "vision/io/picture_size.h"
#include "vision/picture.h"

namespace tribotrack::vision {
namespace {

using Bytes = std::span<const std::uint8_t>;

struct Size {
  std::int64_t width = 0, height = 0;
};

bool begins_with(Bytes bytes, std::string_view mark) {
  return bytes.size() >= mark.size() &&
         std::equal(mark.begin(), mark.end(), bytes.begin(),
                    [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; });
}

std::int64_t big_endian(Bytes bytes, std::size_t offset, std::size_t count) {
  std::int64_t value = 0;
  for (std::size_t i = 0; i < count; ++i) value = value << 8 | bytes[offset + i];
  return value;
}

std::optional<Size> png_size(Bytes bytes) {
  if (bytes.size() < 24) return std::nullopt;
  return Size{big_endian(bytes, 16, 4), big_endian(bytes, 20, 4)};
}

std::optional<Size> bmp_size(Bytes bytes) {
  if (bytes.size() < 26) return std::nullopt;
  if (load<std::uint32_t>(bytes, 14) == 12)  // the oldest kind
    return Size{load<std::uint16_t>(bytes, 18), load<std::uint16_t>(bytes, 20)};
  return Size{load<std::int32_t>(bytes, 18), std::abs(std::int64_t{load<std::int32_t>(bytes, 22)})};
}

/// Segments up to the one that begins a frame.
std::optional<Size> jpeg_size(Bytes bytes) {
  for (std::size_t at = 2; at + 9 <= bytes.size() && bytes[at] == 0xFF;) {
    const std::uint8_t marker = bytes[at + 1];
    if (marker == 0xFF) {  // padding
      ++at;
      continue;
    }
    const bool frame = marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (frame) return Size{big_endian(bytes, at + 7, 2), big_endian(bytes, at + 5, 2)};
    at += 2 + static_cast<std::size_t>(big_endian(bytes, at + 2, 2));
  }
  return std::nullopt;
}

/// "P5 # comment \n 320 240 255 ...".
std::optional<Size> pgm_size(Bytes bytes) {
  std::size_t at = 2;
  const auto number = [&]() -> std::optional<std::int64_t> {
    while (at < bytes.size() && (std::isspace(bytes[at]) != 0 || bytes[at] == '#'))
      if (bytes[at++] == '#')
        while (at < bytes.size() && bytes[at] != '\n') ++at;
    std::int64_t value = 0;
    const std::size_t begin = at;
    for (; at < bytes.size() && std::isdigit(bytes[at]) != 0 && at - begin < 10; ++at)
      value = 10 * value + (bytes[at] - '0');
    return at > begin ? std::optional(value) : std::nullopt;
  };
  const auto width = number(), height = number();
  return width && height ? std::optional(Size{*width, *height}) : std::nullopt;
}

}  // namespace

void require_decodable_picture(const std::filesystem::path& path) {
  const MappedFile file(path);
  const Bytes bytes = file.bytes(0, file.size(), "the picture");
  if (begins_with(bytes, "II") || begins_with(bytes, "MM")) return require_sensible_pages(path);
  std::optional<Size> size;
  if (begins_with(bytes, "\x89PNG\r\n\x1a\n"))
    size = png_size(bytes);
  else if (begins_with(bytes, "BM"))
    size = bmp_size(bytes);
  else if (begins_with(bytes, "\xFF\xD8\xFF"))
    size = jpeg_size(bytes);
  else if (bytes.size() > 2 && bytes[0] == 'P' && bytes[1] >= '1' && bytes[1] <= '6')
    size = pgm_size(bytes);
  else
    throw InputError(in_quotes(path) +
                     " cannot be decoded as a picture: it is neither PNG, TIFF, BMP, JPEG nor PGM; export it "
                     "as one of these");
  if (!size)
    throw InputError(in_quotes(path) +
                     " cannot be decoded as a picture: it ends before it states its size, "
                     "so it is cut short or damaged; copy or export it again");
  require_sensible_size(path, size->width, size->height, file.size());
}

}  // namespace tribotrack::vision
