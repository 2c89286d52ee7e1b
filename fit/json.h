// JSON as results are written and read: values out of a file are asked for by their kind, and what is missing
// or of another kind is an error that names its place.
//
//   const JsonPlace fit{read, ""};
//   const double estimate = fit.at("parameters").at("mu1").at("estimate").number();
//   // throws WrongContent: "`parameters.mu1.estimate` must be a number, not "0.1""
#pragma once

#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace tribotrack::fit {

/// Keys keep the order they were written in: files for people as well.
using Json = nlohmann::ordered_json;

/// null for what is not finite.
inline Json finite_json(double value) {
  return std::isfinite(value) ? Json(value) : Json();
}

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
  double number(const std::string& key, double otherwise) const {
    return of(key, &JsonPlace::number, otherwise);
  }
  std::int64_t whole(const std::string& key, std::int64_t otherwise) const {
    return of(key, &JsonPlace::whole, otherwise);
  }
  int integer(const std::string& key, int otherwise) const { return of(key, &JsonPlace::integer, otherwise); }
  bool boolean(const std::string& key, bool otherwise) const {
    return of(key, &JsonPlace::boolean, otherwise);
  }
  std::string text(const std::string& key) const { return of(key, &JsonPlace::text, std::string()); }
  std::vector<JsonPlace> items(const std::string& key) const;  ///< otherwise none
  std::vector<std::string> texts(const std::string& key) const;

  [[noreturn]] void refuse(const std::string& expected) const;

 private:
  template <class T>
  T of(const std::string& key, T (JsonPlace::*read)() const, T otherwise) const {
    const auto found = find(key);
    return found ? (*found.*read)() : otherwise;
  }
};

}  // namespace tribotrack::fit
