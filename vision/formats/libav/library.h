// libav's functions. All calls go through libav(), which loads the libraries when it is first called: the
// program starts without them (vision/io/shared_library.h).
#pragma once

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
}

namespace tribotrack::vision {

// clang-format off
#define TRIBOTRACK_LIBAV_FUNCTIONS(X)                                                                               \
  X(av_d2q) X(av_dict_free) X(av_dict_get) X(av_dict_set)                                                           \
  X(av_frame_alloc) X(av_frame_free) X(av_frame_get_buffer) X(av_frame_get_side_data) X(av_frame_make_writable)     \
  X(av_get_picture_type_char) X(av_log_set_callback) X(av_max_alloc) X(av_opt_set) X(av_opt_set_int) X(av_pix_fmt_desc_get)         \
  X(av_strerror)                                                                                                    \
  X(av_packet_alloc) X(av_packet_free) X(av_packet_rescale_ts) X(av_packet_unref)                                   \
  X(avcodec_alloc_context3) X(avcodec_descriptor_get) X(avcodec_find_encoder_by_name) X(avcodec_flush_buffers)      \
  X(avcodec_free_context) X(avcodec_get_name) X(avcodec_open2) X(avcodec_parameters_from_context)                   \
  X(avcodec_parameters_to_context) X(avcodec_receive_frame) X(avcodec_receive_packet) X(avcodec_send_frame)         \
  X(avcodec_send_packet)                                                                                            \
  X(av_find_best_stream) X(av_interleaved_write_frame) X(av_read_frame) X(av_seek_frame) X(av_write_trailer)        \
  X(avformat_alloc_context) X(avformat_alloc_output_context2) X(avformat_close_input) X(avformat_find_stream_info) X(avformat_free_context)   \
  X(avformat_index_get_entries_count) X(avformat_new_stream) X(avformat_open_input) X(avformat_write_header)        \
  X(avio_closep) X(avio_open)
// clang-format on

/// A pointer to each, of its own name.
struct Libav {
#define TRIBOTRACK_MEMBER(name) decltype(&::name) name = nullptr;  // NOLINT(bugprone-macro-parentheses)
  TRIBOTRACK_LIBAV_FUNCTIONS(TRIBOTRACK_MEMBER)
#undef TRIBOTRACK_MEMBER
};

/// Loaded once, by whichever thread is first. Throws InputError where libav is not installed.
const Libav& libav();

}  // namespace tribotrack::vision
