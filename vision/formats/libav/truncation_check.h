// Has a video file been cut short?
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace tribotrack::vision {

/// Where the outermost boxes of an MP4/MOV, RIFF (AVI) or Matroska file end after their own account. Decoders
/// play a file cut short without complaint, which would silently shorten a measurement.
struct ContainerExtent {
  std::uint64_t stated_end = 0;  ///< byte after the last box
  std::string last_box;          ///< name of the box that ends there
  bool unfinished = false;       ///< its writer never came to fill in the size (Matroska)
};

/// Nothing where the file is none of the three. Does not judge: compare stated_end with the file's size.
std::optional<ContainerExtent> container_extent(const std::filesystem::path& path);

}  // namespace tribotrack::vision
