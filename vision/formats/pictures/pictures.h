// Image sequences and TIFF stacks as sources and sinks of frames.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "vision/frame_sink.h"
#include "vision/frame_source.h"

namespace tribotrack::vision {

// Which picture files make up a recording, and in which order.

/// The files of a folder but the hidden ones. Throws InputError.
std::vector<std::filesystem::path> entries(const std::filesystem::path& folder);

/// png, tif, tiff, bmp, jpg, jpeg or pgm, in upper or lower case.
bool has_picture_extension(const std::filesystem::path& path);
bool has_tiff_extension(const std::filesystem::path& path);

/// A printf pattern in the file's name, such as "dir/%05d.png": one %d, %i or %u with an optional width.
class NumberPattern {
 public:
  /// Nothing where the name holds no conversion. Throws InputError where it holds one that is not a number.
  static std::optional<NumberPattern> parse(const std::filesystem::path& path);
  std::filesystem::path folder() const { return folder_; }
  std::filesystem::path file(std::int64_t number) const;
  /// The number with which the pattern makes `name`, if any.
  std::optional<std::int64_t> number_of(const std::string& name) const;

 private:
  std::filesystem::path folder_;
  std::string prefix_, suffix_;
  std::size_t width_ = 0;
  bool zeros_ = false;
};

struct PictureList {
  std::vector<std::filesystem::path> files;
  std::int64_t first_number = 0;
  std::vector<std::string> notes;
};

/// The pictures in a folder, ordered by the last number in their names: frame9 comes before frame10. Names
/// that differ only in one running number give the first number; a missing one is an InputError: times count
/// frames.
PictureList pictures_in_folder(const std::filesystem::path& folder);

/// The pictures a pattern finds, from the lowest number on; the same holds for their numbers.
PictureList pictures_of_pattern(const NumberPattern& pattern);

// Image sequences and TIFF stacks as sources of frames.

/// One file per frame, all of the size of the first; checked when a frame is read. 8 or 16 bits; colour is
/// handed out as luma. Pictures never state a capture rate: the time base is the user's or unknown.
std::unique_ptr<FrameSource> open_picture_sequence(const std::filesystem::path& path, PictureList pictures,
                                                   const SourceOptions& options);

/// A multi-page TIFF, one page per frame; a single picture is a stack of one.
std::unique_ptr<FrameSource> open_picture_stack(const std::filesystem::path& path,
                                                const SourceOptions& options);

// Writing PNG and TIFF sequences.

/// By a printf pattern, numbered from 0; a name without a pattern takes a single picture. 8 bits go into
/// 8-bit files, 10 and 12 bits as they are into 16-bit ones. Pictures of an earlier, longer sequence under
/// the same pattern are removed at close(): the two would read as one.
std::unique_ptr<FrameSink> create_picture_sink(const std::filesystem::path& path, const SinkOptions& options);

}  // namespace tribotrack::vision
