// The keys of a TOML table as a list: each knows its kind of value, the member it fills, an example and what
// it means. Reading, the program's help, its JSON Schema and the configuration in meta files come from it.
//
//   const std::vector<Key<PartSection>> keys = {
//       {"diameter_mm", Kind::above_zero, at<&PartSection::diameter_mm>, "6.0", "sets the scale"},
//       {"diameter_mm_sd", Kind::sd, at<&PartSection::diameter_sd_mm>, "0.005", "by a caliper"}};
//   PartSection part;
//   read_keys(table, keys, part);           // throws InvalidInput with file, line, column and remedy
//   const Json json = written(keys, part);  // {"diameter_mm": 6.0, "diameter_mm_sd": null}
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "apps/text/json.h"
#include "apps/text/strict_toml.h"
#include "model/scenario.h"
#include "vision/picture.h"
#include "vision/tracker.h"

namespace tribotrack::apps {

/// What a value must be.
struct Kind {
  enum Form {
    number,
    above_zero,
    not_negative,
    angle,  ///< rad: a number or a text, parse_angle()
    sd,     ///< of the quantity before "_sd", above 0, and only beside it
    whole,  ///< from `least` to `most`
    word,   ///< one of `words`
    text,
    file,  ///< relative to the folder of the file that names it
    texts,
    text_or_texts,
    true_or_texts,
    circle,     ///< [x, y, radius]
    rectangle,  ///< [x, y, width, height]; the key is `template_px`
    two_wholes,
    place_by_name,  ///< table: NAME = circle or rectangle
    mean_and_sd,    ///< table
  };
  Kind(Form one) : form(one) {}
  static Kind wholes(int least, int most);
  static Kind one_of(std::vector<std::string> words);
  bool is_sd() const { return form == sd; }

  Form form;
  std::vector<std::string> words = {};
  int least = 0, most = 0;
};

/// What a key says of itself.
struct KeyFacts {
  std::string name;
  Kind kind;
  std::string example{};  ///< as TOML
  std::string meaning{};  ///< one line; may be empty
  std::string with{};     ///< another key of the section without which it is refused
  Json otherwise{};       ///< what holds without it; null where nothing does

  /// "number above 0", "angle", "list of 3 numbers"; of words these.
  std::string kind_text() const;
  /// The JSON Schema of its value.
  Json schema() const;
  /// Of the key of an sd the quantity.
  std::string quantity() const;
};

/// Quantities with several names: "frequency_hz" for "angular_frequency_rad_s". Campaigns, scenarios, flags
/// and sweeps take all of them.
struct OtherName {
  std::string name;
  double factor = 1;  ///< from a value under this name to one under the key's own
};
std::vector<OtherName> other_names(std::string_view name);

/// What a reading is known to by its last digit, half a unit evenly distributed. Of one digit the next one
/// counts, since zeros at the end are left out ("0.3" for 0.30). 0 of whole numbers and parts of pi, which
/// are set and not read. "45.5deg": in rad.
double last_digit_sd(std::string_view written);
/// Of a section's values by their keys, in the keys' units; none where it is 0.
using Digits = std::map<std::string, double, std::less<>>;

/// Where a value is kept.
template <class T>
struct Milli {
  T* value;  ///< in m or m/s, the key's in mm or mm/s
};
using Value =
    std::variant<double*, std::optional<double>*, Milli<double>, Milli<std::optional<double>>, int*, bool*,
                 std::string*, std::vector<std::string>*, std::optional<std::filesystem::path>*,
                 std::optional<vision::Circle>*, vision::Target*, model::Start*>;

/// Nothing where the table has no such key. Throws InvalidInput.
std::optional<double> read_number(StrictTable& table, const Kind& kind, const std::string& name);
/// [x, y, radius] or [x, y, width, height].
vision::Target read_place(StrictTable& table, const char* key);
/// Refuses a key that stands without the one it goes with.
void require_company(const StrictTable& table, const KeyFacts& key);
/// Leaves the value alone where the table has no such key. Throws InvalidInput.
void read_value(StrictTable& table, const KeyFacts& key, const std::filesystem::path& folder,
                const Value& value);
void note_digits(const StrictTable& table, const KeyFacts& key, Digits& digits);
Json json_of(const Value& value, const Kind& kind);
/// A number for the key, in its unit.
void set_value(const Value& value, double number);

template <class Section, class Member>
Section section_of(Member Section::*);

/// The member at the end of a path of members.
template <auto first, auto... rest>
auto& member(decltype(section_of(first))& section) {
  if constexpr (sizeof...(rest) == 0)
    return section.*first;
  else
    return member<rest...>(section.*first);
}

/// at<&Run::reading, &Reading::unit>.
template <auto first, auto... rest>
Value at(decltype(section_of(first))& section) {
  return &member<first, rest...>(section);
}
template <auto first, auto... rest>
Value milli(decltype(section_of(first))& section) {
  return Milli{&member<first, rest...>(section)};
}

/// A key with a reader of its own.
template <class Section>
struct Own {
  void (*read)(StrictTable&, Section&, const std::filesystem::path& folder);
  Json (*write)(const Section&) = [](const Section&) { return Json(); };
};

template <class Section>
struct Key : KeyFacts {
  using Place = std::variant<Value (*)(Section&), Own<Section>>;
  Key(std::string key, Kind what, Place where, std::string written_as = "", std::string means = "",
      std::string needs = "")
      : KeyFacts{std::move(key), std::move(what), std::move(written_as), std::move(means), std::move(needs)},
        place(where) {}
  Place place;
  /// Nothing for a key with a reader of its own.
  std::optional<Value> value(Section& section) const {
    const auto* of = std::get_if<0>(&place);
    return of == nullptr ? std::nullopt : std::optional((*of)(section));
  }
};

template <class Section>
using Keys = std::vector<Key<Section>>;

/// Every key of the list that the table has, with the digits of a section that keeps them. Keys of the table
/// that are not in the list are left to StrictTable::finish().
template <class Section>
void read_keys(StrictTable& table, const Keys<Section>& keys, Section& section,
               const std::filesystem::path& folder = {}) {
  for (const Key<Section>& key : keys) {
    require_company(table, key);
    if constexpr (requires { section.digits; }) note_digits(table, key, section.digits);
    if (const auto value = key.value(section))
      read_value(table, key, folder, *value);
    else
      std::get<Own<Section>>(key.place).read(table, section, folder);
  }
}

/// Every key's value in the order of the list, null where there is none; files without their folder.
template <class Section>
Json written(const Keys<Section>& keys, Section section) {
  Json json = Json::object();
  for (const Key<Section>& key : keys) {
    const auto value = key.value(section);
    json[key.name] = value ? json_of(*value, key.kind) : std::get<Own<Section>>(key.place).write(section);
  }
  return json;
}

/// What the keys say of themselves, with the defaults of a section.
template <class Section>
std::vector<KeyFacts> facts_of(const Keys<Section>& keys, const Section& defaults = {}) {
  const Json values = written(keys, defaults);
  std::vector<KeyFacts> facts;
  for (const Key<Section>& key : keys) {
    facts.push_back(key);
    if (const Json& value = values[key.name]; value != "" && !key.kind.is_sd() && key.place.index() == 0)
      facts.back().otherwise = value;
  }
  return facts;
}

}  // namespace tribotrack::apps
