#include "vision/formats/libav/libav.h"

#include <bit>
#include <cctype>
#include <cstdarg>
#include <cstdio>
#include <fstream>
#include <mutex>
#include <new>
#include <set>
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

void LibavDelete::operator()(AVCodecContext* context) const {
  avcodec_free_context(&context);
}
void LibavDelete::operator()(AVFrame* frame) const {
  av_frame_free(&frame);
}
void LibavDelete::operator()(AVPacket* packet) const {
  av_packet_free(&packet);
}
void LibavCloseInput::operator()(AVFormatContext* context) const {
  avformat_close_input(&context);
}
void LibavCloseOutput::operator()(AVFormatContext* context) const {
  if (context->pb) avio_closep(&context->pb);
  avformat_free_context(context);
}

LibavFrame make_libav_frame() {
  LibavFrame frame(av_frame_alloc());
  if (!frame) throw std::bad_alloc();
  return frame;
}

LibavPacket make_libav_packet() {
  LibavPacket packet(av_packet_alloc());
  if (!packet) throw std::bad_alloc();
  return packet;
}

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
  AVFormatContext* input = avformat_alloc_context();
  if (!input) throw std::bad_alloc();
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

namespace {

class ByteReader {
 public:
  explicit ByteReader(const std::filesystem::path& path) : file_(path, std::ios::binary) {
    std::error_code error;
    size_ = std::filesystem::file_size(path, error);
    if (error) size_ = 0;
  }
  std::uint64_t size() const { return size_; }
  /// Empty where the file ends before.
  std::vector<std::uint8_t> read(std::uint64_t offset, std::size_t count) {
    std::vector<std::uint8_t> bytes(count);
    file_.clear();
    file_.seekg(static_cast<std::streamoff>(offset));
    file_.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(count));
    if (static_cast<std::size_t>(file_.gcount()) != count) bytes.clear();
    return bytes;
  }

 private:
  std::ifstream file_;
  std::uint64_t size_ = 0;
};

std::uint64_t big_endian(const std::vector<std::uint8_t>& bytes, std::size_t offset, std::size_t count) {
  std::uint64_t number = 0;
  for (std::size_t i = 0; i < count; ++i) number = number << 8 | bytes[offset + i];
  return number;
}

std::string name_at(const std::vector<std::uint8_t>& bytes, std::size_t offset) {
  return std::string(bytes.begin() + static_cast<std::ptrdiff_t>(offset),
                     bytes.begin() + static_cast<std::ptrdiff_t>(offset) + 4);
}

/// ISO base media: u32 size, type; size 1: u64 size follows; size 0: to the end of the file.
std::optional<ContainerExtent> mp4_extent(ByteReader& file) {
  static const std::set<std::string> first_boxes = {"ftyp", "moov", "mdat", "free", "skip", "wide", "styp"};
  ContainerExtent extent;
  for (std::uint64_t offset = 0; offset < file.size();) {
    const auto head = file.read(offset, 8);
    if (head.empty()) break;
    const std::string type = name_at(head, 4);
    if (offset == 0 && !first_boxes.contains(type)) return std::nullopt;
    std::uint64_t size = big_endian(head, 0, 4);
    if (size == 1) {
      const auto large = file.read(offset + 8, 8);
      if (large.empty()) break;
      size = big_endian(large, 0, 8);
    } else if (size == 0) {
      size = file.size() - offset;
    }
    if (size < 8) break;  // bytes after the last box that are no box
    offset += size;
    extent.stated_end = offset;
    extent.last_box = type;
    if (offset > file.size()) break;
  }
  return extent;
}

/// RIFF: one chunk "AVI ", then further ones "AVIX" beyond 1 GB.
std::optional<ContainerExtent> riff_extent(ByteReader& file) {
  ContainerExtent extent;
  for (std::uint64_t offset = 0; offset < file.size();) {
    const auto head = file.read(offset, 8);
    if (head.empty() || name_at(head, 0) != "RIFF") break;
    const std::uint64_t size =
        head[4] | head[5] << 8 | head[6] << 16 | static_cast<std::uint64_t>(head[7]) << 24;
    if (size == 0) break;
    offset += 8 + size;
    extent.stated_end = offset;
    extent.last_box = "RIFF";
    offset += size % 2;
  }
  return extent.stated_end > 0 ? std::optional(extent) : std::nullopt;
}

/// EBML: identity and size are numbers whose first byte states their length; a size of all ones is unknown.
std::optional<ContainerExtent> matroska_extent(ByteReader& file) {
  const auto size_length = [&](std::uint64_t offset) -> std::size_t {
    const auto first = file.read(offset, 1);
    return first.empty() || first[0] == 0 ? 0 : static_cast<std::size_t>(std::countl_zero(first[0])) + 1;
  };
  std::uint64_t offset = 0;
  for (const bool segment : {false, true}) {
    offset += 4;
    const std::size_t length = size_length(offset);
    const auto bytes = length > 0 ? file.read(offset, length) : std::vector<std::uint8_t>{};
    if (bytes.empty()) return std::nullopt;
    const std::uint64_t mask = (std::uint64_t{1} << (7 * length)) - 1;
    const std::uint64_t size = big_endian(bytes, 0, length) & mask;
    offset += length;
    if (!segment) {
      offset += size;
      const auto identity = file.read(offset, 4);
      if (identity.empty() || big_endian(identity, 0, 4) != 0x18538067) return std::nullopt;
    } else if (size == mask) {
      return ContainerExtent{offset, "Segment", true};
    } else {
      offset += size;
    }
  }
  return ContainerExtent{offset, "Segment", false};
}

}  // namespace

std::optional<ContainerExtent> container_extent(const std::filesystem::path& path) {
  ByteReader file(path);
  const auto head = file.read(0, 8);
  if (head.empty()) return std::nullopt;
  if (name_at(head, 0) == "RIFF") return riff_extent(file);
  if (big_endian(head, 0, 4) == 0x1A45DFA3) return matroska_extent(file);
  return mp4_extent(file);
}

}  // namespace tribotrack::vision
