#include "vision/io/files.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "vision/picture.h"

namespace tribotrack::vision {

void require_readable_file(const std::filesystem::path& path) {
  const std::string name = in_quotes(path);
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0)
    throw InputError(name + " cannot be opened: " + std::strerror(errno) + "; check the path");
  if (S_ISDIR(status.st_mode)) throw InputError(name + " is a folder, not a file");
  if (!S_ISREG(status.st_mode)) throw InputError(name + " is not a regular file; copy the recording to one");
  if (::access(path.c_str(), R_OK) != 0)
    throw InputError(name + " cannot be read: " + std::strerror(errno) + "; check its permissions");
  if (status.st_size == 0) throw InputError(name + " is empty (0 bytes); copy or export the recording again");
}

MappedFile::MappedFile(const std::filesystem::path& path) : path_(path) {
  require_readable_file(path);
  descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor_ < 0) throw InputError(in_quotes(path) + " cannot be opened: " + std::strerror(errno));
  struct stat status {};
  void* data = MAP_FAILED;
  if (::fstat(descriptor_, &status) == 0 && status.st_size > 0) {
    size_ = static_cast<std::uint64_t>(status.st_size);
    data = ::mmap(nullptr, size_, PROT_READ, MAP_SHARED, descriptor_, 0);
  }
  if (data == MAP_FAILED) {
    const std::string reason = std::strerror(errno);
    ::close(descriptor_);
    throw InputError(in_quotes(path) + " cannot be mapped into memory: " + reason);
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
  return bytes_unasked(offset, length, what);
}

std::span<const std::uint8_t> MappedFile::bytes_unasked(std::uint64_t offset, std::uint64_t length,
                                                        std::string_view what) const {
  if (offset > size_ || length > size_ - offset)
    throw InputError(in_quotes(path_) + " is cut short or damaged: " + std::string(what) +
                     " should be at bytes " + std::to_string(offset) + " to " +
                     std::to_string(offset + length) + ", but the file has " + std::to_string(size_) +
                     " bytes; copy or export the recording again");
  return {data_ + offset, static_cast<std::size_t>(length)};
}

void MappedFile::require_unshrunk() const {
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0 || static_cast<std::uint64_t>(status.st_size) < size_)
    throw InputError(in_quotes(path_) + " was cut from " + std::to_string(size_) + " to " +
                     std::to_string(status.st_size) +
                     " bytes while it was being read; wait until no other program writes it and start again");
}

void require_sensible_size(const std::filesystem::path& file, std::int64_t width, std::int64_t height) {
  const bool sides = width > 0 && height > 0 && width <= kLongestSide && height <= kLongestSide;
  if (sides && width * height <= kMostPixels) return;
  throw InputError(in_quotes(file) + " is damaged or too large: it claims a picture of " +
                   std::to_string(width) + " x " + std::to_string(height) + " pixels, where 1 to " +
                   std::to_string(kLongestSide) + " on a side and " + std::to_string(kMostPixels) +
                   " in all are read; copy the recording again, or crop it");
}

void require_sensible_size(const std::filesystem::path& file, std::int64_t width, std::int64_t height,
                           std::uint64_t file_bytes) {
  require_sensible_size(file, width, height);
  constexpr std::uint64_t densest = 2048;  // deflate packs 1032 to 1, LZW somewhat more, JPEG less
  if (static_cast<std::uint64_t>(width * height) / densest > file_bytes)
    throw InputError(in_quotes(file) + " is cut short or damaged: it claims a picture of " +
                     std::to_string(width) + " x " + std::to_string(height) + " pixels, but has only " +
                     std::to_string(file_bytes) + " bytes; copy or export it again");
}

}  // namespace tribotrack::vision
