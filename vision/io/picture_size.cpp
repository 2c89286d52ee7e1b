#include "vision/io/picture_size.h"

#include <string>

#include "vision/io/in_quotes.h"
#include "vision/picture.h"

namespace tribotrack::vision {

void require_sensible_size(const std::filesystem::path& file, std::int64_t width, std::int64_t height) {
  const bool sides = width > 0 && height > 0 && width <= kLongestSide && height <= kLongestSide;
  if (sides && width * height <= kMostPixels) return;
  throw InputError(in_quotes(file) + " is damaged or too large: it claims a picture of " +
                   std::to_string(width) + " x " + std::to_string(height) + " pixels, where 1 to " +
                   std::to_string(kLongestSide) + " on a side and " + std::to_string(kMostPixels) +
                   " in all are read; copy the recording again, or crop it");
}

void require_sensible_size(const std::filesystem::path& file, std::int64_t width, std::int64_t height,
                           std::uint64_t file_bytes) {
  require_sensible_size(file, width, height);
  constexpr std::uint64_t densest = 2048;  // deflate packs 1032 to 1, LZW somewhat more, JPEG less
  if (static_cast<std::uint64_t>(width * height) / densest > file_bytes)
    throw InputError(in_quotes(file) + " is cut short or damaged: it claims a picture of " +
                     std::to_string(width) + " x " + std::to_string(height) + " pixels, but has only " +
                     std::to_string(file_bytes) + " bytes; copy or export it again");
}

}  // namespace tribotrack::vision
