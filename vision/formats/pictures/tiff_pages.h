// How many pages a TIFF has, and how large they are.
#pragma once

#include <cstdint>
#include <filesystem>

namespace tribotrack::vision {

/// Walks the chain of pages (classic and BigTIFF, either byte order). Decoders stop at a broken link and take
/// what came before for the whole file; here it is an InputError, as is a file that is no TIFF.
std::int64_t count_tiff_pages(const std::filesystem::path& path);

/// Throws InputError where a page, or the tiles it is made of, are larger than vision/io/picture_size.h
/// allows.
void require_sensible_pages(const std::filesystem::path& path);

}  // namespace tribotrack::vision
