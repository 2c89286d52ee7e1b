#include <fmt/format.h>

#include <algorithm>

#include "apps/files/campaign/keys.h"

namespace tribotrack::apps {

std::string campaign_reference() {
  std::string text =
      R"(A campaign is a TOML file: a lab's recordings and what is to be estimated from them. Units stand in the names of
keys. Angles are radians, or texts such as "11pi/9", "-pi/2", "90deg". KEY_sd is a standard deviation. No typed value
is exact: without KEY_sd a quantity has the larger of two, that of its last digit and a typical one (A 0.5 %, A_y/A
1 %, w 1e-4, epsilon 1 deg, level 2 mrad, inclines 0.1 deg, caliper 0.02 mm; whole numbers and parts of pi have no
last digit), also if it is not given. A phase at the start that nothing shows is unknown. A value that the recordings
show as well is combined with what they show. [fit] exact lists what is exact; g, frame rate and axis are.
`tribotrack init DIR` writes a campaign to start from, `tribotrack help campaign --json` prints these keys as a JSON
Schema, `tribotrack help uncertainty` says what every uncertainty means.
)";
  for (const CampaignSection& section : campaign_sections()) {
    text += section.name.empty() ? fmt::format("\nFirst: {}\n", section.remark)
            : section.repeated   ? fmt::format("\n[[{}]]  {}\n", section.name, section.remark)
                                 : fmt::format("\n[{}]  {}\n", section.name, section.remark);
    for (const KeyFacts& key : section.keys) {
      text += fmt::format("  {:<30} {}\n", fmt::format("{} = {}", key.name, key.example), key.kind_text());
      if (!key.meaning.empty()) text += fmt::format("      {}\n", key.meaning);
    }
  }
  return text;
}

namespace {

bool holds(const std::vector<KeyFacts>& keys, const std::string& name) {
  return std::ranges::count(keys, name, &KeyFacts::name) > 0;
}

/// A table with these keys alone.
Json table_schema(const std::string& remark, const std::vector<KeyFacts>& keys, bool with_defaults) {
  Json properties = Json::object(), required = Json::object();
  for (const KeyFacts& key : keys) {
    Json schema = key.schema();
    if (!key.meaning.empty()) schema["description"] = key.meaning;
    if (with_defaults && !key.otherwise.is_null()) schema["default"] = key.otherwise;
    const bool is_sd = key.quantity() != key.name && holds(keys, key.quantity());
    if (!key.with.empty()) required[key.name] = Json::array({key.with});
    properties[key.name] = schema;
    for (const OtherName& other : other_names(key.quantity())) {
      const std::string name = other.name + (is_sd ? "_sd" : "");
      schema["description"] = fmt::format("another name of {}", key.name);
      properties[name] = schema;
      if (is_sd) required[name] = Json::array({other.name});
    }
    if (is_sd) required[key.name] = Json::array({key.quantity()});
  }
  Json schema = {{"type", "object"},
                 {"description", remark},
                 {"properties", properties},
                 {"additionalProperties", false}};
  if (!required.empty()) schema["dependentRequired"] = required;
  return schema;
}

/// [fit.guess] and [fit.prior]: every parameter as the one that is listed.
std::vector<KeyFacts> for_every_parameter(const CampaignSection& section) {
  std::vector<KeyFacts> keys;
  for (const fit::FitParameter parameter : fit_parameters()) {
    keys.push_back(section.keys.front());
    keys.back().name = fit::to_string(parameter);
    keys.back().meaning = "";
    if (keys.back().kind.form != Kind::mean_and_sd) keys.back().kind = kind_of(parameter);
  }
  return keys;
}

}  // namespace

Json campaign_schema() {
  Json schema;
  for (const CampaignSection& section : campaign_sections()) {
    const bool by_parameter = section.name == "fit.guess" || section.name == "fit.prior";
    Json table = table_schema(section.remark, by_parameter ? for_every_parameter(section) : section.keys,
                              !section.repeated);
    if (section.name.empty()) {
      schema = {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                {"title", "tribotrack campaign"}};
      schema.update(table);
    } else if (section.name == "part") {  // [part], or [[part]] for several
      schema["properties"]["part"] = {{"oneOf", Json::array({table, {{"type", "array"}, {"items", table}}})}};
    } else if (section.repeated) {
      schema["properties"][section.name] = {{"type", "array"}, {"items", table}};
    } else if (const auto dot = section.name.find('.'); dot != std::string::npos) {
      schema["properties"][section.name.substr(0, dot)]["properties"][section.name.substr(dot + 1)] = table;
    } else {
      schema["properties"][section.name] = table;
    }
  }
  return schema;
}

}  // namespace tribotrack::apps
