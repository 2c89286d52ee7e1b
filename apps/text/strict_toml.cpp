#include "apps/text/strict_toml.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <numeric>

#include "apps/program/errors.h"
#include "apps/program/streams.h"
#include "apps/text/angle.h"
#include "apps/text/input_file.h"
#include "vision/temporary_file.h"

namespace tribotrack::apps {

namespace {

std::string kind_of(const toml::node& node) {
  if (node.is_string()) return fmt::format("the text \"{}\"", node.ref<std::string>());
  if (node.is_integer() || node.is_floating_point()) return fmt::format("{}", *node.value<double>());
  if (node.is_boolean()) return "true/false";
  if (node.is_array()) return "a list";
  if (node.is_table()) return "a table";
  return "a date or time";
}

}  // namespace

struct StrictTable::Node {
  std::shared_ptr<const toml::table> document;  // keeps the tree alive
  const toml::table* table = nullptr;
  std::string file;
  std::string name;  // "platform", "" for the top
  bool parsed = true;
  std::shared_ptr<const std::string> content;  // what was parsed
  std::set<std::string, std::less<>> looked_up;
  std::shared_ptr<SectionsWith> sections_with = std::make_shared<SectionsWith>();  // of the document

  const toml::node* find(std::string_view key) {
    looked_up.emplace(key);
    return table->get(key);
  }

  std::string place(std::string_view key) const {
    if (!parsed) return file;
    const toml::node* node = key.empty() ? nullptr : table->get(key);
    auto source = node != nullptr ? node->source() : table->source();
    if (!source.begin) source.begin = {1, 1};
    if (node != nullptr)
      for (auto&& [word, value] : *table)
        if (word.str() == key && word.source().begin) source = word.source();
    return fmt::format("{}:{}:{}", file, source.begin.line, source.begin.column);
  }
  [[noreturn]] void fail(std::string_view key, const std::string& message) const {
    const std::string where = name.empty() ? "" : fmt::format(" in [{}]", name);
    throw InvalidInput("{}: `{}`{} {}", place(key), key, where, message);
  }

  template <class T>
  std::optional<T> exactly(std::string_view key, const char* what) {
    const toml::node* node = find(key);
    if (node == nullptr) return std::nullopt;
    const auto value = node->value_exact<T>();
    if (!value) fail(key, fmt::format("must be {}, not {}", what, kind_of(*node)));
    return value;
  }
  template <class T>
  std::optional<std::vector<T>> list(std::string_view key, std::optional<T> (*value_in)(const toml::node&),
                                     const std::string& what, std::optional<std::size_t> count) {
    const toml::node* node = find(key);
    if (node == nullptr) return std::nullopt;
    const toml::array* list = node->as_array();
    std::vector<T> values;
    if (list != nullptr)
      for (const toml::node& item : *list)
        if (const auto value = value_in(item)) values.push_back(*value);
    if (list == nullptr || values.size() != list->size() || values.size() != count.value_or(values.size()))
      fail(key, "must be a list of " + what);
    return values;
  }

