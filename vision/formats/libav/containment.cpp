#include "vision/formats/libav/containment.h"

#include <mutex>
#include <new>
#include <string_view>
#include <vector>

#include "vision/formats/libav/library.h"
#include "vision/io/picture_size.h"

namespace tribotrack::vision {
namespace {

constexpr unsigned kMostStreams = 64;
constexpr std::size_t kLargestAllocation = std::size_t{1} << 30;

int interrupted(void* deadline) {
  return static_cast<const Deadline*>(deadline)->passed() ? 1 : 0;
}

void limit_memory() {
  static std::once_flag once;
  std::call_once(once, [] { libav().av_max_alloc(kLargestAllocation); });
}

}  // namespace

bool is_coding_read(const std::string& decoder_name) {
  return ("," + std::string(kCodings) + ",").find("," + decoder_name + ",") != std::string::npos;
}

AVFormatContext* contained_input(const Deadline& deadline) {
  limit_memory();
  AVFormatContext* input = libav().avformat_alloc_context();
  if (!input) throw std::bad_alloc();
  libav().av_opt_set(input, "protocol_whitelist", "file", 0);
  libav().av_opt_set(input, "format_whitelist", kContainers, 0);
  libav().av_opt_set(input, "codec_whitelist", kCodings, 0);
  input->max_streams = kMostStreams;
  input->interrupt_callback = {interrupted, const_cast<Deadline*>(&deadline)};
  return input;
}

int find_contained_streams(AVFormatContext& input) {
  std::vector<AVDictionary*> options(input.nb_streams, nullptr);
  for (AVDictionary*& of_stream : options)
    libav().av_dict_set(&of_stream, "max_pixels", std::to_string(kMostPixels).c_str(), 0);
  const int error = libav().avformat_find_stream_info(&input, options.data());
  for (AVDictionary*& of_stream : options) libav().av_dict_free(&of_stream);
  return error;
}

void contain(AVCodecContext& decoder) {
  decoder.max_pixels = kMostPixels;
  libav().av_opt_set(&decoder, "codec_whitelist", kCodings, 0);
}

}  // namespace tribotrack::vision
