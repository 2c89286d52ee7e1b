// Reading TOML so that nothing in a user's file is overlooked.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "apps/text/json.h"

namespace tribotrack::apps {

/// One table of a TOML file. Every getter checks the type and remembers the key; finish() refuses the keys
/// that no getter was called for and names the nearest one that exists. All errors are InvalidInput with
/// file, line and column.
class StrictTable {
 public:
  /// Reads and parses a file. Duplicate keys are errors.
  static StrictTable read(const std::filesystem::path& file);
  /// Parses a text; `name` stands in error messages.
  static StrictTable parse(std::string_view text, const std::string& name);
  /// The sections that hold a key: "platform", "fit.fixed", "run", "" for the top.
  using SectionsWith = std::vector<std::string> (*)(const std::string& key);
  /// Has finish(), in all tables of the document, say where a key belongs that it refuses.
  void say_where_keys_belong(SectionsWith sections_with);
  /// Of a JSON object that stands in place of a file: errors name, for want of lines, the list's entry, as in
  /// "NAME, run 3". Throws InvalidInput for what TOML cannot say (null, deep nesting).
  static StrictTable of(const Json& object, const std::string& name);

  std::optional<double> number(std::string_view key);
  std::optional<double> positive(std::string_view key);      ///< > 0
  std::optional<double> not_negative(std::string_view key);  ///< >= 0
  std::optional<double> angle(std::string_view key);         ///< rad: a number, "11pi/9" or "90deg"
  std::optional<std::int64_t> integer(std::string_view key);
  std::optional<bool> boolean(std::string_view key);
  std::optional<std::string> text(std::string_view key);
  std::optional<std::vector<double>> numbers(std::string_view key, std::size_t count);
  std::optional<std::vector<std::int64_t>> integers(std::string_view key, std::size_t count);
  std::optional<std::vector<std::string>> texts(std::string_view key);
  std::optional<StrictTable> table(std::string_view key);
  std::vector<StrictTable> tables(std::string_view key);  ///< [[key]]; empty where there is none

  /// One of the words; its index. The error lists them.
  std::optional<std::size_t> choice(std::string_view key, const std::vector<std::string>& words);

  bool has(std::string_view key) const;
  /// A number or a text as the file has it: "0.280", "45deg"; of a JSON object a number's shortest form.
  /// Empty where the key holds neither.
  std::string written(std::string_view key) const;
  bool is_table(std::string_view key) const;
  bool is_list(std::string_view key) const;
  std::size_t count(std::string_view key) const;  ///< of a list's entries; 0 where it is none
  std::vector<std::string> keys() const;
  /// An error at a key (or at the table itself when the key is not there).
  [[noreturn]] void fail(std::string_view key, const std::string& message) const;
  /// "campaign.toml:12:1", the place of the table or of a key in it.
  std::string place(std::string_view key = {}) const;
  /// Throws for the first key that no getter was called for.
  void finish() const;

 private:
  struct Node;
  explicit StrictTable(std::shared_ptr<Node> node) : node_(std::move(node)) {}
  std::shared_ptr<Node> node_;
};

/// A text in the quotes of TOML, in which it reads back. Throws InvalidInput where it is not UTF-8.
std::string toml_text(std::string_view text);

/// A number, text, list or table as TOML, on one line. `place` stands in messages. Throws InvalidInput for
/// what TOML cannot say.
std::string toml_value(const Json& value, const std::string& place = "a value", int depth = 0);

/// A text for a comment: on one line, UTF-8, nothing in it that controls a terminal.
std::string toml_comment(std::string_view text);

/// The byte at a place, which counts lines and characters from 1.
std::size_t offset_of(std::string_view text, std::size_t line, std::size_t column);

/// The content of a text file, 256 MB at most. Throws InvalidInput, for a fifo or a device too.
std::string read_text(const std::filesystem::path& file);

/// The nearest of `words` to `word` by edit distance; empty when none is near.
std::string nearest_word(std::string_view word, const std::vector<std::string>& words);

// The key `NAME_sd` beside a given quantity `NAME`.

/// The sd in the unit of the quantity; an angle's may be a text as the angle itself. Fails where the quantity
/// itself is not given in this table, or the sd is not above 0: an exact value has none.
std::optional<double> read_sd(StrictTable& table, const std::string& quantity);

}  // namespace tribotrack::apps
