#include "apps/files/keys.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <numbers>

#include "apps/files/camera.h"
#include "apps/files/run_folder.h"

namespace tribotrack::apps {

Kind Kind::wholes(int least, int most) {
  Kind kind = whole;
  kind.least = least;
  kind.most = most;
  return kind;
}

Kind Kind::one_of(std::vector<std::string> words) {
  Kind kind = word;
  kind.words = std::move(words);
  return kind;
}

std::string KeyFacts::quantity() const {
  return name.ends_with("_sd") ? name.substr(0, name.size() - 3) : name;
}

std::string KeyFacts::kind_text() const {
  switch (kind.form) {
    case Kind::number:
      return "number";
    case Kind::above_zero:
      return "number above 0";
    case Kind::not_negative:
      return "number, 0 or more";
    case Kind::angle:
      return "angle";
    case Kind::sd:
    case Kind::sd_of_fit:
      return quantity().ends_with("_rad") ? "angle" : "number";
    case Kind::whole:
      return "whole number";
    case Kind::word:
      return fmt::format("\"{}\"", fmt::join(kind.words, "\", \""));
    case Kind::text:
    case Kind::file:
    case Kind::text_or_texts:
      return "text";
    case Kind::texts:
      return "list of texts";
    case Kind::circle:
      return "list of 3 numbers";
    case Kind::rectangle:
      return "list of 4 whole numbers";
    case Kind::two_wholes:
      return "list of 2 whole numbers";
    case Kind::place_by_name:
      return "{ NAME = [x, y, radius], ... }";
    case Kind::mean_and_sd:
      return "{ mean, sd }";
  }
  return "";
}

namespace {

Json list_of(const char* type, std::size_t count) {
  return {{"type", "array"}, {"items", {{"type", type}}}, {"minItems", count}, {"maxItems", count}};
}

Json number_or_angle(const std::string& name) {
  return name.ends_with("_rad") ? Json{{"type", {"number", "string"}}} : Json{{"type", "number"}};
}

}  // namespace

Json KeyFacts::schema() const {
  switch (kind.form) {
    case Kind::number:
      return {{"type", "number"}};
    case Kind::above_zero:
      return {{"type", "number"}, {"exclusiveMinimum", 0}};
    case Kind::not_negative:
      return {{"type", "number"}, {"minimum", 0}};
    case Kind::angle:
      return number_or_angle("_rad");
    case Kind::sd:
    case Kind::sd_of_fit: {
      Json sd = number_or_angle(quantity());
      sd["exclusiveMinimum"] = 0;
      return sd;
    }
    case Kind::whole:
      return {{"type", "integer"}, {"minimum", kind.least}, {"maximum", kind.most}};
    case Kind::word:
      return {{"enum", kind.words}};
    case Kind::text:
    case Kind::file:
      return {{"type", "string"}};
    case Kind::texts:
      return {{"type", "array"}, {"items", {{"type", "string"}}}};
    case Kind::text_or_texts:
      return {{"type", {"string", "array"}}, {"items", {{"type", "string"}}}};
    case Kind::circle:
      return list_of("number", 3);
    case Kind::rectangle:
      return list_of("integer", 4);
    case Kind::two_wholes:
      return list_of("integer", 2);
    case Kind::place_by_name:
      return {{"type", "object"},
              {"additionalProperties",
               {{"type", "array"}, {"items", {{"type", "number"}}}, {"minItems", 3}, {"maxItems", 4}}}};
    case Kind::mean_and_sd:
      return {{"type", "object"},
              {"properties",
               {{"mean", number_or_angle(name)}, {"sd", {{"type", "number"}, {"exclusiveMinimum", 0}}}}},
              {"required", {"mean", "sd"}},
              {"additionalProperties", false}};
  }
  return Json::object();
}

std::vector<OtherName> other_names(std::string_view name) {
  constexpr double turn = 2 * std::numbers::pi;
  if (name == "angular_frequency_rad_s") return {{"omega_rad_s"}, {"frequency_hz", turn}};
  if (name == "omega_rad_s") return {{"angular_frequency_rad_s"}, {"frequency_hz", turn}};
  if (name == "phase_shift_rad") return {{"epsilon_rad"}};
  if (name == "epsilon_rad") return {{"phase_shift_rad"}};
  if (name == "lag_rad") return {{"phase_lag_rad"}};
  return {};
}

std::optional<double> read_number(StrictTable& table, const Kind& kind, const std::string& name) {
  switch (kind.form) {
    case Kind::above_zero:
      return table.positive(name);
    case Kind::not_negative:
      return table.not_negative(name);
    case Kind::angle:
      return table.angle(name);
    case Kind::sd:
    case Kind::sd_of_fit:
      return read_sd(table, name.substr(0, name.size() - 3));
    default:
      return table.number(name);
  }
}

namespace {

bool is_sd(const Kind& kind) {
  return kind.form == Kind::sd || kind.form == Kind::sd_of_fit;
}

/// The number under the key's name or another one of its quantity.
std::optional<double> read_number(StrictTable& table, const KeyFacts& key) {
  std::optional<double> value = read_number(table, key.kind, key.name);
  std::string given = key.name;
  for (const OtherName& other : other_names(key.quantity())) {
    const std::string name = other.name + (is_sd(key.kind) ? "_sd" : "");
    if (!table.has(name)) continue;
    if (value) table.fail(name, fmt::format("and `{}` mean the same; give one of them", given));
    value = other.factor * read_number(table, key.kind, name).value();
    given = name;
  }
  return value;
}

/// One value out of a table.
struct Reader {
  StrictTable& table;
  const KeyFacts& key;
  const std::filesystem::path& folder;

