#include "apps/files/keys.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <numbers>

#include "apps/files/camera.h"
#include "apps/files/run_folder.h"
#include "apps/text/angle.h"

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

namespace {

/// How a form is called, and its JSON Schema.
struct FormFacts {
  const char* text;
  const char* schema;
};

/// In the order of Kind::Form.
constexpr FormFacts kForms[] = {
    {"number", R"({"type": "number"})"},
    {"number above 0", R"({"type": "number", "exclusiveMinimum": 0})"},
    {"number, 0 or more", R"({"type": "number", "minimum": 0})"},
    {"angle", R"({"type": ["number", "string"]})"},
    {"number", R"({"type": "number", "exclusiveMinimum": 0})"},
    {"whole number", R"({"type": "integer"})"},
    {"word", R"({"type": "string"})"},
    {"text", R"({"type": "string"})"},
    {"text", R"({"type": "string"})"},
    {"list of texts", R"({"type": "array", "items": {"type": "string"}})"},
    {"text", R"({"type": ["string", "array"], "items": {"type": "string"}})"},
    {"true, or list of texts", R"({"type": ["boolean", "array"], "items": {"type": "string"}})"},
    {"list of 3 numbers", R"({"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3})"},
    {"list of 4 whole numbers",
     R"({"type": "array", "items": {"type": "integer"}, "minItems": 4, "maxItems": 4})"},
    {"list of 2 or 3 whole numbers",
     R"({"type": "array", "items": {"type": "integer"}, "minItems": 2, "maxItems": 3})"},
    {"{ NAME = [x, y, radius], ... }",
     R"({"type": "object", "additionalProperties":
         {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 4}})"},
    {"{ mean, sd }",
     R"({"type": "object", "properties": {"mean": {"type": ["number", "string"]},
         "sd": {"type": "number", "exclusiveMinimum": 0}},
         "required": ["mean", "sd"], "additionalProperties": false})"},
};

}  // namespace

std::string KeyFacts::kind_text() const {
  if (kind.form == Kind::word) return fmt::format("\"{}\"", fmt::join(kind.words, "\", \""));
  const bool sd_of_angle = kind.is_sd() && quantity().ends_with("_rad");
  return kForms[sd_of_angle ? Kind::angle : kind.form].text;
}

