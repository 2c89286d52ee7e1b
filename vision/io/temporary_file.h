// Files that appear whole or not at all.
#pragma once

#include <filesystem>

namespace tribotrack::vision {

/// A name beside `target` under which a file is written; commit() renames it to `target`. Destroyed without
/// that, it removes what was written.
class TemporaryFile {
 public:
  /// Throws InputError where no file can be made there (and so before any work is spent on it).
  explicit TemporaryFile(std::filesystem::path target);
  ~TemporaryFile();
  TemporaryFile(TemporaryFile&& other) noexcept;
  TemporaryFile& operator=(TemporaryFile&&) = delete;
  const std::filesystem::path& path() const { return temporary_; }
  const std::filesystem::path& target() const { return target_; }
  /// Throws InputError.
  void commit();

 private:
  std::filesystem::path target_, temporary_;
};

}  // namespace tribotrack::vision
