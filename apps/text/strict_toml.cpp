#include "apps/text/strict_toml.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numeric>
#include <sstream>

#include "apps/program/errors.h"
#include "apps/text/angle.h"
#include "apps/text/toml_slips.h"

namespace tribotrack::apps {

struct StrictTable::Node {
  std::shared_ptr<const toml::table> document;  // keeps the tree alive
  const toml::table* table = nullptr;
  std::string file;
  std::string name;  // "platform", "" for the top
  bool parsed = true;
  std::set<std::string, std::less<>> looked_up;
  struct Document {
    std::vector<AskedKey> asked;
    std::function<std::vector<AskedKey>()> every_key;
  };
  std::shared_ptr<Document> whole = std::make_shared<Document>();  // shared by all tables of the document

  /// A kind that is asked for first is the narrower one: positive() asks number().
  void note(std::string_view key, const std::string& kind) {
    const std::string section = name.starts_with('[') ? name.substr(1, name.size() - 2) : name;
    if (std::ranges::none_of(whole->asked,
                             [&](const AskedKey& a) { return a.section == section && a.key == key; }))
      whole->asked.push_back({section, std::string(key), kind});
  }
  /// Tables have no kind.
  const toml::node* find(std::string_view key, const std::string& kind = {}) {
    looked_up.emplace(key);
    if (!kind.empty()) note(key, kind);
    return table->get(key);
  }
};

namespace {

std::string kind_of(const toml::node& node) {
  if (node.is_string()) return fmt::format("the text \"{}\"", node.ref<std::string>());
  if (node.is_integer() || node.is_floating_point()) return fmt::format("{}", *node.value<double>());
  if (node.is_boolean()) return "true/false";
  if (node.is_array()) return "a list";
  if (node.is_table()) return "a table";
  return "a date or time";
}

/// "in [part]", for a section as AskedKey has it.
std::string heading_of(const std::string& section) {
  if (section.empty()) return "at the top of the file, before the first [table]";
  return section == "run" ? "in [[run]]" : fmt::format("in [{}]", section);
}

std::optional<double> number_in(const toml::node& node) {
  if (node.is_integer()) return static_cast<double>(*node.value<std::int64_t>());
  if (node.is_floating_point()) return *node.value<double>();
  return std::nullopt;
}

constexpr int kDeepest = 16;  ///< tables within tables; a campaign has three

void put_into(toml::table& to, const Json& object, const std::string& place, int depth);
void put_into(toml::array& to, const Json& list, const std::string& place, int depth);

/// Hands the TOML form of a value to `put`.
template <class Put>
void convert(const Json& value, const std::string& place, int depth, const Put& put) {
  if (depth > kDeepest) throw InvalidInput(fmt::format("{} is nested too deeply", place));
  switch (value.type()) {
    case Json::value_t::boolean:
      return put(value.get<bool>());
    case Json::value_t::number_integer:
    case Json::value_t::number_unsigned:
      return put(value.get<std::int64_t>());
    case Json::value_t::number_float:
      return put(value.get<double>());
    case Json::value_t::string:
      return put(value.get<std::string>());
    case Json::value_t::array: {
      toml::array list;
      put_into(list, value, place, depth + 1);
      return put(std::move(list));
    }
    case Json::value_t::object: {
      toml::table table;
      put_into(table, value, place, depth + 1);
      return put(std::move(table));
    }
    default:
      throw InvalidInput(fmt::format("{} must be a number, a text, a list or a table", place));
  }
}

void put_into(toml::array& to, const Json& list, const std::string& place, int depth) {
  for (const Json& item : list)
    convert(item, place, depth, [&to](auto&& converted) { to.push_back(std::move(converted)); });
}

void put_into(toml::table& to, const Json& object, const std::string& place, int depth) {
  for (const auto& [key, value] : object.items())
    convert(value, fmt::format("{}: `{}`", place, key), depth,
            [&to, &key = key](auto&& converted) { to.insert(key, std::move(converted)); });
}

}  // namespace

std::string read_text(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file))
    throw InvalidInput(fmt::format("{}: there is no such file; check its name", file.string()));
  std::ifstream stream(file, std::ios::binary);
  if (std::filesystem::is_directory(file))
    throw InvalidInput(fmt::format("{}: is a folder; name a file in it", file.string()));
  if (!stream) throw InvalidInput(fmt::format("{}: cannot be read; give a text file", file.string()));
  std::ostringstream content;
  content << stream.rdbuf();
  return content.str();
}

