// libav: its headers, ownership of its objects, its complaints, what of it a recording can reach, and whether
// a file has been cut short.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <new>
#include <optional>
#include <string>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/display.h>
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
}

#include "vision/frame_sink.h"
#include "vision/frame_source.h"
#include "vision/io/levels.h"
#include "vision/picture.h"

namespace tribotrack::vision {

// What the rest of the house sees: anything libav decodes as a source of frames, at its native depth.

/// All packets are listed at opening without decoding them, so that frame_count is what the file holds and
/// frame k is the k-th shown; a file cut short is an InputError there, a damaged frame one at read(). Luma is
/// handed out as stored, RGB as 0.299 R + 0.587 G + 0.114 B.
std::unique_ptr<FrameSource> open_libav(const std::filesystem::path& path, const SourceOptions& options);

/// FFV1 (lossless; 8, 10 or 12 bits; .mkv or .avi), MJPEG (8 bits; .avi or .mkv), H.264 (8 bits; .mp4, .mkv).
/// The time base is one over the frame rate, which MP4 keeps exactly. Matroska rounds timestamps to 1 ms and
/// keeps the rate beside them. AVI as libav writes it states 600 Hz for all rates beyond 1000 Hz, which no
/// reader here believes: such a recording needs --fps. MJPEG and H.264 hold luma in full range with neutral
/// chroma.
std::unique_ptr<FrameSink> create_libav_sink(const std::filesystem::path& path, const SinkOptions& options);

// Ownership, and complaints.

/// By a function of libav's that takes the pointer's address.
template <auto kFree>
struct LibavDelete {
  template <class Object>
  void operator()(Object* object) const {
    kFree(&object);
  }
};
struct LibavCloseOutput {
  void operator()(AVFormatContext* context) const {
    if (context->pb) avio_closep(&context->pb);
    avformat_free_context(context);
  }
};

using LibavCoder = std::unique_ptr<AVCodecContext, LibavDelete<avcodec_free_context>>;
using LibavFrame = std::unique_ptr<AVFrame, LibavDelete<av_frame_free>>;
using LibavPacket = std::unique_ptr<AVPacket, LibavDelete<av_packet_free>>;
using LibavInput = std::unique_ptr<AVFormatContext, LibavDelete<avformat_close_input>>;
using LibavOutput = std::unique_ptr<AVFormatContext, LibavCloseOutput>;

/// Throws std::bad_alloc instead of a null pointer.
template <class Object>
Object* there(Object* object) {
  if (!object) throw std::bad_alloc();
  return object;
}

/// From now on libav prints nothing; the last error it would have printed on this thread is kept instead.
void silence_libav();
/// The last error libav complained of on this thread since the previous call of this or libav_error.
std::string take_libav_complaint();
/// libav's word for an error code, with the last complaint kept since the previous call.
std::string libav_error(int code);

// What of libav a recording can reach, and how much it may use there.

/// libav has hundreds of demuxers and decoders, and a file's bytes choose among them. These are the ones that
/// recordings to be measured come in; no other is run. In libav's names, separated by commas.
/// MP4/MOV, AVI, Matroska/WebM, MPEG transport and program streams, WMV, Y4M, and the bare streams of three
/// codings.
inline constexpr const char* kContainers = "mov,avi,matroska,mpegts,mpeg,asf,yuv4mpegpipe,h264,hevc,mjpeg";
/// What cameras and phones write; what editing programs write; what is lossless.
inline constexpr const char* kCodings =
    "h264,hevc,mjpeg,mpeg4,mpeg2video,mpeg1video,h263,msmpeg4,wmv1,wmv2,wmv3,vc1,dvvideo,vp8,vp9,libdav1d,"
    "av1,"
    "prores,dnxhd,cfhd,"
    "rawvideo,ffv1,huffyuv,ffvhuff,utvideo,magicyuv,lagarith,v210,v410,png,qtrle";
/// For messages.
inline constexpr const char* kContainersInWords =
    "MP4 and MOV, AVI, Matroska and WebM, MPEG, WMV, Y4M, bare H.264, HEVC and MJPEG";
inline constexpr const char* kRemedyConvert = "convert it, for instance `ffmpeg -i IN -c:v ffv1 OUT.mkv`";

/// Frames: hours at any rate; the list of them takes 40 bytes each.
inline constexpr std::size_t kMostPackets = std::size_t{1} << 24;
/// Bytes in all packets of a file of `file_bytes`. A demuxer that hands out many times what the file holds
/// has been sent round in circles; edit lists show a part twice, no more.
constexpr std::uint64_t most_packet_bytes(std::uint64_t file_bytes) {
  return 4 * file_bytes + (std::uint64_t{16} << 20);
}

bool is_coding_read(const std::string& decoder_name);

/// A new context for avformat_open_input that reads local files of kContainers only. No single
/// allocation of libav exceeds 1 GiB from then on, in the whole process.
AVFormatContext* contained_input();

/// avformat_find_stream_info, with pictures no larger than vision/io/files.h allows.
int find_contained_streams(AVFormatContext& input);

/// The same limit, and kCodings only. Before avcodec_open2.
void contain(AVCodecContext& decoder);

// Has a video file been cut short?

/// The byte at which a Matroska file ends by its own account, or kUnfinished where its writer never came to
/// fill that in; nothing for other files. libav plays a file cut short without complaint, and where Matroska
/// is cut, unlike MP4 and AVI, no table tells of the frames that are gone. Throws InputError where it ends
/// before its segment begins.
inline constexpr std::uint64_t kUnfinished = ~std::uint64_t{0};
std::optional<std::uint64_t> matroska_end(const std::filesystem::path& path);

// Grey levels out of libav's pictures.

/// The luma plane of a decoded frame; where luma is computed, or unpacked, it is in `computed`.
StoredFrame stored_levels(const AVFrame& frame, Picture& computed);

// What libav tells of the coder that made a recording.
//
// Quantiser steps in coefficients of an orthonormal transform, grey levels:
//   H.264   0.625 2^(QP / 6)                     (ITU-T H.264 8.5.9, with QP'_Y for more than 8 bits)
//   MPEG-4  2 q, which is what libav hands out (mpegvideo_dec.c, ff_mpv_export_qp_table)
//   MJPEG   the table's entry; here the median of those of the lowest ten frequencies, which hold an edge
// HEVC, VP9 and AV1 tell neither steps nor blocks.

/// Asks the decoder for quantisers and motion vectors, where its coding is a lossy one. Before avcodec_open2.
void ask_for_coding(AVCodecContext& decoder);

/// From the first frame decoded. Nothing where the coding is lossless, by its kind or by its settings.
std::optional<Coder> coder_of(const AVCodecContext& decoder, const AVFrame& first, const CodedFrame& coded);

/// `table_step` of the packet, see jpeg_step.
CodedFrame coded_frame_of(const AVCodecContext& decoder, const AVFrame& frame, float table_step);

/// Of a JPEG picture's first quantisation table; 0 where it has none.
float jpeg_step(const AVPacket& packet);

}  // namespace tribotrack::vision
