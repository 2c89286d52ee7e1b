#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <string>

#include "vision/formats/libav/libav.h"
#include "vision/io/files.h"
#include "vision/io/levels.h"
#include "vision/temporary_file.h"

namespace tribotrack::vision {
namespace {

struct Coding {
  const char* encoder;
  AVPixelFormat pixels;
};

class LibavSink : public FrameSink {
 public:
  LibavSink(const std::filesystem::path& path, const SinkOptions& options)
      : options_(options), temporary_(path) {
    silence_libav();
    open_output();
    open_encoder();
    write_header();
    frame_->format = encoder_->pix_fmt;
    frame_->width = options.width;
    frame_->height = options.height;
    if (const int error = av_frame_get_buffer(frame_.get(), 0); error < 0) fail(error);
  }

  void write(const Picture& picture) override {
    require_size(options_, picture.width(), picture.height());
    make_writable();
    for (int y = 0; y < options_.height; ++y)
      store_levels(picture.row(y), options_.bits,
                   frame_->data[0] + static_cast<std::ptrdiff_t>(y) * frame_->linesize[0]);
    for (int plane = 1; plane < 3 && frame_->data[plane]; ++plane)
      for (int y = 0; y < (options_.height + 1) / 2; ++y)
        std::memset(frame_->data[plane] + static_cast<std::ptrdiff_t>(y) * frame_->linesize[plane], 128,
                    static_cast<std::size_t>((options_.width + 1) / 2));
    encode_frame();
  }

  void write_rgb(int width, int height, const unsigned char* rgb) override {
    require_size(options_, width, height);
    if (!frame_->data[1])
      refuse(temporary_.target(),
             "cannot hold colour in this coding: choose .mp4 or .avi with even width and height, or .png");
    make_writable();
    store_as_yuv(rgb);
    encode_frame();
  }

  void close() override {
    if (count_ == 0) refuse(temporary_.target(), "would hold no frames; nothing was written");
    avcodec_send_frame(encoder_.get(), nullptr);
    write_packets();
    if (const int error = av_write_trailer(output_.get()); error < 0) fail(error);
    if (const int error = avio_closep(&output_->pb); error < 0) fail(error);
    output_.reset();
    temporary_.commit();
  }

 private:
  [[noreturn]] void fail(int error) const { temporary_.refuse(libav_error(error)); }
  AVStream& stream() const { return *output_->streams[0]; }

  /// Containers lie about rates or round them, so the capture rate goes along in the tag that cameras use.
  void write_header() {
    const std::string rate = fmt::format("{:.9g}", options_.frame_rate_hz);
    av_dict_set(&output_->metadata, "com.android.capture.fps", rate.c_str(), 0);
    AVDictionary* muxing = nullptr;
    if (std::string_view(output_->oformat->name) == "mp4")
      av_dict_set(&muxing, "movflags", "use_metadata_tags", 0);
    const int error = avformat_write_header(output_.get(), &muxing);
    av_dict_free(&muxing);
    if (error < 0) fail(error);
  }

  Coding coding() const {
    const bool odd = options_.width % 2 != 0 || options_.height % 2 != 0;
    if (options_.codec != Codec::ffv1 && options_.bits != 8)
      refuse(temporary_.target(), "cannot hold {} bits in this coding: choose .mkv (FFV1) or .cine",
             options_.bits);
    if (options_.codec == Codec::mjpeg) return {"mjpeg", AV_PIX_FMT_YUVJ420P};
    if (options_.codec == Codec::h264) return {"libx264", odd ? AV_PIX_FMT_GRAY8 : AV_PIX_FMT_YUV420P};
    switch (options_.bits) {
      case 8:
        return {"ffv1", AV_PIX_FMT_GRAY8};
      case 10:
        return {"ffv1", AV_PIX_FMT_GRAY10LE};
      case 12:
        return {"ffv1", AV_PIX_FMT_GRAY12LE};
      default:
        refuse(temporary_.target(), "cannot hold {} bits: 8, 10 or 12 can be written", options_.bits);
    }
  }

  void open_output() {
    const std::string extension = temporary_.target().extension().string();
    const char* muxer = extension == ".avi"                          ? "avi"
                        : extension == ".mp4" || extension == ".mov" ? "mp4"
                                                                     : "matroska";
    AVFormatContext* context = nullptr;
    if (const int error = avformat_alloc_output_context2(&context, nullptr, muxer, nullptr); error < 0)
      fail(error);
    output_.reset(context);
    // The same frames give the same bytes: no dates, no random identities.
    context->flags |= AVFMT_FLAG_BITEXACT;
    const std::string url = "file:" + temporary_.path().string();
    if (const int error = avio_open(&context->pb, url.c_str(), AVIO_FLAG_WRITE); error < 0) fail(error);
  }

