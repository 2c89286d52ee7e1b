// What libav's frames hold: grey levels, and how the coder made them.
#pragma once

#include <optional>
#include <string>

#include "vision/frame_source.h"
#include "vision/picture.h"

struct AVFrame;
struct AVCodecContext;
struct AVPacket;

namespace tribotrack::vision {

// Grey levels out of libav's pictures.

struct LibavPixelForm {
  std::string name;
  int bits = 0;         ///< of the levels handed out
  bool colour = false;  ///< chroma or RGB stored
  bool rgb = false;     ///< luma computed here
};

/// What a libav pixel format (AVPixelFormat as int) holds. Throws std::invalid_argument with a clause for the
/// user where no grey level is defined (colour mosaic, hardware surfaces, floating point).
LibavPixelForm libav_pixel_form(int format);

/// The window of a decoded frame: the luma plane as stored, or luma computed from RGB.
void copy_libav_window(const AVFrame& frame, const Rect& window, Picture& picture);

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
