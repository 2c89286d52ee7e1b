// What a command reads: files with their hashes, JSON, and what a user meant by a text that is no TOML.
#include "apps/text/input_file.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <boost/locale/utf.hpp>
#include <cerrno>
#include <cstdio>
#include <fstream>
#include <limits>
#include <memory>
#include <string_view>

#include "apps/program/errors.h"
#include "apps/text/angle.h"
#include "apps/text/json.h"
#include "apps/text/strict_toml.h"
#include "vision/frame_source.h"
#include "vision/temporary_file.h"

namespace tribotrack::apps {

namespace {

namespace fs = std::filesystem;

std::string hex(const XXH128_hash_t& hash) {
  return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

class Hasher {
 public:
  Hasher() { XXH3_128bits_reset(state_.get()); }

  void add(const fs::path& path, const Sampling& sampling) {
    errno = 0;
    std::ifstream stream(path, std::ios::binary);
    if (!stream)
      throw InvalidInput("{}: cannot be read: {}", path.string(),
                         vision::with_remedy(errno, "check its name and permissions"));
    std::error_code not_known;
    const std::uint64_t size = fs::file_size(path, not_known);
    if (not_known || size <= sampling.whole_up_to)
      add_range(stream, 0, std::numeric_limits<std::uint64_t>::max());
    else
      add_sample(stream, size, vision::bytes_before_pictures(path), sampling);
  }

  ContentHash result() const { return {hex(XXH3_128bits_digest(state_.get())), sampled_ ? bytes_ : 0}; }

 private:
  void add_sample(std::ifstream& stream, std::uint64_t size, std::uint64_t head, const Sampling& sampling) {
    sampled_ = true;
    XXH3_128bits_update(state_.get(), &size, sizeof size);
    const std::uint64_t begin = std::min(size, std::max(sampling.ends, head));
    const std::uint64_t end = std::max(begin, size - std::min(size, sampling.ends));
    add_range(stream, 0, begin);
    if (end - begin <= sampling.blocks * sampling.block) {
      add_range(stream, begin, end);
    } else {
      const std::uint64_t room = end - begin - sampling.block, steps = sampling.blocks - 1;
      for (std::uint64_t k = 0; k <= steps; ++k) {
        const std::uint64_t at = begin + room / steps * k + room % steps * k / steps;
        add_range(stream, at, at + sampling.block);
      }
    }
    add_range(stream, end, size);
  }

  /// What of [begin, end) the file has.
  void add_range(std::ifstream& stream, std::uint64_t begin, std::uint64_t end) {
    stream.clear();
    stream.seekg(static_cast<std::streamoff>(begin));
    while (begin < end) {
      stream.read(buffer_.data(),
                  static_cast<std::streamsize>(std::min<std::uint64_t>(buffer_.size(), end - begin)));
      const auto count = static_cast<std::size_t>(stream.gcount());
      if (count == 0) return;
      XXH3_128bits_update(state_.get(), buffer_.data(), count);
      begin += count;
      bytes_ += count;
    }
  }

  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state_{XXH3_createState(), &XXH3_freeState};
  std::vector<char> buffer_ = std::vector<char>(1 << 18);
  std::uint64_t bytes_ = 0;
  bool sampled_ = false;
};

}  // namespace

ContentHash hash_of_files(const std::vector<fs::path>& files, const Sampling& sampling) {
  Hasher hasher;
  for (const fs::path& file : files) hasher.add(file, sampling);
  return hasher.result();
}

std::string hash_of_text(std::string_view text) {
  return hex(XXH3_128bits(text.data(), text.size()));
}

namespace {

std::string suffix_of(const std::filesystem::path& path) {
  return lower(path.extension().string());
}

}  // namespace

bool names_a_recording(const std::filesystem::path& path) {
  constexpr std::array<std::string_view, 16> kVideos = {".cine", ".mraw", ".mp4",  ".m4v", ".avi",  ".mkv",
                                                        ".mov",  ".webm", ".wmv",  ".mpg", ".mpeg", ".mts",
                                                        ".ts",   ".y4m",  ".tiff", ".tif"};
  return std::ranges::find(kVideos, suffix_of(path)) != kVideos.end() || names_a_picture(path);
}

bool names_a_picture(const std::filesystem::path& path) {
  constexpr std::array<std::string_view, 5> kPictures = {".png", ".bmp", ".jpeg", ".jpg", ".pgm"};
  return std::ranges::find(kPictures, suffix_of(path)) != kPictures.end();
}

bool may_be_recording(const fs::path& path) {
  return fs::exists(path) || vision::is_number_pattern(path);
}

std::vector<fs::path> files_of_input(const fs::path& path) {
  try {
    if (may_be_recording(path)) return vision::files_of_recording(path);
  } catch (const vision::InputError&) {  // reported by the code that opens it
  }
  return {path};
}

Input hashed_input(const fs::path& path) {
  constexpr Sampling kWhole{.whole_up_to = std::numeric_limits<std::uint64_t>::max()};
  return {path, hash_of_files({path}, kWhole).xxh3_128};
}

Input hashed_recording(const fs::path& path) {
  const ContentHash hash = hash_of_files(vision::files_of_recording(path), {});
  Input input{path, hash.xxh3_128};
  if (hash.sampled_bytes > 0)
    input.hashed = fmt::format("sample of {:.1f} MiB", static_cast<double>(hash.sampled_bytes) / (1 << 20));
  return input;
}

Input hashed_input(const fs::path& path, std::string_view text) {
  return {path, hash_of_text(text)};
}

InputState::InputState(const std::vector<fs::path>& inputs) {
  for (const fs::path& input : inputs)
    for (const fs::path& file : files_of_input(input)) files_.push_back(state_of(file));
}

InputState::File InputState::state_of(const fs::path& path) {
  std::error_code error;
  File file{path, fs::file_size(path, error), {}};
  file.changed = fs::last_write_time(path, error);
  return file;
}

void InputState::require_unchanged() const {
  for (const File& before : files_) {
    const File now = state_of(before.path);
    if (now.size != before.size || now.changed != before.changed)
      throw InvalidInput(
          "{}: changed while it was being read; start again once it is complete (is it still being copied?)",
          before.path.string());
  }
}

namespace {

/// By the first bytes: Phantom, MP4 and MOV, AVI, Matroska.
bool is_recording(std::string_view text) {
  return text.starts_with("CI") || text.substr(std::min<std::size_t>(4, text.size()), 4) == "ftyp" ||
         text.starts_with("RIFF") || text.starts_with("\x1a\x45\xdf\xa3");
}

std::string_view line_of(std::string_view text, std::size_t number) {
  for (; number > 1 && !text.empty(); --number)
    text.remove_prefix(
        std::min(text.size(), text.find('\n') == text.npos ? text.size() : text.find('\n') + 1));
  text = text.substr(0, text.find('\n'));
  while (!text.empty() && (text.back() == '\r' || text.back() == ' ')) text.remove_suffix(1);
  return text;
}

}  // namespace

std::string encoding_slip(std::string_view text) {
  if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff"))
    return ": is a text in UTF-16, as Windows' editors save it; save it as UTF-8";
  if (text.substr(0, 4096).find('\0') != text.npos)
    return is_recording(text)
               ? ": is a recording; name it as `video` in a campaign (`tribotrack init DIR` writes one)"
               : ": is no text file; check its name";
  std::size_t line = 1, column = 1;
  for (const char* at = text.data(); at != text.data() + text.size(); ++column) {
    using Utf8 = boost::locale::utf::utf_traits<char>;
    const auto character = Utf8::decode(at, text.data() + text.size());
    if (character == boost::locale::utf::illegal || character == boost::locale::utf::incomplete)
      return fmt::format(
          ":{}:{}: the character here is not UTF-8 (an umlaut or a sign in Latin-1?); save it as UTF-8", line,
          column);
    if (character == '\n') ++line, column = 0;
  }
  return "";
}

std::string toml_slip(std::string_view text, std::size_t number, std::size_t column,
                      std::string_view description) {
  if (const auto redefined = description.find("redefin"); redefined != description.npos) {
    const auto begin = std::min(description.find('\'', redefined), description.size() - 1) + 1;
    return fmt::format("`{}` is given twice; take one of them out",
                       description.substr(begin, description.find('\'', begin) - begin));
  }
  return fmt::format(
      "`{}` cannot be read from column {} on: write KEY = VALUE, [TABLE] or # COMMENT; numbers with a point "
      "and without a unit (0.28), texts in quotes (\"a.cine\", folders divided by /), brackets and quotes "
      "closed",
      line_of(text, number).substr(0, 60), column);
}

void require_shallow_keys(std::string_view text, const std::string& name) {
  constexpr int kDeepest = 32;
  int line = 1, dots = 0;
  std::size_t line_begin = 0, key_begin = 0;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at];
    if (c == '.' && at > 0 && text[at - 1] != '.') {  // "..." is no key
      if (++dots < kDeepest) continue;
      throw InvalidInput("{}:{}:{}: a key of more than {} parts; keys here have at most 3", name, line,
                         key_begin - line_begin + 1, kDeepest);
    }
    if ((c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '-' ||
        c == '"' || c == '\'' || c == ' ' || c == '\t')
      continue;  // it may stand in a key
    dots = 0;
    key_begin = at + 1;
    if (c != '\n') continue;
    ++line;
    line_begin = at + 1;
  }
}

namespace {

[[noreturn]] void refuse(const std::string& place, std::string_view what) {
  throw InvalidInput("{}: is no JSON: {}; correct it, or make the file anew with the command that wrote it",
                     place, what);
}

/// Of "[json.exception.parse_error.101] parse error at line 2, column 8: syntax error ...".
[[noreturn]] void refuse_as(std::string_view said, const std::string& name) {
  constexpr std::size_t kLongest = 200;  // it repeats what was read last
  int line = 0, column = 0;
  const auto at = std::min(said.find("at line "), said.size());
  if (std::sscanf(said.data() + at, "at line %d, column %d", &line, &column) != 2)
    refuse(name, said.substr(said.find(' ') + 1, kLongest));
  refuse(fmt::format("{}:{}:{}", name, line, column), said.substr(said.find(": ", at) + 2, kLongest));
}

/// Values that nest too deeply would fill the stack where they are copied; each name of an object is
/// compared with all others.
Json parse_json(std::string_view text, const std::string& name) {
  constexpr int kDeepest = 64, kMostNames = 10000;
  std::array<int, kDeepest + 1> names{};  // by depth, so far
  const auto require_flat = [&](int depth, Json::parse_event_t event, const Json&) {
    if (depth > kDeepest) refuse(name, fmt::format("it nests deeper than {} levels", kDeepest));
    if (event == Json::parse_event_t::object_start) names.at(static_cast<std::size_t>(depth)) = 0;
    if (event == Json::parse_event_t::key && ++names.at(static_cast<std::size_t>(depth) - 1) > kMostNames)
      refuse(name, fmt::format("an object holds more than {} names", kMostNames));
    return true;
  };
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) refuse(name + ":1:1", "it is empty");
  try {
    return Json::parse(text, require_flat);
  } catch (const Json::exception& error) {
    refuse_as(error.what(), name);
  }
}

}  // namespace

std::string text_of(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Json read_json(const std::filesystem::path& path) {
  return parse_json(read_text(path), path.string());
}

}  // namespace tribotrack::apps
