// Files as they are read, and files that appear whole or not at all.
#include "vision/io/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <mutex>
#include <random>
#include <set>

#include "vision/temporary_file.h"

namespace tribotrack::vision {

void require_readable_file(const std::filesystem::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0)
    refuse(path, "cannot be opened: {}", with_remedy(errno, "check the path"));
  if (S_ISDIR(status.st_mode)) refuse(path, "is a folder, not a file");
  if (!S_ISREG(status.st_mode)) refuse(path, "is not a regular file; copy the recording to one");
  if (::access(path.c_str(), R_OK) != 0)
    refuse(path, "cannot be read: {}", with_remedy(errno, "check its permissions"));
  if (status.st_size == 0) refuse(path, "is empty (0 bytes); copy or export the recording again");
}

MappedFile::MappedFile(const std::filesystem::path& path) : path_(path) {
  require_readable_file(path);
  descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor_ < 0) refuse(path, "cannot be opened: {}", with_remedy(errno, "check its permissions"));
  struct stat status {};
  void* data = MAP_FAILED;
  if (::fstat(descriptor_, &status) == 0 && status.st_size > 0) {
    size_ = static_cast<std::uint64_t>(status.st_size);
    data = ::mmap(nullptr, size_, PROT_READ, MAP_SHARED, descriptor_, 0);
  }
  if (data == MAP_FAILED) {
    const std::string reason = with_remedy(errno, "copy it to a local disk");
    ::close(descriptor_);
    refuse(path, "cannot be mapped into memory: {}", reason);
  }
  data_ = static_cast<const std::uint8_t*>(data);
}

MappedFile::~MappedFile() {
  ::munmap(const_cast<std::uint8_t*>(data_), size_);
  ::close(descriptor_);
}

std::span<const std::uint8_t> MappedFile::bytes(std::uint64_t offset, std::uint64_t length,
                                                std::string_view what) const {
  require_unshrunk();
  if (offset > size_ || length > size_ - offset)
    refuse(path_,
           "is cut short or damaged: {} should be at bytes {} to {}, but the file has {} bytes; copy or "
           "export the recording again",
           what, offset, offset + length, size_);
  return {data_ + offset, static_cast<std::size_t>(length)};
}

void MappedFile::require_unshrunk() const {
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0 || static_cast<std::uint64_t>(status.st_size) < size_)
    refuse(path_,
           "was cut from {} to {} bytes while it was being read; wait until no other program writes it and "
           "start again",
           size_, status.st_size);
}

void MappedFile::done_with(std::uint64_t length) {
  require_unshrunk();
  constexpr std::uint64_t kMostHeld = 128 << 20;
  held_ += length;
  if (held_ < kMostHeld) return;
  ::madvise(const_cast<std::uint8_t*>(data_), size_, MADV_DONTNEED);
  held_ = 0;
}

void require_sensible_size(const std::filesystem::path& file, std::int64_t width, std::int64_t height) {
  const bool sides = width > 0 && height > 0 && width <= kLongestSide && height <= kLongestSide;
  if (sides && width * height <= kMostPixels) return;
  refuse(file,
         "is damaged or too large: it claims a picture of {} x {} pixels, where 1 to {} on a side and {} in "
         "all are read; copy the recording again, or crop it",
         width, height, kLongestSide, kMostPixels);
}

void require_sensible_size(const std::filesystem::path& file, std::int64_t width, std::int64_t height,
                           std::uint64_t file_bytes) {
  require_sensible_size(file, width, height);
  constexpr std::uint64_t densest = 2048;  // deflate packs 1032 to 1, LZW somewhat more, JPEG less
  if (static_cast<std::uint64_t>(width * height) / densest > file_bytes)
    refuse(file,
           "is cut short or damaged: it claims a picture of {} x {} pixels, but has only {} bytes; copy or "
           "export it again",
           width, height, file_bytes);
}

