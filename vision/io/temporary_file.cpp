#include "vision/io/temporary_file.h"

#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>
#include <utility>

#include "vision/io/in_quotes.h"
#include "vision/picture.h"

namespace tribotrack::vision {

TemporaryFile::TemporaryFile(std::filesystem::path target) : target_(std::move(target)) {
  static std::atomic<unsigned> serial{0};
  std::error_code error;
  if (std::filesystem::is_directory(target_, error))
    throw InputError(in_quotes(target_) + " cannot be written: it is a folder; give a file name");
  std::string name(".");
  name +=
      target_.filename().string() + ".partial-" + std::to_string(::getpid()) + "-" + std::to_string(serial++);
  temporary_ = target_.parent_path() / name;
  errno = 0;
  if (!std::ofstream(temporary_, std::ios::binary)) {
    const std::string reason = errno != 0 ? std::strerror(errno) : "no such folder";
    throw InputError(in_quotes(target_) + " cannot be written: " + reason + "; choose another folder");
  }
}

TemporaryFile::TemporaryFile(TemporaryFile&& other) noexcept
    : target_(std::move(other.target_)), temporary_(std::exchange(other.temporary_, {})) {}

TemporaryFile::~TemporaryFile() {
  std::error_code ignored;
  if (!temporary_.empty()) std::filesystem::remove(temporary_, ignored);
}

void TemporaryFile::commit() {
  std::error_code error;
  std::filesystem::rename(temporary_, target_, error);
  if (error) throw InputError(in_quotes(target_) + " cannot be written: " + error.message());
  temporary_.clear();
}

}  // namespace tribotrack::vision
