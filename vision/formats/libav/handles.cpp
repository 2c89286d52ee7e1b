#include "vision/formats/libav/handles.h"

#include <cstdarg>
#include <cstdio>
#include <mutex>
#include <new>
#include <utility>

#include "vision/formats/libav/library.h"

namespace tribotrack::vision {
namespace {

thread_local std::string last_complaint;

void keep_complaint(void*, int level, const char* format, va_list arguments) {
  if (level > AV_LOG_ERROR) return;
  char line[512];
  std::vsnprintf(line, sizeof line, format, arguments);
  std::string text = line;
  while (!text.empty() && (text.back() == '\n' || text.back() == '.')) text.pop_back();
  if (!text.empty()) last_complaint = text;
}

}  // namespace

void LibavDelete::operator()(AVCodecContext* context) const {
  libav().avcodec_free_context(&context);
}
void LibavDelete::operator()(AVFrame* frame) const {
  libav().av_frame_free(&frame);
}
void LibavDelete::operator()(AVPacket* packet) const {
  libav().av_packet_free(&packet);
}
void LibavCloseInput::operator()(AVFormatContext* context) const {
  libav().avformat_close_input(&context);
}
void LibavCloseOutput::operator()(AVFormatContext* context) const {
  if (context->pb) libav().avio_closep(&context->pb);
  libav().avformat_free_context(context);
}

LibavFrame make_libav_frame() {
  LibavFrame frame(libav().av_frame_alloc());
  if (!frame) throw std::bad_alloc();
  return frame;
}

LibavPacket make_libav_packet() {
  LibavPacket packet(libav().av_packet_alloc());
  if (!packet) throw std::bad_alloc();
  return packet;
}

void silence_libav() {
  static std::once_flag once;
  std::call_once(once, [] { libav().av_log_set_callback(keep_complaint); });
}

std::string libav_error(int code) {
  char text[AV_ERROR_MAX_STRING_SIZE] = "";
  libav().av_strerror(code, text, sizeof text);
  std::string message = code == AVERROR_INVALIDDATA ? "its content is damaged" : text;
  if (const std::string complaint = take_libav_complaint(); !complaint.empty())
    message += " (" + complaint + ")";
  return message;
}

std::string take_libav_complaint() {
  return std::exchange(last_complaint, {});
}

}  // namespace tribotrack::vision
