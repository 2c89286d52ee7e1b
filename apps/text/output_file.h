// Output files that appear whole or not at all.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace tribotrack::apps {

/// Writes `content` under a temporary name beside `path`, then renames. Throws InvalidInput naming the path.
void write_file(const std::filesystem::path& path, std::string_view content);

/// A temporary file beside `path` for writers that need a name of their own (video muxers). commit() renames
/// it to `path`; destroyed without commit(), or on SIGINT/SIGTERM, it and whatever was derived from its name
/// is removed.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::filesystem::path& path);
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const std::filesystem::path& name() const { return temporary_; }
  void commit();

 private:
  std::filesystem::path path_;
  std::filesystem::path temporary_;
};

/// Throws InvalidInput unless a file could be created at `path` (its folder exists and can be written to).
/// For asking before a long computation, not after it.
void require_writable(const std::filesystem::path& path);

/// Creates a folder and its parents. Throws InvalidInput.
void create_folder(const std::filesystem::path& path);

/// From here on SIGINT, SIGTERM and SIGHUP remove the temporary files of this process before it ends.
void clean_up_on_signals();

}  // namespace tribotrack::apps
