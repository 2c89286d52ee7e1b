#include "vision/frame_sink.h"

#include <cmath>
#include <stdexcept>

#include "vision/formats/cine/sink.h"
#include "vision/formats/libav/sink.h"
#include "vision/formats/pictures/sink.h"
#include "vision/io/in_quotes.h"
#include "vision/io/sink_levels.h"

namespace tribotrack::vision {
namespace {

Codec codec_by_name(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  if (extension == ".cine") return Codec::cine;
  if (extension == ".mkv") return Codec::ffv1;
  if (extension == ".avi") return Codec::mjpeg;
  if (extension == ".mp4" || extension == ".mov") return Codec::h264;
  if (extension == ".png") return Codec::png;
  if (extension == ".tif" || extension == ".tiff") return Codec::tiff;
  throw InputError(in_quotes(path) +
                   " has no extension of a recording format: use .cine, .mkv, .avi, .mp4, "
                   "%05d.png or %05d.tif");
}

}  // namespace

void require_size(const SinkOptions& options, int width, int height) {
  if (width != options.width || height != options.height)
    throw std::invalid_argument("a picture of " + std::to_string(width) + " x " + std::to_string(height) +
                                " pixels for a recording of " + std::to_string(options.width) + " x " +
                                std::to_string(options.height));
}

std::unique_ptr<FrameSink> create_sink(const std::filesystem::path& path, const SinkOptions& given) {
  SinkOptions options = given;
  if (options.codec == Codec::automatic) options.codec = codec_by_name(path);
  if (options.width <= 0 || options.height <= 0)
    throw InputError(in_quotes(path) + " cannot be written: a picture of " + std::to_string(options.width) +
                     " x " + std::to_string(options.height) + " pixels has no area");
  if (!(options.frame_rate_hz > 0) || !std::isfinite(options.frame_rate_hz))
    throw InputError(in_quotes(path) + " cannot be written: the frame rate must be a positive number");
  switch (options.codec) {
    case Codec::cine:
      return create_cine_sink(path, options);
    case Codec::png:
    case Codec::tiff:
      return create_picture_sink(path, options);
    default:
      return create_libav_sink(path, options);
  }
}

}  // namespace tribotrack::vision
