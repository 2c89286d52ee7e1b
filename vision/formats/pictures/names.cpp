#include "vision/formats/pictures/pictures.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <map>
#include <string_view>
#include <tuple>

#include "vision/picture.h"

namespace tribotrack::vision {
namespace {

namespace fs = std::filesystem;

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

std::string lower_extension(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

std::optional<std::int64_t> to_number(std::string_view digits) {
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error != std::errc{} || end != digits.data() + digits.size()) return std::nullopt;
  return number;
}

/// The last run of digits in a name's stem, which numbers the frames: text before, number, text after.
struct NumberedName {
  std::string before, after;
  std::int64_t number = 0;
};

std::optional<NumberedName> numbered(const fs::path& file) {
  const std::string stem = file.stem().string();
  auto end = stem.size();
  while (end > 0 && !is_digit(stem[end - 1])) --end;
  auto begin = end;
  while (begin > 0 && is_digit(stem[begin - 1])) --begin;
  const auto number = to_number(std::string_view(stem).substr(begin, end - begin));
  if (!number) return std::nullopt;
  return NumberedName{stem.substr(0, begin), stem.substr(end), *number};
}

}  // namespace

std::vector<fs::path> entries(const fs::path& folder) {
  const fs::path here = folder.empty() ? fs::path(".") : folder;
  std::error_code error;
  std::vector<fs::path> files;
  for (fs::directory_iterator entry(here, error), end; !error && entry != end; entry.increment(error))
    if (entry->path().filename().string().front() != '.') files.push_back(entry->path());
  if (error) throw InputError("the folder '" + here.string() + "' cannot be read: " + error.message());
  return files;
}

bool has_tiff_extension(const fs::path& path) {
  const std::string extension = lower_extension(path);
  return extension == ".tif" || extension == ".tiff";
}

bool has_picture_extension(const fs::path& path) {
  static const std::array<std::string, 5> others = {".png", ".bmp", ".jpg", ".jpeg", ".pgm"};
  return has_tiff_extension(path) || std::count(others.begin(), others.end(), lower_extension(path)) > 0;
}

std::optional<NumberPattern> NumberPattern::parse(const fs::path& path) {
  const std::string name = path.filename().string();
  const auto percent = name.find('%');
  if (percent == std::string::npos) return std::nullopt;
  NumberPattern pattern;
  pattern.folder_ = path.parent_path();
  pattern.prefix_ = name.substr(0, percent);
  auto end = percent + 1;
  if (end < name.size() && name[end] == '0') {
    pattern.zeros_ = true;
    ++end;
  }
  const auto digits = end;
  while (end < name.size() && is_digit(name[end])) ++end;
  if (end > digits)
    pattern.width_ = static_cast<std::size_t>(to_number(name.substr(digits, end - digits)).value_or(100));
  const bool is_number = end < name.size() && (name[end] == 'd' || name[end] == 'i' || name[end] == 'u');
  if (!is_number || pattern.width_ > 18 || name.find('%', end) != std::string::npos)
    throw InputError("the pattern '" + path.string() + "' must hold exactly one number such as %05d");
  pattern.suffix_ = name.substr(end + 1);
  return pattern;
}

fs::path NumberPattern::file(std::int64_t number) const {
  std::string digits = std::to_string(number);
  if (digits.size() < width_) digits.insert(0, width_ - digits.size(), zeros_ ? '0' : ' ');
  return folder_ / (prefix_ + digits + suffix_);
}

std::optional<std::int64_t> NumberPattern::number_of(const std::string& name) const {
  if (name.size() <= prefix_.size() + suffix_.size()) return std::nullopt;
  std::string_view digits =
      std::string_view(name).substr(prefix_.size(), name.size() - prefix_.size() - suffix_.size());
  while (!zeros_ && digits.size() > 1 && digits.front() == ' ') digits.remove_prefix(1);
  const auto number = to_number(digits);
  if (!number || *number < 0 || file(*number).filename().string() != name) return std::nullopt;
  return number;
}

namespace {

/// The name of a picture `step` later, its number written as wide.
fs::path next_after(const fs::path& file, std::int64_t step) {
  const auto name = numbered(file);
  if (!name) return file;
  std::string digits = std::to_string(name->number + step);
  const std::size_t width = file.stem().string().size() - name->before.size() - name->after.size();
  if (digits.size() < width) digits.insert(0, width - digits.size(), '0');
  return file.parent_path() / (name->before + digits + name->after + file.extension().string());
}

/// The numbers in the files' names count frames: they step by one, or all by as much where every n-th picture
/// was stored.
void set_numbers(PictureList& list, const std::vector<std::int64_t>& numbers) {
  list.first_number = numbers.front();
  if (numbers.size() < 2) return;
  std::vector<std::int64_t> steps;
  for (std::size_t k = 1; k < numbers.size(); ++k) steps.push_back(numbers[k] - numbers[k - 1]);
  const std::int64_t step = *std::ranges::min_element(steps);
  const auto other = std::ranges::find_if(steps, [&](std::int64_t s) { return s != step; });
  if (other != steps.end()) {
    const auto k = static_cast<std::size_t>(other - steps.begin());
    throw InputError("the sequence has a gap: '" + next_after(list.files[k], step).string() +
                     "' is missing between '" + list.files[k].string() + "' and '" +
                     list.files[k + 1].string() +
                     "', which would spoil the times; restore it or renumber the pictures");
  }
  if (step == 1) return;
  list.first_number = 0;
  list.notes.push_back(
      "the numbers in the file names step by " + std::to_string(step) +
      ": frames are counted from 0, and the rate is that at which these pictures were taken");
}

}  // namespace

PictureList pictures_in_folder(const fs::path& folder) {
  PictureList list;
  for (const fs::path& file : entries(folder))
    if (has_picture_extension(file) && fs::is_regular_file(file)) list.files.push_back(file);
  if (list.files.empty())
    throw InputError(
        "the folder '" + folder.string() +
        "' holds no pictures (png, tif, tiff, bmp, jpg, jpeg, pgm); name the folder of the frames");
  // Their last number orders names that are alike before it: frame9 comes before frame10.
  std::ranges::sort(list.files, {}, [](const fs::path& file) {
    const auto name = numbered(file).value_or(NumberedName{file.stem().string(), "", -1});
    return std::tuple(name.before, name.number, file.filename().string());
  });

  std::vector<std::int64_t> numbers;
  const auto first = numbered(list.files.front());
  for (const fs::path& file : list.files) {
    const auto name = numbered(file);
    if (!first || !name || name->before != first->before || name->after != first->after) return list;
    numbers.push_back(name->number);
  }
  set_numbers(list, numbers);
  return list;
}

PictureList pictures_of_pattern(const NumberPattern& pattern) {
  std::map<std::int64_t, fs::path> found;
  for (const fs::path& file : entries(pattern.folder()))
    if (const auto number = pattern.number_of(file.filename().string())) found[*number] = file;
  if (found.empty())
    throw InputError("no file matches the pattern '" + pattern.file(0).string() +
                     "' (shown for number 0); check folder and pattern");
  PictureList list;
  std::vector<std::int64_t> numbers;
  for (const auto& [number, file] : found) {
    numbers.push_back(number);
    list.files.push_back(file);
  }
  set_numbers(list, numbers);
  return list;
}

}  // namespace tribotrack::vision