  /// A table in this one.
  StrictTable inner(const toml::table& one, std::string called) const {
    auto node = std::make_shared<Node>(*this);
    node->table = &one;
    node->name = std::move(called);
    node->looked_up.clear();
    return StrictTable(std::move(node));
  }
};

namespace {

/// "in [part]", for a section by its name.
std::string heading_of(const std::string& section) {
  if (section.empty()) return "at the top of the file, before the first [table]";
  return section == "run" ? "in [[run]]" : fmt::format("in [{}]", section);
}

std::optional<double> number_in(const toml::node& node) {
  if (node.is_integer()) return static_cast<double>(*node.value<std::int64_t>());
  if (node.is_floating_point()) return *node.value<double>();
  return std::nullopt;
}

}  // namespace

std::string toml_text(std::string_view text) {
  if (!encoding_slip(text).empty() && text.find('\0') == text.npos)
    throw InvalidInput("{}: is no name in UTF-8, as a campaign is written; rename it", printable(text));
  std::string quoted = "\"";
  for (const char c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F)
      quoted += fmt::format("\\u{:04X}", static_cast<unsigned>(c));
    else
      quoted += c == '"' || c == '\\' ? std::string{'\\', c} : std::string{c};
  return quoted + "\"";
}

std::string toml_value(const Json& value, const std::string& place, int depth) {
  constexpr int kDeepest = 16;  // tables within tables; a campaign has three
  if (depth > kDeepest) throw InvalidInput("{} is nested too deeply", place);
  if (value.is_null() || value.is_binary())
    throw InvalidInput("{} must be a number, a text, a list or a table", place);
  if (value.is_string()) return toml_text(value.get_ref<const std::string&>());
  if (value.is_number_float()) {
    const std::string number = fmt::format("{}", value.get<double>());
    return number.find_first_not_of("-0123456789") == number.npos ? number + ".0" : number;
  }
  if (!value.is_structured()) return value.dump();
  std::string items;
  for (const auto& [key, one] : value.items())
    items += (items.empty() ? "" : ", ") +
             (value.is_object()
                  ? toml_text(key) + " = " + toml_value(one, fmt::format("{}: `{}`", place, key), depth + 1)
                  : toml_value(one, place, depth + 1));
  return value.is_object() ? "{" + items + "}" : "[" + items + "]";
}

std::string toml_comment(std::string_view text) {
  std::string comment = printable(text);
  std::ranges::replace(comment, '\n', ' ');
  if (!encoding_slip(comment).empty())
    std::ranges::replace_if(
        comment, [](char c) { return static_cast<signed char>(c) < 0; }, '?');
  return comment;
}

std::string read_text(const std::filesystem::path& file) {
  constexpr std::size_t kLargest = std::size_t{256} << 20;  // of a campaign's longest fit: some 10 MB
  const auto refuse = [&](const std::string& why) { throw InvalidInput("{}: {}", file.string(), why); };
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) refuse("there is no such file; check its name");
  if (std::filesystem::is_directory(status)) refuse("is a folder; name a file in it");
  if (!std::filesystem::is_regular_file(status))
    refuse("is a fifo or a device, which may never end; save what it gives as a file");
  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  if (!stream) refuse("cannot be read: " + vision::with_remedy(errno, "check its permissions"));
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error || size > kLargest)
    refuse("is larger than 256 MB, which no text of measurements is; check its name, or cut it");
  std::string content(size, 0);
  stream.read(content.data(), static_cast<std::streamsize>(size));
  content.resize(static_cast<std::size_t>(stream.gcount()));
  return content;
}

StrictTable StrictTable::read(const std::filesystem::path& file) {
  return parse(read_text(file), file.string());
}

StrictTable StrictTable::parse(std::string_view text, const std::string& name) {
  constexpr std::size_t kLargest = std::size_t{16} << 20;
  if (text.size() > kLargest)
    throw InvalidInput(name +
                       ": is larger than 16 MB, which no campaign, scenario or scene is; check its name");
  if (const std::string encoding = encoding_slip(text); !encoding.empty())
    throw InvalidInput(name + encoding);
  require_shallow_keys(text, name);
  try {
    auto node = std::make_shared<Node>();
    node->document = std::make_shared<const toml::table>(toml::parse(text, name));
    node->table = node->document.get();
    node->file = name;
    node->content = std::make_shared<const std::string>(text);
    return StrictTable(std::move(node));
  } catch (const toml::parse_error& error) {
    const toml::source_position at = error.source().begin;
    throw InvalidInput("{}:{}:{}: {}", name, at.line, at.column,
                       toml_slip(text, at.line, at.column, error.description()));
  }
}

StrictTable StrictTable::of(const Json& object, const std::string& name) {
  std::string text;
  for (const auto& [key, value] : object.items())
    text += toml_text(key) + " = " + toml_value(value, fmt::format("{}: `{}`", name, key)) + "\n";
  StrictTable table = parse(text, name);
  table.node_->parsed = false;
  return table;
}

std::string StrictTable::place(std::string_view key) const {
  return node_->place(key);
}

void StrictTable::fail(std::string_view key, const std::string& message) const {
  node_->fail(key, message);
}

std::optional<double> StrictTable::number(std::string_view key) {
  const toml::node* node = node_->find(key);
  if (node == nullptr) return std::nullopt;
  const auto value = number_in(*node);
  if (!value) fail(key, fmt::format("must be a number, not {}", kind_of(*node)));
  if (!std::isfinite(*value)) fail(key, "must be a finite number");
  return value;
}

