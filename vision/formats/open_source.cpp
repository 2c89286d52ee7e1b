#include "vision/frame_source.h"

#include <algorithm>
#include <opencv2/core/utility.hpp>

#include "vision/formats/cine/source.h"
#include "vision/formats/libav/source.h"
#include "vision/formats/pictures/source.h"
#include "vision/io/in_quotes.h"
#include "vision/io/mapped_file.h"

namespace tribotrack::vision {
namespace {

void refuse_bare_pixels(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  if (extension == ".mraw" || extension == ".cih" || extension == ".cihx")
    throw InputError(
        in_quotes(path) +
        " belongs to a Photron recording of bare pixels (.mraw), which is not read; save it from the "
        "camera's program as AVI or TIFF and keep the .cih or .cihx beside it for the capture rate");
}

}  // namespace

std::unique_ptr<FrameSource> open_source(const std::filesystem::path& path, const SourceOptions& options) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) return open_picture_sequence(path, pictures_in_folder(path), options);
  if (!fs::exists(path, ignored)) {
    if (const auto pattern = NumberPattern::parse(path))
      return open_picture_sequence(path, pictures_of_pattern(*pattern), options);
  }
  require_readable_file(path);
  refuse_bare_pixels(path);
  if (looks_like_cine(path) || path.extension() == ".cine") return open_cine(path, options);
  if (has_picture_extension(path)) return open_picture_stack(path, options);
  return open_libav(path, options);
}

void keep_to_calling_thread() {
  cv::setNumThreads(1);
}

}  // namespace tribotrack::vision
