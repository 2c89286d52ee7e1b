#include "vision/camera/frame_cache.h"

#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <limits>
#include <string>

#include "vision/io/levels.h"

namespace tribotrack::vision {
namespace {

namespace fs = std::filesystem;

fs::path folder() {
  const char* named = std::getenv("TMPDIR");
  return named && *named ? named : "/var/tmp";
}

/// False where that form does not hold these levels exactly.
template <typename Level>
bool store_as(std::span<const float> levels, std::vector<std::uint8_t>& bytes) {
  bytes.resize(levels.size() * sizeof(Level));
  for (std::size_t i = 0; i < levels.size(); ++i) {
    if (!(levels[i] >= 0 && levels[i] <= std::numeric_limits<Level>::max())) return false;
    const auto level = static_cast<Level>(levels[i]);
    if (static_cast<float>(level) != levels[i]) return false;
    std::memcpy(bytes.data() + i * sizeof level, &level, sizeof level);
  }
  return true;
}

}  // namespace

FrameCache::FrameCache(FrameSource& source, std::int64_t most_bytes)
    : source_(source), most_bytes_(most_bytes), keeping_(source.info().decoded) {
  info_ = source.info();
}

FrameCache::~FrameCache() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

const FrameCache::Place* FrameCache::find(std::int64_t index, const Rect& window) const {
  const auto found = places_.find(index);
  return found != places_.end() && found->second.window.contains(window) ? &found->second : nullptr;
}

/// The file has no name: it is gone when the process ends, however it ends.
bool FrameCache::append() {
  if (descriptor_ < 0) {
    std::string name = (folder() / "tribotrack-frames-XXXXXX").string();
    descriptor_ = ::mkstemp(name.data());
    if (descriptor_ < 0) return false;
    ::unlink(name.c_str());
  }
  const auto size = static_cast<std::int64_t>(bytes_.size());
  std::error_code error;
  const fs::space_info space = fs::space(folder(), error);
  if (error || end_ + size > most_bytes_ || static_cast<std::int64_t>(space.available) - size < kLeftFree)
    return false;
  if (::pwrite(descriptor_, bytes_.data(), bytes_.size(), end_) != size) return false;
  end_ += size;
  return true;
}

void FrameCache::keep(std::int64_t index, const Rect& window) {
  if (!keeping_ || window.width <= 0 || window.height <= 0 || find(index, window)) return;
  source_.read(index, window, picture_);
  Place place{window, end_, 1};
  if (!store_as<std::uint8_t>(picture_.levels(), bytes_))
    place.bytes = store_as<std::uint16_t>(picture_.levels(), bytes_) ? 2 : 4;
  if (place.bytes == 4) {
    const auto* levels = reinterpret_cast<const std::uint8_t*>(picture_.levels().data());
    bytes_.assign(levels, levels + picture_.levels().size_bytes());
  }
  keeping_ = append();
  if (keeping_) places_.insert_or_assign(index, place);
}

/// Its rows from the first to the last in one go: what lies between them is little or wanted.
bool FrameCache::read_back(const Place& place, const Rect& window, Picture& picture) {
  const std::int64_t row = std::int64_t{place.bytes} * place.window.width;
  bytes_.resize(static_cast<std::size_t>(row * window.height));
  if (::pread(descriptor_, bytes_.data(), bytes_.size(), place.offset + (window.y - place.window.y) * row) !=
      std::ssize(bytes_))
    return false;
  copy_stored({bytes_.data(), row, place.bytes, place.bytes},
              {window.x - place.window.x, 0, window.width, window.height}, picture);
  return true;
}

void FrameCache::fill(std::int64_t index, const Rect& window, Picture& picture) {
  if (const Place* place = find(index, window)) {
    if (read_back(*place, window, picture)) return;
    keeping_ = false;  // the file no longer holds what was written to it
    places_.clear();
  }
  source_.read(index, window, picture);
}

}  // namespace tribotrack::vision