StrictTable StrictTable::read(const std::filesystem::path& file) {
  return parse(read_text(file), file.string());
}

StrictTable StrictTable::parse(std::string_view text, const std::string& name) {
  if (const std::string encoding = encoding_slip(text); !encoding.empty())
    throw InvalidInput(name + encoding);
  require_shallow_keys(text, name);
  try {
    auto node = std::make_shared<Node>();
    node->document = std::make_shared<const toml::table>(toml::parse(text, name));
    node->table = node->document.get();
    node->file = name;
    return StrictTable(std::move(node));
  } catch (const toml::parse_error& error) {
    const toml::source_position at = error.source().begin;
    throw InvalidInput(fmt::format("{}:{}:{}: {}", name, at.line, at.column,
                                   toml_slip(text, at.line, at.column, error.description())));
  }
}

StrictTable StrictTable::of(const Json& object, const std::string& name) {
  toml::table table;
  put_into(table, object, name, 0);
  auto node = std::make_shared<Node>();
  node->document = std::make_shared<const toml::table>(std::move(table));
  node->table = node->document.get();
  node->file = name;
  node->parsed = false;
  return StrictTable(std::move(node));
}

std::string StrictTable::place(std::string_view key) const {
  if (!node_->parsed) return node_->file;
  const toml::node* node = key.empty() ? nullptr : node_->table->get(key);
  auto source = node != nullptr ? node->source() : node_->table->source();
  if (!source.begin) source.begin = {1, 1};
  if (node != nullptr)
    for (auto&& [name, value] : *node_->table)
      if (name.str() == key && name.source().begin) source = name.source();
  return fmt::format("{}:{}:{}", node_->file, source.begin.line, source.begin.column);
}

void StrictTable::fail(std::string_view key, const std::string& message) const {
  const std::string where = node_->name.empty() ? "" : fmt::format(" in [{}]", node_->name);
  throw InvalidInput(fmt::format("{}: `{}`{} {}", place(key), key, where, message));
}

std::optional<double> StrictTable::number(std::string_view key) {
  const toml::node* node = node_->find(key, "number");
  if (node == nullptr) return std::nullopt;
  const auto value = number_in(*node);
  if (!value) fail(key, fmt::format("must be a number, not {}", kind_of(*node)));
  if (!std::isfinite(*value)) fail(key, "must be a finite number");
  return value;
}

std::optional<double> StrictTable::positive(std::string_view key) {
  node_->note(key, "number above 0");
  const auto value = number(key);
  if (value && !(*value > 0)) fail(key, fmt::format("must be greater than 0, not {}", *value));
  return value;
}

std::optional<double> StrictTable::not_negative(std::string_view key) {
  node_->note(key, "number, 0 or more");
  const auto value = number(key);
  if (value && !(*value >= 0)) fail(key, fmt::format("must be 0 or more, not {}", *value));
  return value;
}

std::optional<double> StrictTable::angle(std::string_view key) {
  const toml::node* node = node_->find(key, "angle");
  if (node == nullptr) return std::nullopt;
  if (const auto text = node->value_exact<std::string>()) {
    const auto value = parse_angle(*text);
    if (!value)
      fail(key, fmt::format("must be an angle in radians, a number or a text such as \"11pi/9\", \"-pi/2\" "
                            "or \"90deg\", not "
                            "\"{}\"",
                            *text));
    if (const std::string slip = angle_slip(*value); !slip.empty()) fail(key, slip);
    return value;
  }
  const auto value = number_in(*node);
  if (!value) fail(key, fmt::format("must be an angle in radians, not {}", kind_of(*node)));
  if (!std::isfinite(*value)) fail(key, "must be a finite angle");
  if (const std::string slip = angle_slip(*value); !slip.empty()) fail(key, slip);
  return value;
}

std::optional<std::int64_t> StrictTable::integer(std::string_view key) {
  const toml::node* node = node_->find(key, "whole number");
  if (node == nullptr) return std::nullopt;
  if (!node->is_integer()) fail(key, fmt::format("must be a whole number, not {}", kind_of(*node)));
  return node->value<std::int64_t>();
}

std::optional<bool> StrictTable::boolean(std::string_view key) {
  const toml::node* node = node_->find(key, "true or false");
  if (node == nullptr) return std::nullopt;
  if (!node->is_boolean()) fail(key, fmt::format("must be true or false, not {}", kind_of(*node)));
  return node->value<bool>();
}

