#include "apps/text/input_file.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>

#include <limits>

#include "apps/program/errors.h"
#include "vision/frame_source.h"

namespace tribotrack::apps {

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

namespace fs = std::filesystem;

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
