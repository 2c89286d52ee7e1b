#include "apps/text/input_file.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <fstream>
#include <memory>

#include "apps/program/errors.h"
#include "vision/frame_source.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

std::string hex(const XXH128_hash_t& hash) {
  return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

void add_file(XXH3_state_t* state, const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream)
    throw InvalidInput(fmt::format("{}: cannot be read; check its name and permissions", path.string()));
  std::vector<char> block(1 << 20);
  while (stream.read(block.data(), static_cast<std::streamsize>(block.size())) || stream.gcount() > 0)
    XXH3_128bits_update(state, block.data(), static_cast<std::size_t>(stream.gcount()));
}

Input hashed(const fs::path& path, const std::vector<fs::path>& files) {
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(), &XXH3_freeState);
  XXH3_128bits_reset(state.get());
  for (const fs::path& file : files) add_file(state.get(), file);
  return {path, hex(XXH3_128bits_digest(state.get()))};
}

}  // namespace

bool may_be_recording(const fs::path& path) {
  return fs::exists(path) || vision::is_number_pattern(path);
}

std::vector<fs::path> files_of_input(const fs::path& path) {
  try {
    if (may_be_recording(path)) return vision::files_of_recording(path);
  } catch (const vision::InputError&) {  // no recording, or none that can be read: whoever reads it says why
  }
  return {path};
}

Input hashed_input(const fs::path& path) {
  return hashed(path, {path});
}

Input hashed_recording(const fs::path& path) {
  return hashed(path, vision::files_of_recording(path));
}

Input hashed_input(const fs::path& path, std::string_view text) {
  return {path, hash_of_text(text)};
}

std::string hash_of_text(std::string_view text) {
  return hex(XXH3_128bits(text.data(), text.size()));
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