std::optional<double> StrictTable::positive(std::string_view key) {
  const auto value = number(key);
  if (value && !(*value > 0)) fail(key, fmt::format("must be greater than 0, not {}", *value));
  return value;
}

std::optional<double> StrictTable::not_negative(std::string_view key) {
  const auto value = number(key);
  if (value && !(*value >= 0)) fail(key, fmt::format("must be 0 or more, not {}", *value));
  return value;
}

std::optional<double> StrictTable::angle(std::string_view key) {
  const toml::node* node = node_->find(key);
  if (node == nullptr) return std::nullopt;
  const auto text = node->value_exact<std::string>();
  const auto value = text ? parse_angle(*text) : number_in(*node);
  if (!value)
    fail(key, text ? fmt::format("must be an angle in radians, a number or a text such as \"11pi/9\", "
                                 "\"-pi/2\" or \"90deg\", not \"{}\"",
                                 *text)
                   : fmt::format("must be an angle in radians, not {}", kind_of(*node)));
  if (!std::isfinite(*value)) fail(key, "must be a finite angle");
  if (const std::string slip = angle_slip(*value); !slip.empty()) fail(key, slip);
  return value;
}

std::optional<std::int64_t> StrictTable::integer(std::string_view key) {
  return node_->exactly<std::int64_t>(key, "a whole number");
}

std::optional<bool> StrictTable::boolean(std::string_view key) {
  return node_->exactly<bool>(key, "true or false");
}

std::optional<std::string> StrictTable::text(std::string_view key) {
  return node_->exactly<std::string>(key, "a text in quotes");
}

std::optional<std::vector<double>> StrictTable::numbers(std::string_view key, std::size_t count) {
  const auto finite = [](const toml::node& node) {
    const auto value = number_in(node);
    return value && std::isfinite(*value) ? value : std::nullopt;
  };
  return node_->list<double>(key, finite, fmt::format("{} numbers", count), count);
}

std::optional<std::vector<std::int64_t>> StrictTable::integers(std::string_view key, std::size_t count) {
  const auto whole = [](const toml::node& node) { return node.value_exact<std::int64_t>(); };
  return node_->list<std::int64_t>(key, whole, fmt::format("{} whole numbers", count), count);
}

std::optional<std::vector<std::string>> StrictTable::texts(std::string_view key) {
  const auto text = [](const toml::node& node) { return node.value_exact<std::string>(); };
  return node_->list<std::string>(key, text, "texts in quotes", std::nullopt);
}

std::optional<StrictTable> StrictTable::table(std::string_view key) {
  const toml::node* node = node_->find(key);
  if (node == nullptr) return std::nullopt;
  const toml::table* table = node->as_table();
  if (table == nullptr) fail(key, fmt::format("must be a table, [{}], not {}", key, kind_of(*node)));
  return node_->inner(*table,
                      node_->name.empty() ? std::string(key) : fmt::format("{}.{}", node_->name, key));
}

std::vector<StrictTable> StrictTable::tables(std::string_view key) {
  const toml::node* node = node_->find(key);
  std::vector<StrictTable> found;
  if (node == nullptr) return found;
  const toml::array* list = node->as_array();
  if (list == nullptr) fail(key, fmt::format("must be a list of tables, [[{}]]", key));
  for (const toml::node& item : *list) {
    const toml::table* table = item.as_table();
    if (table == nullptr) fail(key, fmt::format("must be a list of tables, [[{}]]", key));
    found.push_back(node_->inner(*table, fmt::format("[{}]", key)));
    if (!node_->parsed) found.back().node_->file = fmt::format("{}, {} {}", node_->file, key, found.size());
  }
  return found;
}

std::optional<std::size_t> StrictTable::choice(std::string_view key, const std::vector<std::string>& words) {
  const auto word = text(key);
  if (!word) return std::nullopt;
  const auto at = std::find(words.begin(), words.end(), *word);
  if (at == words.end()) {
    const std::string near = nearest_word(*word, words);
    fail(key, fmt::format("must be one of {}, not \"{}\"{}", fmt::join(words, ", "), *word,
                          near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near)));
  }
  return static_cast<std::size_t>(at - words.begin());
}

