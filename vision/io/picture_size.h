// How large a picture may be.
#pragma once

#include <cstdint>
#include <filesystem>

namespace tribotrack::vision {

/// Several times what any high-speed camera films. A file that states more is damaged, or made to exhaust the
/// memory.
inline constexpr std::int64_t kLongestSide = 32768;
inline constexpr std::int64_t kMostPixels = std::int64_t{1} << 26;

/// Throws InputError, before anything of that size is allocated.
void require_sensible_size(const std::filesystem::path& file, std::int64_t width, std::int64_t height);
/// Also where a packed picture is larger than that many bytes can hold, however they are packed.
void require_sensible_size(const std::filesystem::path& file, std::int64_t width, std::int64_t height,
                           std::uint64_t file_bytes);

}  // namespace tribotrack::vision
