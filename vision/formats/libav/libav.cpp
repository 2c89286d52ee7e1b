#include "vision/formats/libav/libav.h"

#include <libavutil/motion_vector.h>
#include <libavutil/video_enc_params.h>
#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "vision/io/files.h"
#include "vision/io/levels.h"

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

bool is_coding_read(const std::string& decoder_name) {
  return ("," + std::string(kCodings) + ",").find("," + decoder_name + ",") != std::string::npos;
}

AVFormatContext* contained_input() {
  constexpr std::size_t kLargestAllocation = std::size_t{1} << 30;
  constexpr unsigned kMostStreams = 64;
  av_max_alloc(kLargestAllocation);
  AVFormatContext* input = there(avformat_alloc_context());
  av_opt_set(input, "protocol_whitelist", "file", 0);
  av_opt_set(input, "format_whitelist", kContainers, 0);
  av_opt_set(input, "codec_whitelist", kCodings, 0);
  input->max_streams = kMostStreams;
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

StoredFrame stored_levels(const AVFrame& frame, Picture& computed) {
  const AVPixFmtDescriptor& form = *av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
  const AVComponentDescriptor& first = form.comp[0];
  const bool palette = form.flags & AV_PIX_FMT_FLAG_PAL, rgb = form.flags & AV_PIX_FMT_FLAG_RGB;
  // Eight bits, or a whole 16-bit word, side by side.
  const bool plain_8 = first.step == 1 && first.depth == 8,
             plain_16 = first.step == 2 && first.depth > 8 && !(form.flags & AV_PIX_FMT_FLAG_BE);
  if (!palette && !rgb && first.shift == 0 && (plain_8 || plain_16))
    return {frame.data[first.plane] + first.offset, frame.linesize[first.plane], first.step, first.step};
  computed = Picture(frame.width, frame.height);
  std::array<std::vector<std::uint16_t>, 3> parts;
  const auto read = [&](int component, int y) -> const std::vector<std::uint16_t>& {
    std::vector<std::uint16_t>& row = parts[static_cast<std::size_t>(component)];
    row.resize(static_cast<std::size_t>(frame.width));
    av_read_image_line2(row.data(), const_cast<const std::uint8_t**>(frame.data), frame.linesize, &form, 0, y,
                        component, frame.width, 0, sizeof row[0]);
    return row;
  };
  for (int y = 0; y < frame.height; ++y) {
    const std::span<float> levels = computed.row(y);
    if (palette) {
      const std::uint8_t* codes = frame.data[0] + static_cast<std::ptrdiff_t>(y) * frame.linesize[0];
      for (std::size_t x = 0; x < levels.size(); ++x) {
        const std::uint8_t* bgra = frame.data[1] + 4 * static_cast<std::size_t>(codes[x]);
        levels[x] = luma(bgra[2], bgra[1], bgra[0]);
      }
    } else if (rgb) {
      const auto &red = read(0, y), &green = read(1, y), &blue = read(2, y);
      for (std::size_t x = 0; x < levels.size(); ++x) levels[x] = luma(red[x], green[x], blue[x]);
    } else {
      std::ranges::copy(read(0, y), levels.begin());
    }
  }
  return stored_in(computed);
}

namespace {

constexpr int kCell = CodedFrame::kCell;

int properties(AVCodecID id) {
  const AVCodecDescriptor* descriptor = avcodec_descriptor_get(id);
  return descriptor ? descriptor->props : 0;
}

bool may_be_lossy(AVCodecID id) {
  return (properties(id) & AV_CODEC_PROP_LOSSY) != 0;
}

/// The coder's own words: user data that is not registered, 16 bytes of identity first.
std::string settings_of(const AVFrame& frame) {
  for (int i = 0; i < frame.nb_side_data; ++i) {
    const AVFrameSideData& data = *frame.side_data[i];
    constexpr std::size_t kIdentity = 16;
    if (data.type != AV_FRAME_DATA_SEI_UNREGISTERED || data.size <= kIdentity) continue;
    std::string text(reinterpret_cast<const char*>(data.data) + kIdentity, data.size - kIdentity);
    text.resize(std::strlen(text.c_str()));
    if (text.starts_with("x264") || text.starts_with("x265")) return text;
  }
  return {};
}

/// Calls with the cells, clipped to the frame, that a block covers.
template <class Do>
void for_cells(CodedFrame& coded, int x, int y, int width, int height, Do&& change) {
  const int left = std::max(0, x / kCell), top = std::max(0, y / kCell);
  const int right = std::min(coded.columns, (x + width + kCell - 1) / kCell);
  const int bottom = std::min(coded.rows, (y + height + kCell - 1) / kCell);
  for (int row = top; row < bottom; ++row)
    for (int column = left; column < right; ++column)
      change(coded.cells[static_cast<std::size_t>(row * coded.columns + column)]);
}

float step_of(AVCodecID id, int qp) {
  return id == AV_CODEC_ID_H264 ? static_cast<float>(0.625 * std::exp2(qp / 6.0)) : static_cast<float>(qp);
}

void take_steps(const AVFrameSideData& data, AVCodecID id, CodedFrame& coded) {
  const auto* parameters = reinterpret_cast<const AVVideoEncParams*>(data.data);
  for (unsigned i = 0; i < parameters->nb_blocks; ++i) {
    const auto& block = *reinterpret_cast<const AVVideoBlockParams*>(data.data + parameters->blocks_offset +
                                                                     i * parameters->block_size);
    const float step = step_of(id, parameters->qp + block.delta_qp);
    for_cells(coded, block.src_x, block.src_y, block.w, block.h, [&](CodedCell& cell) { cell.step = step; });
  }
}

/// A block without a vector is coded by itself; one of several vectors that moves makes it a moving one.
void take_vectors(const AVFrameSideData& data, CodedFrame& coded) {
  const std::span vectors(reinterpret_cast<const AVMotionVector*>(data.data),
                          data.size / sizeof(AVMotionVector));
  for (const AVMotionVector& v : vectors)
    for_cells(coded, v.dst_x - v.w / 2, v.dst_y - v.h / 2, v.w, v.h, [&](CodedCell& cell) {
      const bool moves = v.motion_x != 0 || v.motion_y != 0;
      if (moves || cell.kind == CodedCell::Kind::intra)
        cell.kind = moves ? CodedCell::Kind::moving : CodedCell::Kind::still;
    });
}

/// Half a step where another frame predicts nothing: plain rounding.
double dead_zone_of(AVCodecID id, const std::string& settings) {
  if (id == AV_CODEC_ID_MJPEG) return 0.5;
  if (id == AV_CODEC_ID_MPEG4 || id == AV_CODEC_ID_H263) return 1.25;  // |c| < 2.5 q is 0
  if (const auto at = settings.find("deadzone="); at != std::string::npos)
    return 0.5 + std::atof(settings.c_str() + at + 9) / 64;
  return 0.83;
}

}  // namespace

void ask_for_coding(AVCodecContext& decoder) {
  if (!may_be_lossy(decoder.codec_id)) return;
  decoder.export_side_data |= AV_CODEC_EXPORT_DATA_VIDEO_ENC_PARAMS | AV_CODEC_EXPORT_DATA_MVS;
}

std::optional<Coder> coder_of(const AVCodecContext& decoder, const AVFrame& first, const CodedFrame& coded) {
  const AVCodecID id = decoder.codec_id;
  if (!may_be_lossy(id)) return std::nullopt;
  Coder coder;
  coder.settings = settings_of(first);
  coder.step = coded.mean_step();
  // Both kinds exist: a step below one grey level's rounding, or the coder's word.
  const bool may_be_lossless = (properties(id) & AV_CODEC_PROP_LOSSLESS) != 0;
  const auto largest = std::ranges::max_element(coded.cells, {}, &CodedCell::step);
  if (may_be_lossless && largest != coded.cells.end() && largest->step > 0 && largest->step < 1)
    return std::nullopt;
  if (coder.settings.find(" lossless ") != std::string::npos) return std::nullopt;
  const bool named = !coder.settings.empty();
  coder.name = named ? coder.settings.substr(0, 4) : avcodec_get_name(id);
  coder.grid = id == AV_CODEC_ID_HEVC || id == AV_CODEC_ID_VP9 || id == AV_CODEC_ID_AV1 ? 16 : 8;
  coder.dead_zone = dead_zone_of(id, coder.settings);
  coder.known = coder.name == "x264" || id == AV_CODEC_ID_MJPEG || id == AV_CODEC_ID_MPEG4;
  return coder;
}

CodedFrame coded_frame_of(const AVCodecContext& decoder, const AVFrame& frame, float table_step) {
  CodedFrame coded;
  const char type = av_get_picture_type_char(frame.pict_type);
  coded.type = type == 'S' ? 'P' : type;
  const AVFrameSideData* steps = av_frame_get_side_data(&frame, AV_FRAME_DATA_VIDEO_ENC_PARAMS);
  if (!steps && !(table_step > 0)) return coded;
  coded.columns = (frame.width + kCell - 1) / kCell;
  coded.rows = (frame.height + kCell - 1) / kCell;
  coded.cells.assign(static_cast<std::size_t>(coded.columns * coded.rows),
                     {CodedCell::Kind::intra, table_step});
  if (steps) take_steps(*steps, decoder.codec_id, coded);
  if (const auto* vectors = av_frame_get_side_data(&frame, AV_FRAME_DATA_MOTION_VECTORS))
    take_vectors(*vectors, coded);
  return coded;
}

float jpeg_step(const AVPacket& packet) {
  const std::span bytes(packet.data, static_cast<std::size_t>(packet.size));
  constexpr std::size_t kLowest = 10;  // in zigzag order, after the mean level
  for (std::size_t i = 0; i + 5 + 64 <= bytes.size(); ++i) {
    if (bytes[i] != 0xFF) continue;
    if (bytes[i + 1] == 0xDA) break;  // the picture's data begin
    if (bytes[i + 1] != 0xDB) continue;
    const bool wide = (bytes[i + 4] >> 4) != 0;
    const std::size_t size = wide ? 2 : 1;
    if (i + 5 + 64 * size > bytes.size()) break;
    std::array<float, kLowest> entries{};
    for (std::size_t k = 0; k < kLowest; ++k) {
      const std::size_t at = i + 5 + (k + 1) * size;
      entries[k] = wide ? static_cast<float>(bytes[at] << 8 | bytes[at + 1]) : static_cast<float>(bytes[at]);
    }
    std::ranges::sort(entries);
    return 0.5F * (entries[kLowest / 2 - 1] + entries[kLowest / 2]);
  }
  return 0;
}

}  // namespace tribotrack::vision
