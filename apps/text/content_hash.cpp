#include "apps/text/content_hash.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
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

}  // namespace tribotrack::apps
