// Recordings opened and created by their names, and pictures in memory as recordings.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <opencv2/core/utility.hpp>
#include <opencv2/core/version.hpp>
#include <stdexcept>
#include <string>
#include <string_view>

#include "vision/formats/cine/cine.h"
#include "vision/formats/libav/libav.h"
#include "vision/formats/photron/photron.h"
#include "vision/formats/pictures/pictures.h"
#include "vision/frame_sink.h"
#include "vision/frame_source.h"
#include "vision/io/files.h"
#include "vision/io/levels.h"
#include "vision/io/picture_files.h"
#include "vision/kernels/plane.h"

namespace tribotrack::vision {
namespace {

namespace fs = std::filesystem;

/// The pictures of a folder or pattern; nothing where the path names a single file.
std::optional<PictureList> pictures_at(const fs::path& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) return pictures_in_folder(path);
  if (fs::exists(path, ignored)) return std::nullopt;
  const auto pattern = NumberPattern::parse(path);
  return pattern ? std::optional(pictures_of_pattern(*pattern)) : std::nullopt;
}

bool is_cine(const fs::path& path) {
  return looks_like_cine(path) || path.extension() == ".cine";
}

/// What others would call damaged.
void refuse_norpix(const fs::path& path) {
  constexpr std::array<char, 8> kMark = {'\xED', '\xFE', 0, 0, 'N', 0, 'o', 0};
  std::array<char, 8> begin{};
  std::ifstream(path, std::ios::binary).read(begin.data(), begin.size());
  if (begin == kMark || path.extension() == ".seq")
    refuse(path,
           "is a sequence of Norpix StreamPix (.seq), which is not read; export it from StreamPix as "
           "uncompressed AVI or TIFF and give its rate with --fps");
}

/// A table, a campaign, a list of other files: libav would say of it what it is not.
void refuse_text(const fs::path& path) {
  std::array<char, 512> begin;
  std::ifstream stream(path, std::ios::binary);
  stream.read(begin.data(), begin.size());
  const std::string_view head(begin.data(), static_cast<std::size_t>(stream.gcount()));
  const auto is_print = [](char c) { return (c >= ' ' && c <= '~') || (c >= '\t' && c <= '\r'); };
  if (head.empty() || head.starts_with("YUV4MPEG2") || !std::ranges::all_of(head, is_print)) return;
  refuse(path, "is no video that can be read but a text; name a recording, or check the file");
}

}  // namespace

std::unique_ptr<FrameSource> open_source(const fs::path& path, const SourceOptions& options) {
  if (auto pictures = pictures_at(path)) return open_picture_sequence(path, std::move(*pictures), options);
  if (const auto pixels = mraw_named(path)) return open_mraw(*pixels, options);
  require_readable_file(path);
  refuse_norpix(path);
  if (is_cine(path)) return open_cine(path, options);
  if (has_picture_extension(path)) return open_picture_stack(path, options);
  refuse_text(path);
  return open_libav(path, options);
}

std::vector<fs::path> files_of_recording(const fs::path& path) {
  std::vector<fs::path> files;
  std::optional<fs::path> sidecar;
  if (auto pictures = pictures_at(path)) {
    files = std::move(pictures->files);
    sidecar = photron_sidecar_of_pictures(files.front());
  } else {
    files = {mraw_named(path).value_or(path)};
    require_readable_file(files.front());
    if (!is_cine(path)) sidecar = photron_sidecar(path);
  }
  if (sidecar) files.push_back(*sidecar);
  return files;
}

std::uint64_t bytes_before_pictures(const fs::path& path) {
  return looks_like_cine(path) ? cine_head_bytes(path) : 0;
}

bool is_number_pattern(const fs::path& path) {
  try {
    return NumberPattern::parse(path).has_value();
  } catch (const InputError&) {
    return false;
  }
}

void set_up_process() {
  cv::setNumThreads(1);
  limit_picture_library();
}

namespace {

Codec codec_by_name(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  if (extension == ".cine") return Codec::cine;
  if (extension == ".mkv") return Codec::ffv1;
  if (extension == ".avi") return Codec::mjpeg;
  if (extension == ".mp4" || extension == ".mov") return Codec::h264;
  if (extension == ".png") return Codec::png;
  if (extension == ".tif" || extension == ".tiff") return Codec::tiff;
  refuse(path, "has no extension of a recording format: use .cine, .mkv, .avi, .mp4, %05d.png or %05d.tif");
}

}  // namespace

