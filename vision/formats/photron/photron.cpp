#include "vision/formats/photron/photron.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <initializer_list>
#include <string_view>

#include "vision/formats/cine/cine.h"
#include "vision/formats/pictures/pictures.h"
#include "vision/io/files.h"
#include "vision/io/levels.h"
#include "vision/timing/clock.h"

namespace tribotrack::vision {
namespace {

namespace fs = std::filesystem;

constexpr std::array<const char*, 4> kSidecars = {".cihx", ".CIHX", ".cih", ".CIH"};
constexpr std::size_t kMostBytes = 1 << 20;  ///< some ten thousand are usual

/// The value behind a key of a .cih, or in the innermost of nested elements of a .cihx; empty without it.
std::string_view value_of(std::string_view text, bool xml, std::string_view key,
                          std::initializer_list<std::string_view> elements) {
  std::size_t at = 0;
  if (xml) {
    for (const std::string_view element : elements) {
      const auto found = text.find(element, at);
      if (found == text.npos) return {};
      at = found + element.size();
    }
  } else {
    for (;; at += key.size()) {
      at = text.find(key, at);
      if (at == text.npos) return {};
      if (at == 0 || text[at - 1] == '\n') break;
    }
    at = text.find_first_not_of(" \t:", at + key.size());
    if (at == text.npos) return {};
  }
  text.remove_prefix(at);
  text = text.substr(0, text.find_first_of(xml ? "<" : "\r\n"));
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

/// Of "30000" or "1/20000"; nothing unless it is a number greater than 0.
std::optional<double> number_of(std::string_view text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{}) return std::nullopt;
  if (end != text.data() + text.size() && *end == '/')
    number /= number_of(text.substr(static_cast<std::size_t>(end + 1 - text.data()))).value_or(NAN);
  return number > 0 && std::isfinite(number) ? std::optional(number) : std::nullopt;
}

std::int64_t whole_of(std::string_view text) {
  std::int64_t number = 0;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

bool is_sidecar(const fs::path& path) {
  return std::ranges::count(kSidecars, path.extension().string()) > 0;
}

}  // namespace

PhotronSidecar read_photron_sidecar(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string whole(kMostBytes, '\0');
  stream.read(whole.data(), static_cast<std::streamsize>(whole.size()));
  whole.resize(static_cast<std::size_t>(stream.gcount()));
  const bool xml = file.extension().string().size() == 5;
  const auto value = [&](std::string_view key, std::initializer_list<std::string_view> elements) {
    return value_of(whole, xml, key, elements);
  };
  PhotronSidecar sidecar;
  sidecar.file = file;
  sidecar.rate_hz = number_of(value("Record Rate(fps)", {"<recordInfo>", "<recordRate>"})).value_or(0);
  sidecar.step = std::max(1.0, number_of(value("Save Step", {"<frameInfo>", "<skipFrame>"})).value_or(1));
  sidecar.random_trigger = value("Trigger Mode", {"<triggerMode>", "<mode>"}).starts_with("Random");
  sidecar.camera = value("Camera Type", {"<deviceInfo>", "<deviceName>"});
  if (const auto ns = number_of(value("Shutter Type2(nsec)", {"<recordInfo>", "<shutterSpeedNsec>"})))
    sidecar.exposure_s = *ns * 1e-9;
  else if (const auto speed = number_of(value("Shutter Speed(s)", {"<recordInfo>", "<shutterSpeed>"})))
    sidecar.exposure_s = xml ? 1 / *speed : *speed;
  sidecar.width = whole_of(value("Image Width", {"<imageDataInfo>", "<resolution>", "<width>"}));
  sidecar.height = whole_of(value("Image Height", {"<imageDataInfo>", "<resolution>", "<height>"}));
  sidecar.frames = whole_of(value("Total Frame", {"<frameInfo>", "<totalFrame>"}));
  sidecar.first_frame = whole_of(value("Start Frame", {"<frameInfo>", "<startFrame>"}));
  sidecar.stored_bits = whole_of(value("Color Bit", {"<imageDataInfo>", "<colorInfo>", "<bit>"}));
  sidecar.bits = whole_of(value("EffectiveBit Depth", {"<imageDataInfo>", "<effectiveBit>", "<depth>"}));
  sidecar.high_side =
      value("EffectiveBit Side", {"<imageDataInfo>", "<effectiveBit>", "<side>"}).starts_with("H");
  sidecar.colour = value("Color Type", {"<imageDataInfo>", "<colorInfo>", "<type>"});
  return sidecar;
}

void PhotronSidecar::describe(SourceInfo& info, std::vector<TimeBaseCandidate>& candidates) const {
  TimeBaseCandidate said{"sidecar " + file.filename().string(), rate_hz / step, false, ""};
  if (!(rate_hz > 0)) {
    said.reason = "no 'Record Rate(fps)' (<recordRate>) with a positive number in it";
  } else if (random_trigger) {
    said.reason = "frames were taken in bursts (Trigger Mode Random), and when each began is not stated";
  } else {
    said.accepted = true;
    said.reason = "written by the camera beside the recording";
    if (step > 1) said.reason += fmt::format(": one of {} frames at {} Hz was saved", step, rate_hz);
  }
  candidates.push_back(std::move(said));
  if (!info.exposure_s) info.exposure_s = exposure_s;
  if (info.camera.empty()) info.camera = camera;
}

std::optional<fs::path> photron_sidecar(const fs::path& recording) {
  for (const char* extension : kSidecars) {
    fs::path beside = recording;
    beside.replace_extension(extension);
    if (std::ifstream(beside, std::ios::binary)) return beside;
  }
  return std::nullopt;
}

std::optional<fs::path> photron_sidecar_of_pictures(const fs::path& first) {
  std::string stem = first.stem().string();
  while (!stem.empty() && stem.back() >= '0' && stem.back() <= '9') stem.pop_back();
  if (const auto named = photron_sidecar(first.parent_path() / (stem + ".tif"))) return named;
  std::vector<fs::path> found = entries(first.parent_path());
  std::erase_if(found, [](const fs::path& file) { return !is_sidecar(file); });
  return found.size() == 1 ? std::optional(found.front()) : std::nullopt;
}

std::optional<fs::path> mraw_named(const fs::path& path) {
  const std::string extension = path.extension().string();
  if (extension == ".mraw" || extension == ".MRAW") return path;
  if (!is_sidecar(path)) return std::nullopt;
  fs::path pixels = path;
  return pixels.replace_extension(".mraw");
}

namespace {

class MrawSource : public FrameSource {
 public:
  MrawSource(const std::filesystem::path& path, const PhotronSidecar& sidecar, const SourceOptions& options)
      : file_(path), stored_bits_(sidecar.stored_bits) {
    const auto misfit = [&](const std::string& reason) {
      refuse(sidecar.file, "{}; copy both files again, or save the recording as TIFF", reason);
    };
    require_sensible_size(sidecar.file, sidecar.width, sidecar.height);
    if (stored_bits_ == 24 || stored_bits_ == 36 || stored_bits_ == 48 || sidecar.colour == "Color")
      misfit("describes a recording in colour, of which only grey ones (8, 12 or 16 bits) are read");
    if (stored_bits_ != 8 && stored_bits_ != 12 && stored_bits_ != 16)
      misfit(
          fmt::format("states {} bits to a pixel (Color Bit), where 8, 12 and 16 are known", stored_bits_));
    const std::int64_t bits = sidecar.bits > 0 && stored_bits_ == 16 ? sidecar.bits : stored_bits_;
    if (bits < 8 || bits > stored_bits_)
      misfit(fmt::format("states {} significant bits (EffectiveBit Depth) of {}", bits, stored_bits_));
    if (sidecar.frames < 1) misfit("states no number of frames (Total Frame)");
    const auto pixels = static_cast<std::uint64_t>(sidecar.width * sidecar.height);
    bytes_ = (pixels * static_cast<std::uint64_t>(stored_bits_) + 7) / 8;
    if (static_cast<std::uint64_t>(sidecar.frames) > file_.size() / bytes_)
      refuse(path,
             "is cut short: {} promises {} frames of {} bytes, but it has {} bytes; copy the recording again",
             sidecar.file.filename().string(), sidecar.frames, bytes_, file_.size());
    if (sidecar.high_side) lift_ = 1.0F / static_cast<float>(1 << (stored_bits_ - bits));
    info_.path = path;
    info_.format = "mraw";
    info_.codec = std::to_string(stored_bits_) + " bit" + (stored_bits_ == 12 ? ", packed" : "");
    info_.width = static_cast<int>(sidecar.width);
    info_.height = static_cast<int>(sidecar.height);
    info_.bits = static_cast<int>(bits);
    info_.frame_count = sidecar.frames;
    if (sidecar.step == 1) info_.first_number = sidecar.first_frame;
    ClockEvidence evidence;
    sidecar.describe(info_, evidence.camera);
    info_.time_base = judge_time(evidence, options, info_.first_number, info_.notes);
  }

