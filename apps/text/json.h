// JSON as this program reads and writes it.
#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace tribotrack::apps {

/// Keys keep the order they were written in: files for people as well.
using Json = nlohmann::ordered_json;

/// Text of a JSON value, two spaces of indent, final newline. NaN becomes null.
std::string text_of(const Json& json);

/// Reads a JSON file. Throws InvalidInput.
Json read_json(const std::filesystem::path& path);

/// null for what is not finite.
inline Json finite_json(double value) {
  return std::isfinite(value) ? Json(value) : Json();
}

/// null where there is no value.
template <class T>
Json optional_json(const std::optional<T>& value) {
  return value ? Json(*value) : Json();
}

// Values out of a JSON file, each asked for by its kind: what is missing or of another kind is an error that
// names its place.

/// A key that is missing or holds something else than it should. what() names the key, not the file.
class WrongContent : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A place in a file: "parameters.mu1" and what stands there.
struct JsonPlace {
  const Json& value;
  std::string path;

  /// Throws WrongContent where there is no such key.
  JsonPlace at(const std::string& key) const;
  JsonPlace at(std::size_t index) const;
  /// Nothing where there is no such key, or null under it.
  std::optional<JsonPlace> find(const std::string& key) const;

  // Each throws WrongContent where the value is of another kind.
  double number() const;
  double number_or_null() const;  ///< NaN for null
  std::int64_t whole() const;     ///< 20 or 20.0
  int integer() const;
  bool boolean() const;
  std::string text() const;
  const JsonPlace& object() const;
  const JsonPlace& list() const;         ///< may be empty
  std::vector<JsonPlace> items() const;  ///< of a list

  // The same of a key, with what to take where there is none, or null under it.
  double number(const std::string& key, double otherwise) const;
  std::int64_t whole(const std::string& key, std::int64_t otherwise) const;
  int integer(const std::string& key, int otherwise) const;
  bool boolean(const std::string& key, bool otherwise) const;
  std::string text(const std::string& key) const;              ///< otherwise ""
  std::vector<JsonPlace> items(const std::string& key) const;  ///< otherwise none
  std::vector<std::string> texts(const std::string& key) const;

  [[noreturn]] void refuse(const std::string& expected) const;
};

}  // namespace tribotrack::apps
