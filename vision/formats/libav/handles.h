// Ownership of libav's objects, and its complaints.
#pragma once

#include <memory>
#include <string>

struct AVCodecContext;
struct AVFormatContext;
struct AVFrame;
struct AVPacket;

namespace tribotrack::vision {

struct LibavDelete {
  void operator()(AVCodecContext* context) const;
  void operator()(AVFrame* frame) const;
  void operator()(AVPacket* packet) const;
};
struct LibavCloseInput {
  void operator()(AVFormatContext* context) const;
};
struct LibavCloseOutput {
  void operator()(AVFormatContext* context) const;
};

using LibavDecoder = std::unique_ptr<AVCodecContext, LibavDelete>;
using LibavEncoder = std::unique_ptr<AVCodecContext, LibavDelete>;
using LibavFrame = std::unique_ptr<AVFrame, LibavDelete>;
using LibavPacket = std::unique_ptr<AVPacket, LibavDelete>;
using LibavInput = std::unique_ptr<AVFormatContext, LibavCloseInput>;
using LibavOutput = std::unique_ptr<AVFormatContext, LibavCloseOutput>;

LibavFrame make_libav_frame();
LibavPacket make_libav_packet();

/// From now on libav prints nothing; the last error it would have printed on this thread is kept instead.
void silence_libav();
/// The last error libav complained of on this thread since the previous call of this or libav_error.
std::string take_libav_complaint();
/// libav's word for an error code, with the last complaint kept since the previous call.
std::string libav_error(int code);

}  // namespace tribotrack::vision