  void operator()(double* value) const {
    if (const auto read = read_number(table, key)) *value = *read;
  }
  void operator()(std::optional<double>* value) const {
    if (const auto read = read_number(table, key)) *value = *read;
  }
  template <class T>
  void operator()(const Milli<T>& milli) const {
    if (const auto read = read_number(table, key)) *milli.value = *read * 1e-3;
  }
  void operator()(int* value) const {
    const auto read = table.integer(key.name);
    if (!read) return;
    if (*read < key.kind.least || *read > key.kind.most)
      table.fail(key.name,
                 fmt::format("must be between {} and {}, not {}", key.kind.least, key.kind.most, *read));
    *value = static_cast<int>(*read);
  }
  void operator()(bool* value) const {
    if (const auto read = table.choice(key.name, key.kind.words)) *value = *read == 1;
  }
  void operator()(model::Start* value) const {
    if (const auto read = table.choice(key.name, key.kind.words)) *value = static_cast<model::Start>(*read);
  }
  void operator()(std::string* value) const {
    if (key.kind.form == Kind::word) {
      if (const auto read = table.choice(key.name, key.kind.words)) *value = key.kind.words[*read];
    } else if (const auto read = table.text(key.name)) {
      *value = *read;
    }
  }
  void operator()(std::optional<std::filesystem::path>* value) const {
    if (const auto read = table.text(key.name)) *value = folder / *read;
  }
  void operator()(std::optional<vision::Circle>* value) const {
    *value = read_circle(table, key.name.c_str());
  }
  void operator()(std::optional<vision::Rect>* value) const { *value = read_template(table); }
};

/// And back.
struct Writer {
  const Kind& kind;

  Json operator()(const double* value) const { return *value; }
  Json operator()(const std::optional<double>* value) const { return optional_json(*value); }
  Json operator()(const Milli<double>& milli) const { return *milli.value * 1e3; }
  Json operator()(const Milli<std::optional<double>>& milli) const {
    return *milli.value ? Json(**milli.value * 1e3) : Json();
  }
  Json operator()(const int* value) const { return *value; }
  Json operator()(const bool* value) const { return kind.words.at(*value ? 1 : 0); }
  Json operator()(const model::Start* value) const { return model::to_string(*value); }
  Json operator()(const std::string* value) const { return *value; }
  Json operator()(const std::optional<std::filesystem::path>* value) const {
    return *value ? Json((*value)->filename().string()) : Json();
  }
  Json operator()(const std::optional<vision::Circle>* value) const { return circle_json(*value); }
  Json operator()(const std::optional<vision::Rect>* value) const { return rect_json(*value); }
};

}  // namespace

void read_value(StrictTable& table, const KeyFacts& key, const std::filesystem::path& folder,
                const Value& value) {
  std::visit(Reader{table, key, folder}, value);
}

Json json_of(const Value& value, const Kind& kind) {
  return std::visit(Writer{kind}, value);
}

void set_value(const Value& value, double number) {
  if (const auto* one = std::get_if<double*>(&value)) **one = number;
  if (const auto* one = std::get_if<std::optional<double>*>(&value)) **one = number;
  if (const auto* one = std::get_if<Milli<double>>(&value)) *one->value = number * 1e-3;
}

}  // namespace tribotrack::apps