std::optional<std::string> StrictTable::text(std::string_view key) {
  const toml::node* node = node_->find(key, "text");
  if (node == nullptr) return std::nullopt;
  if (!node->is_string()) fail(key, fmt::format("must be a text in quotes, not {}", kind_of(*node)));
  return node->value<std::string>();
}

std::optional<std::vector<double>> StrictTable::numbers(std::string_view key, std::size_t count) {
  const toml::node* node = node_->find(key, fmt::format("list of {} numbers", count));
  if (node == nullptr) return std::nullopt;
  const toml::array* list = node->as_array();
  std::vector<double> values;
  if (list != nullptr)
    for (const toml::node& item : *list)
      if (const auto value = number_in(item); value && std::isfinite(*value)) values.push_back(*value);
  if (list == nullptr || values.size() != list->size() || values.size() != count)
    fail(key, fmt::format("must be a list of {} numbers", count));
  return values;
}

std::optional<std::vector<std::int64_t>> StrictTable::integers(std::string_view key, std::size_t count) {
  const toml::node* node = node_->find(key, fmt::format("list of {} whole numbers", count));
  if (node == nullptr) return std::nullopt;
  const toml::array* list = node->as_array();
  std::vector<std::int64_t> values;
  if (list != nullptr)
    for (const toml::node& item : *list)
      if (item.is_integer()) values.push_back(*item.value<std::int64_t>());
  if (list == nullptr || values.size() != list->size() || values.size() != count)
    fail(key, fmt::format("must be a list of {} whole numbers", count));
  return values;
}

std::optional<std::vector<std::string>> StrictTable::texts(std::string_view key) {
  const toml::node* node = node_->find(key, "list of texts");
  if (node == nullptr) return std::nullopt;
  const toml::array* list = node->as_array();
  std::vector<std::string> values;
  if (list != nullptr)
    for (const toml::node& item : *list)
      if (item.is_string()) values.push_back(*item.value<std::string>());
  if (list == nullptr || values.size() != list->size()) fail(key, "must be a list of texts in quotes");
  return values;
}

std::optional<StrictTable> StrictTable::table(std::string_view key) {
  const toml::node* node = node_->find(key);
  if (node == nullptr) return std::nullopt;
  const toml::table* table = node->as_table();
  if (table == nullptr) fail(key, fmt::format("must be a table, [{}], not {}", key, kind_of(*node)));
  auto inner = std::make_shared<Node>();
  inner->document = node_->document;
  inner->table = table;
  inner->file = node_->file;
  inner->whole = node_->whole;
  inner->parsed = node_->parsed;
  inner->name = node_->name.empty() ? std::string(key) : fmt::format("{}.{}", node_->name, key);
  return StrictTable(std::move(inner));
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
    auto inner = std::make_shared<Node>();
    inner->document = node_->document;
    inner->table = table;
    inner->whole = node_->whole;
    inner->parsed = node_->parsed;
    inner->file = node_->parsed ? node_->file : fmt::format("{}, {} {}", node_->file, key, found.size() + 1);
    inner->name = fmt::format("[{}]", key);
    found.push_back(StrictTable(std::move(inner)));
  }
  return found;
}

std::optional<std::size_t> StrictTable::choice(std::string_view key, const std::vector<std::string>& words) {
  node_->note(key, fmt::format("\"{}\"", fmt::join(words, "\", \"")));
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

std::vector<AskedKey> StrictTable::asked() const {
  return node_->whole->asked;
}

bool StrictTable::has(std::string_view key) const {
  return node_->table->contains(key);
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

void StrictTable::say_where_keys_belong(std::function<std::vector<AskedKey>()> every_key) {
  node_->whole->every_key = std::move(every_key);
}

std::string StrictTable::home_of(std::string_view key) const {
  if (!node_->whole->every_key) return {};
  std::vector<std::string> homes;
  for (const AskedKey& known : node_->whole->every_key())
    if (known.key == key) homes.push_back(heading_of(known.section));
  if (homes.empty()) return {};
  const std::string last = homes.back();
  homes.pop_back();
  return homes.empty() ? last : fmt::format("{} or {}", fmt::join(homes, ", "), last);
}

void StrictTable::finish() const {
  for (auto&& [name, value] : *node_->table) {
    const std::string key(name.str());
    if (node_->looked_up.contains(key)) continue;
    if (const std::string home = home_of(key); !home.empty())
      fail(key, fmt::format("does not belong here but {}", home));
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
    table.fail(
        key, fmt::format("must be greater than 0, not {}: leave it out where `{}` is exact", *sd, quantity));
  return sd;
}

}  // namespace tribotrack::apps