bool StrictTable::has(std::string_view key) const {
  return node_->table->contains(key);
}

std::size_t offset_of(std::string_view text, std::size_t line, std::size_t column) {
  std::size_t offset = 0;
  for (; line > 1; --line) offset = text.find('\n', offset) + 1;
  const auto continues = [&] {  // a character of UTF-8
    return offset < text.size() && (static_cast<unsigned char>(text[offset]) & 0xC0) == 0x80;
  };
  for (; column > 1; --column)
    for (++offset; continues();) ++offset;
  return offset;
}

std::string StrictTable::written(std::string_view key) const {
  const toml::node* node = node_->table->get(key);
  if (node == nullptr) return {};
  if (node->is_string()) return node->ref<std::string>();
  if (node->is_integer()) return fmt::format("{}", node->ref<std::int64_t>());
  if (!node->is_floating_point()) return {};
  if (!node_->parsed) return fmt::format("{}", node->ref<double>());
  const auto& [begin, end, path] = node->source();
  const std::size_t first = offset_of(*node_->content, begin.line, begin.column);
  return node_->content->substr(first, offset_of(*node_->content, end.line, end.column) - first);
}

bool StrictTable::is_table(std::string_view key) const {
  const toml::node* node = node_->table->get(key);
  return node != nullptr && node->is_table();
}

bool StrictTable::is_list(std::string_view key) const {
  const toml::node* node = node_->table->get(key);
  return node != nullptr && node->is_array();
}

std::size_t StrictTable::count(std::string_view key) const {
  const toml::node* node = node_->table->get(key);
  return node != nullptr && node->is_array() ? node->as_array()->size() : 0;
}

std::vector<std::string> StrictTable::keys() const {
  std::vector<std::string> names;
  for (auto&& [name, value] : *node_->table) names.emplace_back(name.str());
  return names;
}

void StrictTable::say_where_keys_belong(SectionsWith sections_with) {
  *node_->sections_with = sections_with;
}

void StrictTable::finish() const {
  for (auto&& [name, value] : *node_->table) {
    const std::string key(name.str());
    if (node_->looked_up.contains(key)) continue;
    std::vector<std::string> homes;
    if (const SectionsWith sections_with = *node_->sections_with)
      for (const std::string& section : sections_with(key)) homes.push_back(heading_of(section));
    if (!homes.empty()) fail(key, fmt::format("does not belong here but {}", fmt::join(homes, " or ")));
    const std::vector<std::string> valid(node_->looked_up.begin(), node_->looked_up.end());
    const std::string near = nearest_word(key, valid);
    fail(key, near.empty() ? fmt::format("is not a known key; known here: {}", fmt::join(valid, ", "))
                           : fmt::format("is not a known key; did you mean `{}`?", near));
  }
}

std::string nearest_word(std::string_view word, const std::vector<std::string>& words) {
  // Levenshtein distance, one row at a time.
  const auto distance = [&](std::string_view other) {
    std::vector<std::size_t> row(other.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= word.size(); ++i) {
      std::size_t diagonal = row[0];
      row[0] = i;
      for (std::size_t j = 1; j <= other.size(); ++j) {
        const std::size_t substituted = diagonal + (word[i - 1] != other[j - 1]);
        diagonal = row[j];
        row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
      }
    }
    return row.back();
  };
  std::string best;
  std::size_t least = std::max<std::size_t>(2, word.size() / 2);
  for (const std::string& candidate : words)
    if (const std::size_t d = distance(candidate); d <= least && (best.empty() || d < least)) {
      least = d;
      best = candidate;
    }
  return best;
}

std::optional<double> read_sd(StrictTable& table, const std::string& quantity) {
  const std::string key = quantity + "_sd";
  const auto sd = quantity.ends_with("_rad") ? table.angle(key) : table.number(key);
  if (!sd) return std::nullopt;
  if (!table.has(quantity))
    table.fail(key,
               fmt::format("is the sd of `{}`, which is not given here: give both, or neither", quantity));
  if (!(*sd > 0))
    table.fail(key,
               fmt::format("must be greater than 0, not {}: for one that is exact name `{}` in [fit] exact",
                           *sd, quantity));
  return sd;
}

}  // namespace tribotrack::apps
