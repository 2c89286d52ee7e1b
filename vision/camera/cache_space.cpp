#include "vision/camera/cache_space.h"

#include <linux/magic.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <array>
#include <limits>
#include <utility>

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

}  // namespace tribotrack::vision
