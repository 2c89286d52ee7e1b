// Writing recordings.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "vision/picture.h"

namespace tribotrack::vision {

enum class Codec { automatic, cine, ffv1, mjpeg, h264, png, tiff };

struct SinkOptions {
  int width = 0;
  int height = 0;
  int bits = 8;  ///< 8, 10 or 12; .cine: 8 -> 8 bit, 12 -> 12 in 16, 10 -> P10 (companded on disk)
  double frame_rate_hz = 1000;
  double exposure_s = 0;           ///< .cine header
  Codec codec = Codec::automatic;  ///< automatic: by the file's name (.cine; .mkv/.avi -> FFV1/MJPEG; .mp4 ->
                                   ///< H.264; %05d.png, %05d.tif)
  int crf = 18;                    ///< H.264 quality
};

/// Takes frames in order. The file appears under its name only at close() (a temporary name beside it until
/// then); destroyed without close(), it leaves nothing. Pictures are in linear grey levels 0 .. 2^bits - 1
/// and are rounded.
class FrameSink {
 public:
  virtual ~FrameSink() = default;
  virtual void write(const Picture& picture) = 0;
  /// 8-bit RGB, interleaved; only the video codecs mjpeg and h264 and png take it (overlays).
  virtual void write_rgb(int width, int height, const unsigned char* rgb) = 0;
  virtual void close() = 0;
};

std::unique_ptr<FrameSink> create_sink(const std::filesystem::path& path, const SinkOptions& options);

}  // namespace tribotrack::vision