Json KeyFacts::schema() const {
  Json schema = Json::parse(kForms[kind.form].schema);
  if (kind.form == Kind::word) schema["enum"] = kind.words;
  if (kind.form == Kind::whole) schema.update({{"minimum", kind.least}, {"maximum", kind.most}});
  if (kind.is_sd() && quantity().ends_with("_rad")) schema["type"] = {"number", "string"};
  return schema;
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

double last_digit_sd(std::string_view written) {
  const bool degrees = written.ends_with("deg");
  const std::string_view mantissa = written.substr(0, written.find_first_of("eEd"));
  const bool exponent = !degrees && mantissa.size() < written.size();
  const auto point = mantissa.find('.');
  if (written.find("pi") != std::string_view::npos || (point == std::string_view::npos && !exponent))
    return 0;
  int decimals = 0, digits = 0;
  for (std::size_t i = 0; i < mantissa.size(); ++i) {
    if (std::isdigit(static_cast<unsigned char>(mantissa[i])) == 0) continue;
    decimals += i > point ? 1 : 0;
    digits += digits > 0 || mantissa[i] != '0' ? 1 : 0;
  }
  if (digits == 0) return 0;
  const double unit =
      std::pow(10, (digits == 1 ? -1 : 0) - decimals) *
      (exponent ? parse_number("1" + std::string(written.substr(mantissa.size()))).value_or(0) : 1);
  return unit / std::sqrt(12) * (degrees ? std::numbers::pi / 180 : 1);
}

void note_digits(const StrictTable& table, const KeyFacts& key, Digits& digits) {
  const Kind::Form form = key.kind.form;
  if (form != Kind::number && form != Kind::above_zero && form != Kind::not_negative && form != Kind::angle)
    return;
  std::vector<OtherName> names = other_names(key.name);
  names.push_back({key.name});
  for (const OtherName& name : names)
    if (const double sd = name.factor * last_digit_sd(table.written(name.name)); sd > 0)
      digits[key.name] = sd;
}

namespace {

/// Beyond what any laboratory has: a slip, which the fit would take at its word. By the unit in the key's
/// name.
void require_sense(const StrictTable& table, const std::string& name, double value) {
  struct Most {
    std::string_view unit, text;
    double value;
  };
  constexpr std::array kMost = {Most{"_mm_s", "mm/s", 1e7}, Most{"_rad_s", "rad/s", 1e10},
                                Most{"_m_s2", "m/s2", 100}, Most{"_mm_per_px", "mm/px", 1e3},
                                Most{"_mm", "mm", 1e6},     Most{"_hz", "Hz", 1e10},
                                Most{"_s", "s", 1e7}};
  const std::string key = "_" + (name.ends_with("_sd") ? name.substr(0, name.size() - 3) : name);
  for (const Most& most : kMost) {
    if (!key.ends_with(most.unit)) continue;
    if (std::abs(value) > most.value)
      table.fail(name, fmt::format("cannot be {:g}: nothing here has more than {:g} {}", value, most.value,
                                   most.text));
    return;
  }
}

std::optional<double> number_of(StrictTable& table, const Kind& kind, const std::string& name) {
  switch (kind.form) {
    case Kind::above_zero:
      return table.positive(name);
    case Kind::not_negative:
      return table.not_negative(name);
    case Kind::angle:
      return table.angle(name);
    case Kind::sd:
      return read_sd(table, name.substr(0, name.size() - 3));
    default:
      return table.number(name);
  }
}

}  // namespace

std::optional<double> read_number(StrictTable& table, const Kind& kind, const std::string& name) {
  const auto value = number_of(table, kind, name);
  if (value) require_sense(table, name, *value);
  return value;
}

namespace {

/// The number under the key's name or another one of its quantity.
std::optional<double> read_number(StrictTable& table, const KeyFacts& key) {
  std::optional<double> value = read_number(table, key.kind, key.name);
  std::string given = key.name;
  for (const OtherName& other : other_names(key.quantity())) {
    const std::string name = other.name + (key.kind.is_sd() ? "_sd" : "");
    if (!table.has(name)) continue;
    if (value) table.fail(name, fmt::format("and `{}` mean the same; give one of them", given));
    value = other.factor * read_number(table, key.kind, name).value();
    given = name;
  }
  return value;
}

/// [x, y, radius], the radius above 0.
std::optional<vision::Circle> read_circle(StrictTable& table, const char* key) {
  const auto values = table.numbers(key, 3);
  if (!values) return std::nullopt;
  if (!((*values)[2] > 0))
    table.fail(key, fmt::format("must have a radius greater than 0, not {}", (*values)[2]));
  return vision::Circle{(*values)[0], (*values)[1], (*values)[2]};
}

vision::Rect rect_of(const StrictTable& table, const char* key, const std::vector<std::int64_t>& values) {
  for (const std::int64_t value : values)
    if (value < 0 || value > 65535) table.fail(key, fmt::format("must lie in the picture, not at {}", value));
  const vision::Rect rect{static_cast<int>(values[0]), static_cast<int>(values[1]),
                          static_cast<int>(values[2]), static_cast<int>(values[3])};
  if (rect.width < 8 || rect.height < 8)
    table.fail(key, fmt::format("is [x, y, width, height], at least 8 x 8 pixels, not {} x {}", rect.width,
                                rect.height));
  return rect;
}

/// In whole pixels; refused beside disc_px.
std::optional<vision::Target> read_template(StrictTable& table) {
  const auto values = table.integers("template_px", 4);
  if (!values) return std::nullopt;
  if (table.has("disc_px")) table.fail("template_px", "and `disc_px` are two parts; give one of them");
  return vision::Target{vision::Target::Kind::rectangle, {}, rect_of(table, "template_px", *values)};
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
  void operator()(std::vector<std::string>* value) const {
    if (auto read = table.texts(key.name)) *value = std::move(*read);
  }
  void operator()(std::optional<std::filesystem::path>* value) const {
    if (const auto read = table.text(key.name)) *value = folder / *read;
  }
  void operator()(std::optional<vision::Circle>* value) const {
    if (const auto read = read_circle(table, key.name.c_str())) *value = *read;
  }
  void operator()(vision::Target* value) const {
    if (key.kind.form == Kind::rectangle) {
      if (const auto read = read_template(table)) *value = *read;
    } else if (const auto read = read_circle(table, key.name.c_str())) {
      *value = {vision::Target::Kind::disc, *read, {}};
    }
  }
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
  Json operator()(const std::vector<std::string>* value) const { return *value; }
  Json operator()(const std::optional<std::filesystem::path>* value) const {
    return *value ? Json((*value)->filename().string()) : Json();
  }
  Json operator()(const std::optional<vision::Circle>* value) const { return circle_json(*value); }
  Json operator()(const vision::Target* value) const {
    using Is = vision::Target::Kind;
    if (kind.form == Kind::rectangle)
      return value->kind == Is::rectangle ? rect_json(value->rectangle) : Json();
    return value->kind == Is::disc ? circle_json(value->disc) : Json();
  }
};

}  // namespace

vision::Target read_place(StrictTable& table, const char* key) {
  if (table.count(key) == 4)
    return {vision::Target::Kind::rectangle, {}, rect_of(table, key, *table.integers(key, 4))};
  return {vision::Target::Kind::disc, read_circle(table, key).value(), {}};
}

void require_company(const StrictTable& table, const KeyFacts& key) {
  if (!key.with.empty() && table.has(key.name) && !table.has(key.with))
    table.fail(key.name, fmt::format("needs `{}`, which is not given here: give both, or neither", key.with));
}

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
