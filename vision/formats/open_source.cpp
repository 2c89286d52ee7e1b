#include "vision/frame_source.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <opencv2/core/utility.hpp>
#include <string_view>

#include "vision/formats/cine/source.h"
#include "vision/formats/libav/source.h"
#include "vision/formats/pictures/source.h"
#include "vision/io/in_quotes.h"
#include "vision/io/mapped_file.h"
#include "vision/timing/photron_sidecar.h"

namespace tribotrack::vision {
namespace {

namespace fs = std::filesystem;

/// The pictures of a folder or pattern; nothing where the path names a single file.
std::optional<PictureList> pictures_at(const fs::path& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) return pictures_in_folder(path);
  if (fs::exists(path, ignored)) return std::nullopt;
  const auto pattern = NumberPattern::parse(path);
  return pattern ? std::optional(pictures_of_pattern(*pattern)) : std::nullopt;
}

bool is_cine(const fs::path& path) {
  return looks_like_cine(path) || path.extension() == ".cine";
}

void refuse_bare_pixels(const fs::path& path) {
  const std::string extension = path.extension().string();
  if (extension == ".mraw" || extension == ".cih" || extension == ".cihx")
    throw InputError(
        in_quotes(path) +
        " belongs to a Photron recording of bare pixels (.mraw), which is not read; save it from the "
        "camera's program as AVI or TIFF and keep the .cih or .cihx beside it for the capture rate");
}

/// A table, a campaign, a list of other files: libav would say of it what it is not.
void refuse_text(const fs::path& path) {
  std::array<char, 512> begin;
  std::ifstream stream(path, std::ios::binary);
  stream.read(begin.data(), begin.size());
  const std::string_view head(begin.data(), static_cast<std::size_t>(stream.gcount()));
  const auto is_print = [](char c) { return (c >= ' ' && c <= '~') || (c >= '\t' && c <= '\r'); };
  if (head.empty() || head.starts_with("YUV4MPEG2") || !std::ranges::all_of(head, is_print)) return;
  throw InputError(in_quotes(path) +
                   " is no video that can be read but a text; name a recording, or check the file");
}

}  // namespace

std::unique_ptr<FrameSource> open_source(const fs::path& path, const SourceOptions& options) {
  if (auto pictures = pictures_at(path)) return open_picture_sequence(path, std::move(*pictures), options);
  require_readable_file(path);
  refuse_bare_pixels(path);
  if (is_cine(path)) return open_cine(path, options);
  if (has_picture_extension(path)) return open_picture_stack(path, options);
  refuse_text(path);
  return open_libav(path, options);
}

std::vector<fs::path> files_of_recording(const fs::path& path) {
  if (auto pictures = pictures_at(path)) return std::move(pictures->files);
  require_readable_file(path);
  std::vector<fs::path> files = {path};
  if (!is_cine(path) && !has_picture_extension(path))
    if (const auto sidecar = photron_sidecar(path)) files.push_back(*sidecar);
  return files;
}

std::uint64_t bytes_before_pictures(const fs::path& path) {
  return looks_like_cine(path) ? cine_head_bytes(path) : 0;
}

bool is_number_pattern(const fs::path& path) {
  try {
    return NumberPattern::parse(path).has_value();
  } catch (const InputError&) {
    return false;
  }
}

void keep_to_calling_thread() {
  cv::setNumThreads(1);
}

}  // namespace tribotrack::vision