  void open_encoder() {
    const Coding chosen = coding();
    const AVCodec* codec = avcodec_find_encoder_by_name(chosen.encoder);
    if (!codec)
      refuse(temporary_.target(), "cannot be written: this libav has no encoder '{}'; choose another coding",
             chosen.encoder);
    encoder_.reset(avcodec_alloc_context3(codec));
    const AVRational rate = av_d2q(options_.frame_rate_hz, 1000000);
    encoder_->width = options_.width;
    encoder_->height = options_.height;
    encoder_->pix_fmt = chosen.pixels;
    encoder_->time_base = av_inv_q(rate);
    encoder_->framerate = rate;
    encoder_->color_range = AVCOL_RANGE_JPEG;
    encoder_->thread_count = 1;  // encoders with more threads may give other bytes
    encoder_->flags |= AV_CODEC_FLAG_BITEXACT;
    if (output_->oformat->flags & AVFMT_GLOBALHEADER) encoder_->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    if (options_.codec == Codec::mjpeg) {
      encoder_->flags |= AV_CODEC_FLAG_QSCALE;
      encoder_->global_quality = 2 * FF_QP2LAMBDA;
    } else if (options_.codec == Codec::h264) {
      av_opt_set(encoder_->priv_data, "preset", "veryfast", 0);
      // Weighted prediction gives other bytes for the same frames now and then.
      av_opt_set_int(encoder_->priv_data, "weightp", 0, 0);
      av_opt_set(encoder_->priv_data, "crf", std::to_string(options_.crf).c_str(), 0);
      encoder_->max_b_frames = 0;  // frames are stored in the order shown
    } else {
      encoder_->level = 3;
      av_opt_set_int(encoder_->priv_data, "slicecrc", 1, 0);
      encoder_->gop_size = 1;
    }
    if (const int error = avcodec_open2(encoder_.get(), codec, nullptr); error < 0) fail(error);

    AVStream* video = avformat_new_stream(output_.get(), nullptr);
    if (!video) fail(AVERROR(ENOMEM));
    video->time_base = encoder_->time_base;
    video->avg_frame_rate = rate;
    video->r_frame_rate = rate;
    if (const int error = avcodec_parameters_from_context(video->codecpar, encoder_.get()); error < 0)
      fail(error);
  }

  void make_writable() {
    if (const int error = av_frame_make_writable(frame_.get()); error < 0) fail(error);
  }

  void encode_frame() {
    frame_->pts = count_++;
    frame_->quality = encoder_->global_quality;
    if (const int error = avcodec_send_frame(encoder_.get(), frame_.get()); error < 0) fail(error);
    write_packets();
  }

  void write_packets() {
    while (avcodec_receive_packet(encoder_.get(), packet_.get()) == 0) {
      packet_->stream_index = 0;
      packet_->duration = 1;
      // AVI beyond 1000 Hz gets a time base too coarse to distinguish frames: there timestamps count frames.
      const bool coarse = av_cmp_q(stream().time_base, encoder_->time_base) > 0;
      if (!coarse || (output_->oformat->flags & AVFMT_TS_NONSTRICT))
        av_packet_rescale_ts(packet_.get(), encoder_->time_base, stream().time_base);
      if (const int error = av_interleaved_write_frame(output_.get(), packet_.get()); error < 0) fail(error);
    }
  }

  /// Full-range BT.601 (as JPEG has it), chroma averaged over two by two pixels.
  void store_as_yuv(const unsigned char* rgb) {
    const cv::Mat colour(options_.height, options_.width, CV_8UC3, const_cast<unsigned char*>(rgb));
    cv::Mat ycc;
    cv::cvtColor(colour, ycc, cv::COLOR_RGB2YCrCb);
    const cv::Size half((options_.width + 1) / 2, (options_.height + 1) / 2);
    constexpr int kPlane[] = {0, 2, 1};  // of Y, Cr, Cb
    for (int channel = 0; channel < 3; ++channel) {
      const int plane = kPlane[channel];
      cv::Mat levels, stored(plane == 0 ? colour.size() : half, CV_8U, frame_->data[plane],
                             static_cast<std::size_t>(frame_->linesize[plane]));
      cv::extractChannel(ycc, levels, channel);
      cv::resize(levels, stored, stored.size(), 0, 0, cv::INTER_AREA);
    }
  }

  SinkOptions options_;
  TemporaryFile temporary_;
  LibavOutput output_;
  LibavCoder encoder_;
  LibavFrame frame_{there(av_frame_alloc())};
  LibavPacket packet_{there(av_packet_alloc())};
  std::int64_t count_ = 0;
};

}  // namespace

std::unique_ptr<FrameSink> create_libav_sink(const std::filesystem::path& path, const SinkOptions& options) {
  return std::make_unique<LibavSink>(path, options);
}

}  // namespace tribotrack::vision
