#include "vision/formats/cine/cine.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <fstream>

#include "vision/io/files.h"
#include "vision/io/levels.h"
#include "vision/timing/clock.h"

namespace tribotrack::vision {
namespace {

std::string iso_8601(CineTime time) {
  const auto seconds = static_cast<std::time_t>(time >> 32);
  const auto micros = static_cast<unsigned>((time & 0xFFFFFFFF) * 1000000 >> 32);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  char day[32];
  std::strftime(day, sizeof day, "%Y-%m-%dT%H:%M:%S", &utc);
  return fmt::format("{}.{:06}Z", day, micros);
}

std::string codec_name(const CineHeader& header) {
  if (header.packing != CinePacking::none) return header.packing == CinePacking::p10 ? "P10" : "P12L";
  return fmt::format("uncompressed {}{}{} bit", header.bgr ? "colour, 3 x " : "", header.bits,
                     header.level_bytes == 2 ? " in 16" : "");
}

/// The camera stamps the beginning of an exposure; what moves is seen where it was in the middle. Where all
/// exposures are alike the times since the first image do not change.
void move_to_mid_exposure(std::vector<double>& stamps, const std::vector<double>& exposures) {
  for (std::size_t i = 0; i < std::min(stamps.size(), exposures.size()); ++i)
    stamps[i] += 0.5 * (exposures[i] - exposures[0]);
}

/// Exposures written image by image repeat the header's to a clock tick; else they vary. Images that do not
/// belong to the recording do not count.
bool exposures_vary(const std::vector<double>& exposures, const std::vector<std::int64_t>& strays) {
  double least = 1e9, most = 0;
  for (std::size_t i = 0; i < exposures.size(); ++i) {
    if (std::ranges::binary_search(strays, static_cast<std::int64_t>(i))) continue;
    least = std::min(least, exposures[i]);
    most = std::max(most, exposures[i]);
  }
  return most - least > std::max(1e-7, 1e-3 * most);
}

double linear_level(const CineHeader& header, int stored) {
  if (header.packing != CinePacking::p10) return stored;
  return p10_linear_levels[static_cast<std::size_t>(std::clamp(stored, 0, 1023))];
}

TimeBaseCandidate rate_of(const CineHeader& header) {
  if (header.integer_rate > 0)
    return {"cine header", static_cast<double>(header.integer_rate), true,
            "FrameRateInt, written by the camera"};
  if (header.short_rate > 0)
    return {"cine header", static_cast<double>(header.short_rate), true, "FrameRate, written by the camera"};
  return {"cine header", 0, false, "its rate fields are 0"};
}

constexpr double kClockTick = 1e-6;  ///< s, the coarsest clock seen in a camera

class CineSource : public FrameSource {
 public:
  CineSource(const std::filesystem::path& path, const SourceOptions& options)
      : file_(path), header_(read_cine_header(file_)) {
    info_.path = path;
    info_.format = "cine";
    info_.codec = codec_name(header_);
    info_.width = header_.width;
    info_.height = header_.height;
    info_.bits = header_.bits;
    info_.colour = header_.bgr;
    info_.frame_count = static_cast<std::int64_t>(header_.image_offsets.size());
    info_.first_number = header_.first_image_number;
    info_.exposure_s = header_.exposure_s;
    if (header_.camera_version > 0)
      info_.camera = "Phantom, version " + std::to_string(header_.camera_version);
    if (header_.trigger != 0) info_.trigger_time = iso_8601(header_.trigger);
    if (header_.packing == CinePacking::p10)
      info_.notes.push_back("10-bit companded levels turned back to 12-bit linear ones");
    if (info_.colour) info_.notes.push_back("colour turned to luma (0.299 R + 0.587 G + 0.114 B)");
    if (header_.colour_filter && !info_.colour)
      info_.notes.push_back(
          "recorded by a colour camera and labelled grey by the file: check it for a chequered pattern");
    if (header_.shown_mirrored)
      info_.notes.push_back(
          "the camera's program shows this recording mirrored; pixels are handed out as stored");

    if (header_.black_level) {
      info_.black_level = linear_level(header_, *header_.black_level);
      info_.white_level = linear_level(header_, *header_.white_level);
    }
    describe_time(options);
  }

