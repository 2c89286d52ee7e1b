#include "apps/text/json.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "apps/program/errors.h"
#include "apps/text/strict_toml.h"

namespace tribotrack::apps {

namespace {

constexpr const char* kRemedy = "correct it, or make the file anew with the command that wrote it";

/// A text that should be JSON, and what to say where it is not.
class JsonText {
 public:
  JsonText(std::string_view text, const std::string& name) : text_(text), name_(name) {}

  [[noreturn]] void fail(std::size_t at, const std::string& what) const {
    const std::string_view before = text_.substr(0, at);
    const auto line = std::ranges::count(before, '\n') + 1;
    const std::size_t column = at - (before.rfind('\n') + 1) + 1;  // npos + 1 is 0
    throw InvalidInput(fmt::format("{}:{}:{}: is no JSON: {}; {}", name_, line, column, what, kRemedy));
  }

  bool is_utf_16() const {
    return text_.starts_with("\xFF\xFE") || text_.starts_with("\xFE\xFF") ||
           text_.substr(0, 4).find('\0') != std::string_view::npos;
  }

  /// Values that nest too deeply would fill the stack where they are copied; each name of an object is
  /// compared with all others.
  void require_flat() const {
    constexpr std::size_t kDeepest = 64, kMostNames = 10000;
    std::array<std::size_t, kDeepest> names{};
    std::size_t depth = 0;
    for (std::size_t at = 0; at < text_.size(); ++at) {
      const char c = text_[at];
      if (c == '"') {
        at = end_of_text(at);
      } else if (c == '{' || c == '[') {
        if (depth == kDeepest) fail(at, fmt::format("it nests deeper than {} levels", kDeepest));
        names[depth++] = 0;
      } else if (c == '}' || c == ']') {
        depth -= depth > 0;
      } else if (c == ':' && depth > 0 && ++names[depth - 1] > kMostNames) {
        fail(at, fmt::format("an object holds more than {} names", kMostNames));
      }
    }
  }

  /// `read`: characters taken up to and with the one that does not belong.
  [[noreturn]] void fail_after(std::size_t read) const {
    if (text_.find_first_not_of(" \t\r\n") == std::string_view::npos) fail(0, "it is empty");
    if (is_utf_16()) fail(0, "it is UTF-16 or binary, not UTF-8");
    if (read > text_.size()) fail(text_.size(), "it ends in the middle");
    const std::size_t last = read > 0 ? read - 1 : 0;
    std::size_t begin = last;
    while (begin > 0 && in_word(text_[begin]) && in_word(text_[begin - 1])) --begin;
    std::size_t end = begin;
    while (end < text_.size() && end - begin < 24 && in_word(text_[end])) ++end;
    if (end > begin) {
      const std::string_view word = text_.substr(begin, end - begin);
      if (word == "NaN" || word == "nan" || word == "Infinity" || word == "-Infinity" || word == "inf")
        fail(begin, fmt::format("`{}` stands where `null` is written for what is no number", word));
      fail(begin, fmt::format("`{}` does not belong here", word));
    }
    const auto byte = static_cast<unsigned char>(text_[last]);
    if (byte < 0x20 || byte == 0x7F) fail(last, "a text is broken by a line end or a control character");
    if (byte == '\'') fail(last, "texts stand between \", not between '");
    if (byte == '/' || byte == '#') fail(last, "it knows no comments");
    fail(last, fmt::format("`{}` does not belong here", text_[last]));
  }

  /// `read`: as above; the parser notices a broken character at its end.
  [[noreturn]] void fail_character_before(std::size_t read) const {
    std::size_t at = std::min(read, text_.size());
    while (at > 0 && static_cast<unsigned char>(text_[at - 1]) < 0x80) --at;
    fail(at > 0 ? at - 1 : 0, "a character here is not UTF-8; save it as UTF-8");
  }

  std::size_t place_of(std::string_view word) const { return std::min(text_.find(word), text_.size()); }

 private:
  static bool in_word(char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '+' ||
           c == '-' || c == '.' || c == '_';
  }
  /// The closing quote, or the last character where there is none.
  std::size_t end_of_text(std::size_t at) const {
    for (++at; at < text_.size() && text_[at] != '"'; ++at)
      if (text_[at] == '\\') ++at;
    return at;
  }

  std::string_view text_;
  const std::string& name_;
};

/// The library tells it only between the quotes of its message: "number overflow parsing '1e999'".
std::string overflowing_number(const std::string& message) {
  const auto begin = message.find('\''), end = message.rfind('\'');
  return begin < end ? message.substr(begin + 1, end - begin - 1) : "";
}

Json parse_json(std::string_view text, const std::string& name) {
  const JsonText source(text, name);
  source.require_flat();
  try {
    return Json::parse(text);
  } catch (const Json::parse_error& error) {
    if (std::string_view(error.what()).find("ill-formed UTF-8") != std::string_view::npos &&
        !source.is_utf_16())
      source.fail_character_before(error.byte);
    source.fail_after(error.byte);
  } catch (const Json::out_of_range& error) {
    const std::string number = overflowing_number(error.what());
    source.fail(source.place_of(number), fmt::format("the number `{}` is too large", number));
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
