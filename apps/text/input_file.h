// What a command reads: which files, and their content as it was when it was read.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "apps/text/content_hash.h"

namespace tribotrack::apps {

/// An input with the hash of its content, XXH3-128 in hex, taken when it was read.
struct Input {
  std::filesystem::path path;
  std::string xxh3_128;
  std::string hashed = {};  ///< "sample of 18.0 MiB" where not every byte was (content_hash.h); else empty
};

/// Is there such a recording: a file, a folder, or a printf pattern (whose pictures are looked for later)?
bool may_be_recording(const std::filesystem::path& path);

/// By its suffix: what cameras and video tools write.
bool names_a_recording(const std::filesystem::path& path);
/// By its suffix: a single picture, one frame of a series (a TIFF may hold many).
bool names_a_picture(const std::filesystem::path& path);

/// The files of a recording, or the one file that is not one; the path itself where nothing is there.
std::vector<std::filesystem::path> files_of_input(const std::filesystem::path& path);

/// Reads a single file. Throws InvalidInput.
Input hashed_input(const std::filesystem::path& path);
/// Reads all files of a recording, of large ones a sample. Throws InvalidInput, and vision::InputError where
/// there is none.
Input hashed_recording(const std::filesystem::path& path);
/// Of a file whose text was read already.
Input hashed_input(const std::filesystem::path& path, std::string_view text);

/// Size and time of last change of every file of some inputs: cheap to compare after a long computation.
class InputState {
 public:
  InputState() = default;
  explicit InputState(const std::vector<std::filesystem::path>& inputs);
  /// Throws InvalidInput naming the first file that is not as it was.
  void require_unchanged() const;

 private:
  struct File {
    std::filesystem::path path;
    std::uintmax_t size = 0;
    std::filesystem::file_time_type changed;
  };
  static File state_of(const std::filesystem::path& path);
  std::vector<File> files_;
};

}  // namespace tribotrack::apps