  void fill(std::int64_t index, const Rect& window, Picture& picture) override {
    const std::span<const std::uint8_t> pixels = image(index);
    if (header_.packing != CinePacking::none) {
      unpack(header_.packing == CinePacking::p10 ? unpack_p10 : unpack_p12l, pixels, info_.width, window,
             picture);
    } else {
      const auto row = static_cast<std::ptrdiff_t>(header_.row_bytes);
      const std::uint8_t* top = pixels.data() + (header_.top_down ? 0 : row * (header_.height - 1));
      copy_stored({top, header_.top_down ? row : -row, header_.level_bytes * (header_.bgr ? 3 : 1),
                   header_.level_bytes, header_.bgr},
                  window, picture);
    }
    file_.done_with(pixels.size() * static_cast<std::size_t>(window.height) /
                    static_cast<std::size_t>(header_.height));
  }

 private:
  void describe_time(const SourceOptions& options) {
    ClockEvidence evidence{.camera = {rate_of(header_)},
                           .stamps_from = "cine time stamps",
                           .ticks = {},
                           .tick_s = 0x1p-32,
                           .jitter_s = kClockTick,
                           .by_camera = true};
    for (const CineTime stamp : header_.stamps)
      evidence.ticks.push_back(static_cast<std::int64_t>(stamp - header_.stamps[0]));
    info_.time_base = judge_time(evidence, options, info_.first_number, info_.notes);
    if (!exposures_vary(header_.exposures_s, info_.time_base.check.strays)) return;
    info_.exposures_s = header_.exposures_s;
    info_.exposure_s = header_.exposures_s.front();
    info_.notes.push_back("the exposure varies within the shot: a frame's time is the middle of its own");
    if (!options.frame_rate_hz) move_to_mid_exposure(info_.time_base.stamps_s, header_.exposures_s);
  }

  /// The pixels of an image, behind its annotation, whose last word repeats their size.
  std::span<const std::uint8_t> image(std::int64_t index) const {
    const std::string what = "image " + std::to_string(number(index));
    const std::uint64_t offset = header_.image_offsets[static_cast<std::size_t>(index)];
    const std::uint64_t room = header_.image_rooms[static_cast<std::size_t>(index)];
    const auto annotation = load<std::uint32_t>(file_.bytes(offset, 8, what), 0);
    if (annotation < 8 || annotation > room - header_.image_bytes)
      refuse(info_.path,
             "is damaged: the annotation of {} claims {} bytes, where 8 to {} have room; copy the recording "
             "again",
             what, annotation, room - header_.image_bytes);
    const auto size = load<std::uint32_t>(file_.bytes(offset + annotation - 4, 4, what), 0);
    if (size < header_.image_bytes)
      refuse(info_.path,
             "is damaged: {} has {} bytes of pixels where {} are needed; copy the recording again", what,
             size, header_.image_bytes);
    return file_.bytes(offset + annotation, header_.image_bytes, what);
  }

  MappedFile file_;
  CineHeader header_;
};

}  // namespace

bool looks_like_cine(const std::filesystem::path& path) {
  std::array<char, 4> mark{};
  std::ifstream(path, std::ios::binary).read(mark.data(), mark.size());
  return mark == std::array<char, 4>{'C', 'I', 0x2C, 0};
}

std::uint64_t cine_head_bytes(const std::filesystem::path& path) {
  try {
    const auto offsets = read_cine_header(MappedFile(path)).image_offsets;
    return *std::ranges::min_element(offsets);
  } catch (const InputError&) {  // said by open_cine
    return 0;
  }
}

std::unique_ptr<FrameSource> open_cine(const std::filesystem::path& path, const SourceOptions& options) {
  return std::make_unique<CineSource>(path, options);
}

}  // namespace tribotrack::vision
