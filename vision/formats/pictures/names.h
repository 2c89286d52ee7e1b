// Which picture files make up a recording, and in which order.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace tribotrack::vision {

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

}  // namespace tribotrack::vision
