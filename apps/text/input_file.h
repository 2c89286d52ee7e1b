// What a command reads: which files, their hashes, and their content as it was when it was read.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace tribotrack::apps {

// The hash that tells one recording from another.

/// What is read of a large file. Reading all of a recording of gigabytes only to name it takes longer than
/// tracking a disc in it; two different recordings differ in the noise of every picture, so a part of each
/// tells them apart.
struct Sampling {
  std::uint64_t whole_up_to = 32 << 20;  ///< bytes: smaller files are hashed whole
  std::uint64_t ends = 1 << 20;          ///< bytes of the beginning and of the end, hashed always
  std::uint64_t blocks = 256;            ///< spread evenly over what lies between
  std::uint64_t block = 64 << 10;        ///< bytes of each
};

struct ContentHash {
  std::string xxh3_128;             ///< in hex
  std::uint64_t sampled_bytes = 0;  ///< what was read of large files and all smaller ones; 0: every byte
};

/// XXH3-128 of the files' bytes one after the other. Of a file larger than `whole_up_to`, its size and the
/// sample stand for it; where a format keeps what it tells of its pictures (times above all) before them,
/// that is hashed whole. Throws InvalidInput where a file cannot be read.
ContentHash hash_of_files(const std::vector<std::filesystem::path>& files, const Sampling& sampling);

std::string hash_of_text(std::string_view text);

// What a command reads: which files, and their content as it was when it was read.

/// An input with the hash of its content, XXH3-128 in hex, taken when it was read.
struct Input {
  std::filesystem::path path;
  std::string xxh3_128;
  std::string hashed = {};  ///< "sample of 18.0 MiB" where not every byte was (Sampling); else empty
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

// What a user meant by a text that is no TOML.

/// ": is ...; save it as UTF-8", to follow the file's name, where a text is in another encoding or is no text
/// at all; with ":LINE:COLUMN" before it where one character shows it. Empty for UTF-8.
std::string encoding_slip(std::string_view text);

/// What is wrong at this place, at which the parser gave up, and what to write. `description`: the parser's
/// words, of which only a key that is given twice is used.
std::string toml_slip(std::string_view text, std::size_t line, std::size_t column,
                      std::string_view description);

/// Each dot in a key such as `fit.prior.mu1` is a table in a table, and the library follows and frees these
/// by calling itself: thousands of them would fill the stack. Throws InvalidInput with file, line and column.
void require_shallow_keys(std::string_view text, const std::string& name);

}  // namespace tribotrack::apps
