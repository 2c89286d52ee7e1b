#include "vision/formats/libav/libav.h"

#include <bit>
#include <cctype>
#include <cstdarg>
#include <cstdio>
#include <mutex>
#include <string_view>
#include <utility>
#include <vector>

#include "vision/io/files.h"

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

void silence_libav() {
  static std::once_flag once;
  std::call_once(once, [] { av_log_set_callback(keep_complaint); });
}

std::string libav_error(int code) {
  char text[AV_ERROR_MAX_STRING_SIZE] = "";
  av_strerror(code, text, sizeof text);
  std::string message = code == AVERROR_INVALIDDATA ? "its content is damaged" : text;
  if (const std::string complaint = take_libav_complaint(); !complaint.empty())
    message += " (" + complaint + ")";
  return message;
}

std::string take_libav_complaint() {
  return std::exchange(last_complaint, {});
}

namespace {

constexpr unsigned kMostStreams = 64;
constexpr std::size_t kLargestAllocation = std::size_t{1} << 30;

int interrupted(void* deadline) {
  return static_cast<const Deadline*>(deadline)->passed() ? 1 : 0;
}

void limit_memory() {
  static std::once_flag once;
  std::call_once(once, [] { av_max_alloc(kLargestAllocation); });
}

}  // namespace

bool is_coding_read(const std::string& decoder_name) {
  return ("," + std::string(kCodings) + ",").find("," + decoder_name + ",") != std::string::npos;
}

AVFormatContext* contained_input(const Deadline& deadline) {
  limit_memory();
  AVFormatContext* input = there(avformat_alloc_context());
  av_opt_set(input, "protocol_whitelist", "file", 0);
  av_opt_set(input, "format_whitelist", kContainers, 0);
  av_opt_set(input, "codec_whitelist", kCodings, 0);
  input->max_streams = kMostStreams;
  input->interrupt_callback = {interrupted, const_cast<Deadline*>(&deadline)};
  return input;
}

int find_contained_streams(AVFormatContext& input) {
  std::vector<AVDictionary*> options(input.nb_streams, nullptr);
  for (AVDictionary*& of_stream : options)
    av_dict_set(&of_stream, "max_pixels", std::to_string(kMostPixels).c_str(), 0);
  const int error = avformat_find_stream_info(&input, options.data());
  for (AVDictionary*& of_stream : options) av_dict_free(&of_stream);
  return error;
}

void contain(AVCodecContext& decoder) {
  decoder.max_pixels = kMostPixels;
  av_opt_set(&decoder, "codec_whitelist", kCodings, 0);
}

/// EBML: identity and size are numbers whose first byte states their length; a size of all ones is unknown.
std::optional<std::uint64_t> matroska_end(const std::filesystem::path& path) {
  const MappedFile file(path);
  const auto number = [&](std::uint64_t offset, std::size_t length) {
    std::uint64_t value = 0;
    for (const std::uint8_t byte : file.bytes(offset, length, "the Matroska header"))
      value = value << 8 | byte;
    return value;
  };
  constexpr std::uint64_t kEbml = 0x1A45DFA3, kSegment = 0x18538067;
  if (file.size() < 8 || number(0, 4) != kEbml) return std::nullopt;
  std::uint64_t offset = 0, mask = 0, size = 0;
  for (const std::uint64_t identity : {kEbml, kSegment}) {
    if (number(offset += size, 4) != identity) return std::nullopt;
    const auto first = static_cast<std::uint8_t>(number(offset += 4, 1));
    if (first == 0) return std::nullopt;
    const int length = std::countl_zero(first) + 1;
    mask = (std::uint64_t{1} << (7 * length)) - 1;
    size = number(offset, static_cast<std::size_t>(length)) & mask;
    offset += static_cast<std::uint64_t>(length);
  }
  return size == mask ? kUnfinished : offset + size;
}

}  // namespace tribotrack::vision