  void fill(std::int64_t index, const Rect& window, Picture& picture) override {
    const auto frame = file_.bytes(static_cast<std::uint64_t>(index) * bytes_, bytes_,
                                   "image " + std::to_string(number(index)));
    if (stored_bits_ == 12) {
      unpack(unpack_p12l, frame, info_.width, window, picture);
    } else {
      const int bytes = static_cast<int>(stored_bits_ / 8);
      copy_stored({frame.data(), std::ptrdiff_t{bytes} * info_.width, bytes, bytes}, window, picture);
    }
    if (lift_ != 1)
      for (float& level : picture.levels()) level *= lift_;
    file_.done_with(bytes_ * static_cast<std::uint64_t>(window.height) /
                    static_cast<std::uint64_t>(info_.height));
  }

 private:
  MappedFile file_;
  std::int64_t stored_bits_;
  std::uint64_t bytes_ = 0;  ///< of a frame
  float lift_ = 1;           ///< down to the lower bits, where the upper ones are significant
};

}  // namespace

std::unique_ptr<FrameSource> open_mraw(const fs::path& pixels, const SourceOptions& options) {
  require_readable_file(pixels);
  const auto sidecar = photron_sidecar(pixels);
  if (!sidecar)
    refuse(pixels,
           "holds a Photron camera's bare pixels: put the .cih or .cihx that the camera wrote back beside "
           "it, under the same name, or save the recording as AVI or TIFF");
  return std::make_unique<MrawSource>(pixels, read_photron_sidecar(*sidecar), options);
}

}  // namespace tribotrack::vision
