#include "vision/temporary_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <mutex>
#include <set>
#include <string>
#include <utility>

#include "vision/io/files.h"

namespace tribotrack::vision {
namespace {

/// Every unfinished file of this process: an interrupted program has to remove them, whoever writes them.
class PartialFiles {
 public:
  static PartialFiles& of_this_process() {
    static auto& files = *new PartialFiles;  // never destroyed: files may be removed while the process ends
    return files;
  }
  void add(const std::filesystem::path& path) {
    const std::lock_guard lock(mutex_);
    paths_.insert(path);
  }
  void forget(const std::filesystem::path& path) {
    const std::lock_guard lock(mutex_);
    paths_.erase(path);
  }
  /// Twice: meanwhile another thread may have opened one of them again.
  void remove_all() {
    const std::lock_guard lock(mutex_);
    std::error_code ignored;
    for (int round = 0; round < 2; ++round)
      for (const std::filesystem::path& path : paths_) std::filesystem::remove(path, ignored);
  }

 private:
  std::mutex mutex_;
  std::set<std::filesystem::path> paths_;
};

/// Where writing to `path` really ends.
std::filesystem::path end_of_links(std::filesystem::path path) {
  std::error_code error;
  for (int k = 0; k < 40 && std::filesystem::is_symlink(std::filesystem::symlink_status(path, error)); ++k) {
    const std::filesystem::path next = std::filesystem::read_symlink(path, error);
    if (error) break;
    path = next.is_absolute() ? next : path.parent_path() / next;
  }
  return path;
}

}  // namespace

TemporaryFile::TemporaryFile(const std::filesystem::path& target) : target_(end_of_links(target)) {
  static std::atomic<unsigned> serial{0};
  std::error_code error;
  if (std::filesystem::is_directory(target_, error))
    throw OutputError(in_quotes(target_) + " cannot be written: it is a folder; give a file name");
  // A name that is there already is somebody else's file, or a link that leads to one.
  for (;;) {
    temporary_ = target_.parent_path() /
                 fmt::format(".{}{}{}-{}", target_.filename().string(), kMark, ::getpid(), ++serial);
    PartialFiles::of_this_process().add(temporary_);
    const int descriptor = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor >= 0) {
      ::close(descriptor);
      return;
    }
    PartialFiles::of_this_process().forget(temporary_);
    if (errno != EEXIST) refuse(std::strerror(errno));
  }
}

TemporaryFile::TemporaryFile(TemporaryFile&& other) noexcept
    : target_(std::move(other.target_)), temporary_(std::exchange(other.temporary_, {})) {}

TemporaryFile::~TemporaryFile() {
  if (temporary_.empty()) return;
  std::error_code ignored;
  std::filesystem::remove(temporary_, ignored);
  PartialFiles::of_this_process().forget(temporary_);
}

void TemporaryFile::write(std::string_view bytes) const {
  errno = 0;
  std::ofstream file(temporary_, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) refuse(std::strerror(errno != 0 ? errno : ENOSPC));
}

void TemporaryFile::commit() {
  std::error_code error;
  std::filesystem::rename(temporary_, target_, error);
  if (error) refuse(error.message());
  PartialFiles::of_this_process().forget(temporary_);
  temporary_.clear();
}

void TemporaryFile::refuse(const std::string& reason) const {
  throw OutputError(in_quotes(target_) + " cannot be written: " + reason +
                    "; make room, or choose another folder");
}

void remove_partial_files() {
  PartialFiles::of_this_process().remove_all();
}

}  // namespace tribotrack::vision