void require_size(const SinkOptions& options, int width, int height) {
  if (width != options.width || height != options.height)
    throw std::invalid_argument(fmt::format("a picture of {} x {} pixels for a recording of {} x {}", width,
                                            height, options.width, options.height));
}

void FrameSink::write_rgb(int, int, const unsigned char*) {
  throw InputError("this kind of recording cannot hold colour: choose .mp4 or .avi");
}

std::unique_ptr<FrameSink> create_sink(const std::filesystem::path& path, const SinkOptions& given) {
  SinkOptions options = given;
  if (options.codec == Codec::automatic) options.codec = codec_by_name(path);
  if (options.width <= 0 || options.height <= 0)
    refuse(path, "cannot be written: a picture of {} x {} pixels has no area", options.width, options.height);
  if (!(options.frame_rate_hz > 0) || !std::isfinite(options.frame_rate_hz))
    refuse(path, "cannot be written: the frame rate must be a positive number");
  switch (options.codec) {
    case Codec::cine:
      return create_cine_sink(path, options);
    case Codec::png:
    case Codec::tiff:
      return create_picture_sink(path, options);
    default:
      return create_libav_sink(path, options);
  }
}

double CodedFrame::mean_step() const {
  double sum = 0;
  for (const CodedCell& cell : cells) sum += static_cast<double>(cell.step);
  return cells.empty() ? 0 : sum / static_cast<double>(cells.size());
}

double CodedFrame::still_share() const {
  const auto still = std::ranges::count(cells, CodedCell::Kind::still, &CodedCell::kind);
  return cells.empty() ? 0 : static_cast<double>(still) / static_cast<double>(cells.size());
}

std::string libraries() {
  return "OpenCV " CV_VERSION
         ", libavformat " AV_STRINGIFY(LIBAVFORMAT_VERSION) ", libavcodec " AV_STRINGIFY(LIBAVCODEC_VERSION);
}

namespace {

SourceInfo in_memory(const char* what, int width, int height, int bits, std::int64_t frames,
                     double frame_rate_hz) {
  if (!(frame_rate_hz > 0)) throw std::invalid_argument("the frame rate must be above 0 Hz");
  SourceInfo info;
  info.path = what;
  info.format = "memory";
  info.codec = "uncompressed";
  info.width = width;
  info.height = height;
  info.bits = bits;
  info.frame_count = frames;
  info.time_base = choose_time_base({user_rate(frame_rate_hz)});
  return info;
}

}  // namespace

MemorySource::MemorySource(std::vector<Picture> frames, double frame_rate_hz, int bits)
    : frames_(std::move(frames)) {
  if (frames_.empty()) throw std::invalid_argument("a recording in memory needs at least one picture");
  const Picture& first = frames_.front();
  for (const Picture& frame : frames_)
    if (frame.width() != first.width() || frame.height() != first.height())
      throw std::invalid_argument("the pictures of a recording must have one size");
  info_ = in_memory("pictures in memory", first.width(), first.height(), bits, std::ssize(frames_),
                    frame_rate_hz);
}

void MemorySource::fill(std::int64_t index, const Rect& window, Picture& picture) {
  copy_window(frames_[static_cast<std::size_t>(index)], window, picture);
}

StackSource::StackSource(const FrameStack& stack, double frame_rate_hz, int bits) : stack_(stack) {
  if (stack.frames < 1 || stack.width < 1 || stack.height < 1)
    throw std::invalid_argument("a recording in memory needs at least one picture of one pixel");
  if (stack.bytes_per_level != 1 && stack.bytes_per_level != 2)
    throw std::invalid_argument("grey levels in memory must have 1 or 2 bytes");
  if (bits < 1 || bits > 8 * stack.bytes_per_level)
    throw std::invalid_argument(fmt::format("levels of {} bytes have 1 to {} bits, not {}",
                                            stack.bytes_per_level, 8 * stack.bytes_per_level, bits));
  info_ = in_memory("frames in memory", stack.width, stack.height, bits, stack.frames, frame_rate_hz);
  info_.codec += fmt::format(" {} bit", bits);
}

void StackSource::fill(std::int64_t index, const Rect& window, Picture& picture) {
  const auto* frame = static_cast<const std::uint8_t*>(stack_.first) + index * stack_.frame_stride;
  copy_stored({frame, stack_.row_stride, stack_.level_stride, stack_.bytes_per_level}, window, picture);
}

}  // namespace tribotrack::vision
