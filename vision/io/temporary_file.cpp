#include "vision/io/temporary_file.h"

#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <mutex>
#include <set>
#include <string>
#include <utility>

#include "vision/frame_sink.h"
#include "vision/io/in_quotes.h"
#include "vision/picture.h"

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

}  // namespace

TemporaryFile::TemporaryFile(std::filesystem::path target) : target_(std::move(target)) {
  static std::atomic<unsigned> serial{0};
  std::error_code error;
  if (std::filesystem::is_directory(target_, error))
    throw OutputError(in_quotes(target_) + " cannot be written: it is a folder; give a file name");
  std::string name(".");
  name +=
      target_.filename().string() + ".partial-" + std::to_string(::getpid()) + "-" + std::to_string(serial++);
  temporary_ = target_.parent_path() / name;
  PartialFiles::of_this_process().add(temporary_);
  errno = 0;
  if (!std::ofstream(temporary_, std::ios::binary)) {
    const std::string reason = errno != 0 ? std::strerror(errno) : "no such folder";
    PartialFiles::of_this_process().forget(temporary_);
    refuse(reason);
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

void TemporaryFile::write(std::span<const unsigned char> bytes) const {
  errno = 0;
  std::ofstream file(temporary_, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
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