namespace {

/// Every unfinished file of this process: an interrupted program has to remove them, whoever writes them.
struct PartialFiles {
  std::mutex mutex;
  std::set<std::filesystem::path> paths;
};
PartialFiles& partial_files() {
  static auto& files = *new PartialFiles;  // never destroyed: files may be removed while the process ends
  return files;
}
void note(const std::filesystem::path& path, bool unfinished) {
  const std::lock_guard lock(partial_files().mutex);
  if (unfinished)
    partial_files().paths.insert(path);
  else
    partial_files().paths.erase(path);
}

constexpr const char* kMakeRoom = "make room, or choose another folder";

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
  std::error_code error;
  if (std::filesystem::is_directory(target_, error))
    throw OutputError(in_quotes(target_) + " cannot be written: it is a folder; give a file name");
  // Nobody can have put a link where the name is not to be foreseen, and none is followed.
  std::random_device random;
  for (;;) {
    const std::uint64_t number = std::uint64_t{random()} << 32 | random();
    temporary_ = target_.parent_path() /
                 fmt::format(".{}{}{}-{:016x}", target_.filename().string(), kMark, ::getpid(), number);
    note(temporary_, true);
    const int descriptor =
        ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (descriptor >= 0) {
      struct stat status {};
      if (::fstat(descriptor, &status) == 0) inode_ = status.st_ino;
      ::close(descriptor);
      return;
    }
    const int reason = errno;
    note(temporary_, false);
    if (reason != EEXIST) refuse(reason);
  }
}

TemporaryFile::TemporaryFile(TemporaryFile&& other) noexcept
    : target_(std::move(other.target_)),
      temporary_(std::exchange(other.temporary_, {})),
      inode_(other.inode_) {}

TemporaryFile::~TemporaryFile() {
  if (temporary_.empty()) return;
  std::error_code ignored;
  std::filesystem::remove(temporary_, ignored);
  note(temporary_, false);
}

/// Throws OutputError where it is not the file that was made.
TemporaryFile::Open TemporaryFile::open(int flags) const {
  Open file{::open(temporary_.c_str(), flags | O_NOFOLLOW | O_CLOEXEC)};
  if (file.descriptor < 0) refuse(errno);
  struct stat status {};
  if (::fstat(file.descriptor, &status) != 0 || status.st_ino != inode_ || !S_ISREG(status.st_mode))
    refuse("another file was put in place of its unfinished one");
  return file;
}

TemporaryFile::Open::~Open() {
  if (descriptor >= 0) ::close(descriptor);
}

void TemporaryFile::write(std::string_view bytes) const {
  const Open file = open(O_WRONLY | O_TRUNC);
  while (!bytes.empty()) {
    const ::ssize_t count = ::write(file.descriptor, bytes.data(), bytes.size());
    if (count < 0 && errno != EINTR) refuse(errno);
    if (count > 0) bytes.remove_prefix(static_cast<std::size_t>(count));
  }
}

/// On the disk before it has its name, so that a power cut leaves the old file or the new one.
void TemporaryFile::commit() {
  {
    const Open file = open(O_RDONLY);
    struct stat before {};
    if (::stat(target_.c_str(), &before) == 0 && S_ISREG(before.st_mode)) {
      [[maybe_unused]] const int not_allowed = ::fchown(file.descriptor, before.st_uid, before.st_gid);
      ::fchmod(file.descriptor, before.st_mode & 07777);
    }
    if (::fsync(file.descriptor) != 0 && errno != EINVAL && errno != EROFS) refuse(errno);
  }
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) refuse(errno);
  note(temporary_, false);
  temporary_.clear();
  const std::filesystem::path folder = target_.has_parent_path() ? target_.parent_path() : ".";
  const Open named{::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
  if (named.descriptor >= 0) ::fsync(named.descriptor);
}

void TemporaryFile::refuse(const std::string& reason) const {
  throw OutputError(in_quotes(target_) + " cannot be written: " + reason + "; " + kMakeRoom);
}

void TemporaryFile::refuse(int error) const {
  throw OutputError(in_quotes(target_) + " cannot be written: " + with_remedy(error, kMakeRoom));
}

std::string with_remedy(int error, const std::string& otherwise) {
  const std::string remedy =
      error == EMFILE || error == ENFILE
          ? "allow more open files (ulimit -n 4096), or do less at once (--threads 1)"
      : error == EFBIG  ? "allow larger files (ulimit -f unlimited), or choose a file system that takes them"
      : error == ENOMEM ? "give the process more memory, or do less at once (--threads 1)"
      : error == EDQUOT ? "your quota is used up: make room, or choose another disk"
      : error == ENAMETOOLONG ? "give a shorter name"
                              : otherwise;
  return std::string(std::strerror(error)) + "; " + remedy;
}

void remove_partial_files() {
  const std::lock_guard lock(partial_files().mutex);
  std::error_code ignored;
  // Twice: meanwhile another thread may have opened one of them again.
  for (int round = 0; round < 2; ++round)
    for (const std::filesystem::path& path : partial_files().paths) std::filesystem::remove(path, ignored);
}

}  // namespace tribotrack::vision
