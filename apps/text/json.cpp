#include "apps/text/json.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
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
  constexpr std::uintmax_t largest = std::uintmax_t{256} << 20;  // of a campaign's longest fit: some 10 MB
  std::error_code missing;
  if (std::filesystem::file_size(path, missing) > largest && !missing)
    throw InvalidInput(fmt::format(
        "{}: is larger than 256 MB, which no file of this program is; check its name", path.string()));
  return parse_json(read_text(path), path.string());
}

JsonPlace JsonPlace::at(const std::string& key) const {
  object();
  const std::string place = path.empty() ? key : path + "." + key;
  const auto found = value.find(key);
  if (found == value.end()) throw WrongContent(fmt::format("`{}` is missing", place));
  return {*found, place};
}

JsonPlace JsonPlace::at(std::size_t index) const {
  const std::string place = fmt::format("{}[{}]", path, index);
  if (!value.is_array() || index >= value.size()) throw WrongContent(fmt::format("`{}` is missing", place));
  return {value[index], place};
}

std::optional<JsonPlace> JsonPlace::find(const std::string& key) const {
  object();
  const auto found = value.find(key);
  if (found == value.end() || found->is_null()) return std::nullopt;
  return JsonPlace{*found, path.empty() ? key : path + "." + key};
}

double JsonPlace::number() const {
  if (!value.is_number()) refuse("a number");
  return value.get<double>();
}

double JsonPlace::number_or_null() const {
  return value.is_null() ? std::numeric_limits<double>::quiet_NaN() : number();
}

std::int64_t JsonPlace::whole() const {
  constexpr std::uint64_t most = std::numeric_limits<std::int64_t>::max();
  constexpr double exact = 0x1p53;
  if (value.is_number_unsigned() && value.get<std::uint64_t>() > most) refuse("a whole number that fits");
  if (value.is_number_integer()) return value.get<std::int64_t>();
  if (!value.is_number()) refuse("a whole number");
  const double real = value.get<double>();
  if (std::abs(real) > exact || real != std::floor(real)) refuse("a whole number");
  return static_cast<std::int64_t>(real);
}

int JsonPlace::integer() const {
  const std::int64_t number = whole();
  if (number < std::numeric_limits<int>::min() || number > std::numeric_limits<int>::max())
    refuse("a whole number below 2147483648");
  return static_cast<int>(number);
}

bool JsonPlace::boolean() const {
  if (!value.is_boolean()) refuse("true or false");
  return value.get<bool>();
}

std::string JsonPlace::text() const {
  if (!value.is_string()) refuse("a text");
  return value.get<std::string>();
}

const JsonPlace& JsonPlace::object() const {
  if (!value.is_object()) refuse("an object");
  return *this;
}

const JsonPlace& JsonPlace::list() const {
  if (!value.is_array()) refuse("a list");
  return *this;
}

std::vector<JsonPlace> JsonPlace::items() const {
  list();
  std::vector<JsonPlace> places;
  for (std::size_t k = 0; k < value.size(); ++k) places.push_back(at(k));
  return places;
}

double JsonPlace::number(const std::string& key, double otherwise) const {
  const auto found = find(key);
  return found ? found->number() : otherwise;
}

std::int64_t JsonPlace::whole(const std::string& key, std::int64_t otherwise) const {
  const auto found = find(key);
  return found ? found->whole() : otherwise;
}

int JsonPlace::integer(const std::string& key, int otherwise) const {
  const auto found = find(key);
  return found ? found->integer() : otherwise;
}

bool JsonPlace::boolean(const std::string& key, bool otherwise) const {
  const auto found = find(key);
  return found ? found->boolean() : otherwise;
}

std::string JsonPlace::text(const std::string& key) const {
  const auto found = find(key);
  return found ? found->text() : std::string();
}

std::vector<JsonPlace> JsonPlace::items(const std::string& key) const {
  const auto found = find(key);
  return found ? found->items() : std::vector<JsonPlace>();
}

std::vector<std::string> JsonPlace::texts(const std::string& key) const {
  std::vector<std::string> texts;
  for (const JsonPlace& item : items(key)) texts.push_back(item.text());
  return texts;
}

void JsonPlace::refuse(const std::string& expected) const {
  std::string seen = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  if (seen.size() > 40) seen = fmt::format("a value of type {}", value.type_name());
  throw WrongContent(path.empty() ? fmt::format("must hold {}, not {}", expected, seen)
                                  : fmt::format("`{}` must be {}, not {}", path, expected, seen));
}

}  // namespace tribotrack::apps
