#include "apps/text/input_file.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <limits>
#include <memory>

#include "apps/program/errors.h"
#include "vision/frame_source.h"

namespace tribotrack::apps {

namespace {

namespace fs = std::filesystem;

std::string hex(const XXH128_hash_t& hash) {
  return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

class Hasher {
 public:
  Hasher() { XXH3_128bits_reset(state_.get()); }

  void add(const fs::path& path, const Sampling& sampling) {
    std::ifstream stream(path, std::ios::binary);
    if (!stream)
      throw InvalidInput(fmt::format("{}: cannot be read; check its name and permissions", path.string()));
    std::error_code not_known;
    const std::uint64_t size = fs::file_size(path, not_known);
    if (not_known || size <= sampling.whole_up_to)
      add_range(stream, 0, std::numeric_limits<std::uint64_t>::max());
    else
      add_sample(stream, size, vision::bytes_before_pictures(path), sampling);
  }

  ContentHash result() const { return {hex(XXH3_128bits_digest(state_.get())), sampled_ ? bytes_ : 0}; }

 private:
  void add_sample(std::ifstream& stream, std::uint64_t size, std::uint64_t head, const Sampling& sampling) {
    sampled_ = true;
    XXH3_128bits_update(state_.get(), &size, sizeof size);
    const std::uint64_t begin = std::min(size, std::max(sampling.ends, head));
    const std::uint64_t end = std::max(begin, size - std::min(size, sampling.ends));
    add_range(stream, 0, begin);
    if (end - begin <= sampling.blocks * sampling.block) {
      add_range(stream, begin, end);
    } else {
      const std::uint64_t room = end - begin - sampling.block, steps = sampling.blocks - 1;
      for (std::uint64_t k = 0; k <= steps; ++k) {
        const std::uint64_t at = begin + room / steps * k + room % steps * k / steps;
        add_range(stream, at, at + sampling.block);
      }
    }
    add_range(stream, end, size);
  }

  /// What of [begin, end) the file has.
  void add_range(std::ifstream& stream, std::uint64_t begin, std::uint64_t end) {
    stream.clear();
    stream.seekg(static_cast<std::streamoff>(begin));
    while (begin < end) {
      stream.read(buffer_.data(),
                  static_cast<std::streamsize>(std::min<std::uint64_t>(buffer_.size(), end - begin)));
      const auto count = static_cast<std::size_t>(stream.gcount());
      if (count == 0) return;
      XXH3_128bits_update(state_.get(), buffer_.data(), count);
      begin += count;
      bytes_ += count;
    }
  }

  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state_{XXH3_createState(), &XXH3_freeState};
  std::vector<char> buffer_ = std::vector<char>(1 << 18);
  std::uint64_t bytes_ = 0;
  bool sampled_ = false;
};

}  // namespace

ContentHash hash_of_files(const std::vector<fs::path>& files, const Sampling& sampling) {
  Hasher hasher;
  for (const fs::path& file : files) hasher.add(file, sampling);
  return hasher.result();
}

std::string hash_of_text(std::string_view text) {
  return hex(XXH3_128bits(text.data(), text.size()));
}

namespace {

std::string suffix_of(const std::filesystem::path& path) {
  std::string suffix = path.extension().string();
  for (char& c : suffix) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return suffix;
}

}  // namespace

bool names_a_recording(const std::filesystem::path& path) {
  constexpr std::array<std::string_view, 15> kVideos = {".cine", ".mp4",  ".m4v", ".avi",  ".mkv",
                                                        ".mov",  ".webm", ".wmv", ".mpg",  ".mpeg",
                                                        ".mts",  ".ts",   ".y4m", ".tiff", ".tif"};
  return std::ranges::find(kVideos, suffix_of(path)) != kVideos.end() || names_a_picture(path);
}

bool names_a_picture(const std::filesystem::path& path) {
  constexpr std::array<std::string_view, 5> kPictures = {".png", ".bmp", ".jpeg", ".jpg", ".pgm"};
  return std::ranges::find(kPictures, suffix_of(path)) != kPictures.end();
}

bool may_be_recording(const fs::path& path) {
  return fs::exists(path) || vision::is_number_pattern(path);
}

std::vector<fs::path> files_of_input(const fs::path& path) {
  try {
    if (may_be_recording(path)) return vision::files_of_recording(path);
  } catch (const vision::InputError&) {  // reported by the code that opens it
  }
  return {path};
}

Input hashed_input(const fs::path& path) {
  Sampling whole;
  whole.whole_up_to = std::numeric_limits<std::uint64_t>::max();
  return {path, hash_of_files({path}, whole).xxh3_128};
}

Input hashed_recording(const fs::path& path) {
  const ContentHash hash = hash_of_files(vision::files_of_recording(path), {});
  Input input{path, hash.xxh3_128};
  if (hash.sampled_bytes > 0)
    input.hashed = fmt::format("sample of {:.1f} MiB", static_cast<double>(hash.sampled_bytes) / (1 << 20));
  return input;
}

Input hashed_input(const fs::path& path, std::string_view text) {
  return {path, hash_of_text(text)};
}

InputState::InputState(const std::vector<fs::path>& inputs) {
  for (const fs::path& input : inputs)
    for (const fs::path& file : files_of_input(input)) files_.push_back(state_of(file));
}

InputState::File InputState::state_of(const fs::path& path) {
  std::error_code error;
  File file{path, fs::file_size(path, error), {}};
  file.changed = fs::last_write_time(path, error);
  return file;
}

void InputState::require_unchanged() const {
  for (const File& before : files_) {
    const File now = state_of(before.path);
    if (now.size != before.size || now.changed != before.changed)
      throw InvalidInput(
          fmt::format("{}: changed while it was being read; start again once it is complete (is it still "
                      "being copied?)",
                      before.path.string()));
  }
}

}  // namespace tribotrack::apps
