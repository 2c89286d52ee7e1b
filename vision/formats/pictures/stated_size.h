// What a picture file says of its size, before anything decodes it.
#pragma once

#include <filesystem>

namespace tribotrack::vision {

/// Reads the head of a PNG, TIFF (all pages), BMP, JPEG or PGM. Throws InputError where the size is beyond
/// vision/io/picture_size.h, or more than so few bytes can hold however they are packed, and for files of any
/// other kind: OpenCV would choose among a dozen decoders by the file's own first bytes, whatever its name.
void require_decodable_picture(const std::filesystem::path& file);

}  // namespace tribotrack::vision
