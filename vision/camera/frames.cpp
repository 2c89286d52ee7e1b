// Frames of a recording that were decoded once are kept.
#include <linux/magic.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

#include "vision/camera/frame_cache.h"
#include "vision/io/levels.h"
#include "vision/kernels/vector_kernels.h"

namespace tribotrack::vision {
namespace {

namespace fs = std::filesystem;

std::int64_t free_in(const fs::path& folder) {
  std::error_code error;
  const fs::space_info space = fs::space(folder, error);
  return error ? 0 : static_cast<std::int64_t>(space.available);
}

}  // namespace

CacheSpace::CacheSpace(fs::path folder, std::function<std::int64_t()> free_bytes, std::int64_t most_bytes)
    : folder_(std::move(folder)), free_bytes_(std::move(free_bytes)), most_bytes_(most_bytes) {}

CacheSpace& CacheSpace::of_this_process() {
  static const fs::path folder = [] {
    std::error_code error;
    const std::array<fs::path, 2> folders = {fs::temp_directory_path(error), "/var/tmp"};
    return choose_cache_folder(folders);
  }();
  static CacheSpace space(
      folder, [] { return free_in(folder); },
      is_in_memory(folder) ? kMostInMemory : std::numeric_limits<std::int64_t>::max());
  return space;
}

bool CacheSpace::take(std::int64_t bytes) {
  const std::lock_guard lock(mutex_);
  // What the caches hold is no longer free: what was free before is the sum.
  const std::int64_t before = free_bytes_() + taken_;
  if (taken_ + bytes > std::min(before / 2, most_bytes_)) return false;
  taken_ += bytes;
  return true;
}

void CacheSpace::give_back(std::int64_t bytes) {
  const std::lock_guard lock(mutex_);
  taken_ -= bytes;
}

bool is_in_memory(const fs::path& folder) {
  struct statfs system {};
  if (::statfs(folder.c_str(), &system) != 0) return false;
  return system.f_type == TMPFS_MAGIC || system.f_type == RAMFS_MAGIC;
}

fs::path choose_cache_folder(std::span<const fs::path> folders) {
  for (const fs::path& folder : folders)
    if (!is_in_memory(folder) && ::access(folder.c_str(), W_OK | X_OK) == 0) return folder;
  return folders.front();
}

namespace {

/// The fewest bytes that hold these levels exactly.
TRIBOTRACK_CLONES int bytes_for(std::span<const float> levels) {
  float largest = 0, off = 0;
  for (const float level : levels) {
    // Out of an integer's range no level is whole here.
    const float nearby = level < 0 ? 0.0F : level > 65535 ? 65535.0F : level;
    const float beside = std::abs(level - static_cast<float>(static_cast<std::int32_t>(nearby)));
    off = beside > off ? beside : off;
    largest = level > largest ? level : largest;
  }
  if (!(off == 0)) return 4;
  return largest <= 255 ? 1 : 2;
}

TRIBOTRACK_CLONES void narrow(std::span<const float> levels, std::uint8_t* to) {
  for (std::size_t i = 0; i < levels.size(); ++i) to[i] = static_cast<std::uint8_t>(levels[i]);
}
TRIBOTRACK_CLONES void narrow_16(std::span<const float> levels, std::uint8_t* to) {
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const auto level = static_cast<std::uint16_t>(levels[i]);
    std::memcpy(to + 2 * i, &level, sizeof level);
  }
}

bool write_all(int descriptor, const std::vector<std::uint8_t>& bytes, std::int64_t offset) {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t wrote = ::pwrite(descriptor, bytes.data() + done, bytes.size() - done,
                                   static_cast<off_t>(offset) + static_cast<off_t>(done));
    if (wrote <= 0) return false;
    done += static_cast<std::size_t>(wrote);
  }
  return true;
}

}  // namespace

FrameCache::FrameCache(FrameSource& source, std::int64_t most_bytes, CacheSpace& space)
    : source_(source), most_bytes_(most_bytes), space_(space), keeping_(source.info().decoded) {
  info_ = source.info();
}

FrameCache::~FrameCache() {
  if (descriptor_ >= 0) ::close(descriptor_);
  space_.give_back(end_);
}

/// The file has no name: it is gone when the process ends, however it ends.
bool FrameCache::open_file() {
  if (descriptor_ >= 0) return true;
  std::string name = (space_.folder() / "tribotrack-frames-XXXXXX").string();
  descriptor_ = ::mkstemp(name.data());
  if (descriptor_ < 0) return false;
  ::unlink(name.c_str());
  return true;
}

/// The file no longer holds what was written to it: everything is read from the source again.
void FrameCache::give_up() {
  keeping_ = false;
  places_.clear();
}

const FrameCache::Place* FrameCache::find(std::int64_t index, const Rect& window) const {
  const auto found = places_.find(index);
  return found != places_.end() && found->second.window.contains(window) ? &found->second : nullptr;
}

void FrameCache::keep(std::int64_t index, const Rect& window) {
  if (!keeping_ || window.width <= 0 || window.height <= 0 || find(index, window)) return;
  source_.read(index, window, picture_);
  Place place{window, end_, bytes_for(picture_.levels())};
  bytes_.resize(picture_.levels().size() * static_cast<std::size_t>(place.bytes));
  if (place.bytes == 1)
    narrow(picture_.levels(), bytes_.data());
  else if (place.bytes == 2)
    narrow_16(picture_.levels(), bytes_.data());
  else
    std::memcpy(bytes_.data(), picture_.levels().data(), bytes_.size());
  const auto size = static_cast<std::int64_t>(bytes_.size());
  if (end_ + size > most_bytes_ || !space_.take(size)) {
    keeping_ = false;
    return;
  }
  const std::int64_t offset = std::exchange(end_, end_ + size);
  if (open_file() && write_all(descriptor_, bytes_, offset))
    places_.insert_or_assign(index, place);
  else
    keeping_ = false;
}

/// Its rows from the first to the last in one go: what lies between them is little or wanted.
bool FrameCache::read_back(const Place& place, const Rect& window, Picture& picture) {
  const auto level_bytes = static_cast<std::size_t>(place.bytes);
  const std::size_t row_bytes = level_bytes * static_cast<std::size_t>(place.window.width);
  const auto top = static_cast<std::size_t>(window.y - place.window.y);
  const auto left = static_cast<std::size_t>(window.x - place.window.x) * level_bytes;
  bytes_.resize(row_bytes * static_cast<std::size_t>(window.height));
  std::int64_t from = place.offset + static_cast<std::int64_t>(top * row_bytes);
  for (std::size_t done = 0; done < bytes_.size();) {
    const ssize_t got = ::pread(descriptor_, bytes_.data() + done, bytes_.size() - done, from);
    if (got <= 0) return false;
    done += static_cast<std::size_t>(got);
    from += got;
  }
  for (int y = 0; y < window.height; ++y) {
    const std::uint8_t* row = bytes_.data() + static_cast<std::size_t>(y) * row_bytes + left;
    const std::span<float> levels = picture.row(y);
    if (place.bytes == 1)
      copy_levels(row, levels);
    else if (place.bytes == 2)
      copy_levels_16(row, levels);
    else
      std::memcpy(levels.data(), row, levels.size_bytes());
  }
  return true;
}

void FrameCache::read(std::int64_t index, const Rect& window, Picture& picture) {
  if (const Place* place = find(index, window)) {
    prepare_window(info_, index, window, picture);
    if (read_back(*place, window, picture)) return;
    give_up();
  }
  source_.read(index, window, picture);
}

}  // namespace tribotrack::vision
