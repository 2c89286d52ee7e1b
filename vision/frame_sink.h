// Writing recordings: .cine, FFV1, MJPEG, H.264, numbered pictures.
//
// Frames are given in order, in linear grey levels 0 .. 2^bits - 1, and rounded to whole ones. A recording
// appears whole under its name or not at all: until close() it is written under a name of its own beside it.
//
//   SinkOptions options{.width = 320, .height = 240, .bits = 12, .frame_rate_hz = 5000};
//   const auto sink = create_sink("run.cine", options);
//   for (const Picture& frame : frames) sink->write(frame);
//   sink->close();
#pragma once

#include <filesystem>
#include <memory>

#include "vision/picture.h"
#include "vision/temporary_file.h"

namespace tribotrack::vision {

enum class Codec { automatic, cine, ffv1, mjpeg, h264, png, tiff };

struct SinkOptions {
  int width = 0;
  int height = 0;
  int bits = 8;  ///< 8, 10 or 12; .cine: 8, or 12 in 16
  double frame_rate_hz = 1000;
  double exposure_s = 0;  ///< .cine header
  /// automatic: by the file's name (.cine; .mkv/.avi -> FFV1/MJPEG; .mp4 -> H.264; %05d.png, %05d.tif)
  Codec codec = Codec::automatic;
  int crf = 18;  ///< H.264 quality
};

/// Takes frames in order. Destroyed without close(), it leaves nothing. A picture of another size than
/// SinkOptions states is a std::invalid_argument, a disk that cannot be written an OutputError.
class FrameSink {
 public:
  virtual ~FrameSink() = default;
  virtual void write(const Picture& picture) = 0;
  /// 8-bit RGB, interleaved; only the video codecs mjpeg and h264 take it (overlays).
  virtual void write_rgb(int width, int height, const unsigned char* rgb);
  virtual void close() = 0;
};

/// Throws InputError where nothing can be written under that name, before any frame has been computed.
std::unique_ptr<FrameSink> create_sink(const std::filesystem::path& path, const SinkOptions& options);

}  // namespace tribotrack::vision
