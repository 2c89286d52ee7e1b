#include "apps/files/campaign/keys.h"

#include <fmt/format.h>

#include <algorithm>

namespace tribotrack::apps {

const Keys<Campaign>& top_keys() {
  static const Keys<Campaign> keys = {
      {"title", Kind::text, at<&Campaign::title>, "\"Silver disc, 6 mm, on polished duralumin\"",
       "of the report; else this file's name"},
  };
  return keys;
}

const Keys<PlatformSection>& platform_keys() {
  using P = PlatformSection;
  static const Keys<P> keys = {
      {"amplitude_mm", Kind::not_negative, milli<&P::amplitude>, "0.28",
       "A; leave out to measure it from mark or texture. 0: platform at rest"},
      {"amplitude_mm_sd", Kind::sd, milli<&P::amplitude_sd>, "0.001",
       "its standard deviation; without one that of the last digit, 0.5 % at least"},
      {"amplitude_y_mm", Kind::not_negative, milli<&P::amplitude_y>, "0.28",
       "A_y, where the platform moves on an ellipse"},
      {"amplitude_y_mm_sd", Kind::sd, milli<&P::amplitude_y_sd>, "0.001"},
      {"angular_frequency_rad_s", Kind::above_zero, at<&P::angular_frequency>, "62.8",
       "w; leave out to measure it. Also as frequency_hz, w / 2 pi"},
      {"angular_frequency_rad_s_sd", Kind::sd, at<&P::angular_frequency_sd>, "0.001"},
      {"phase_shift_rad", Kind::angle, at<&P::phase_shift>, "\"pi/2\"",
       "epsilon: pi/2 turns clockwise, \"-pi/2\" counter-clockwise, as seen with y up; leave out to measure "
       "it"},
      {"phase_shift_rad_sd", Kind::sd, at<&P::phase_shift_sd>, "0.01"},
      {"gravity_m_s2", Kind::above_zero, at<&P::gravity>, "9.81"},
      {"gravity_m_s2_sd", Kind::sd, at<&P::gravity_sd>, "0.001"},
      {"tilt_x_rad", Kind::angle, at<&P::tilt_x>, "\"0.1deg\"",
       "slope of the platform towards +x (right): gravity pulls with g sin(tilt)"},
      {"tilt_x_rad_sd", Kind::sd, at<&P::tilt_x_sd>, "0.0002", "by the resolution of the spirit level"},
      {"tilt_y_rad", Kind::angle, at<&P::tilt_y>, "0.0", "likewise towards +y (up)"},
      {"tilt_y_rad_sd", Kind::sd, at<&P::tilt_y_sd>, "0.0002"},
  };
  return keys;
}

const Keys<DataSection>& data_keys() {
  using D = DataSection;
  static const Keys<D> keys = {
      {"table", Kind::text_or_texts, Own<D>{read_tables, written_tables}, "\"alpha_v.csv\"",
       "or a list; every point becomes a run: columns phi_deg, dtau_deg, alpha_deg, v_mm_s (or phi_rad, "
       "...), alpha_sd_deg, v_sd_mm_s; separated by , ; or tabs"},
      {"runs", Kind::file, at<&D::runs>, "\"runs.csv\"",
       "a [[run]] for each line: columns video or track, phi_deg, dtau_deg, name, or any other key of a run"},
      {"alpha_sd_rad", Kind::angle, at<&D::alpha_sd>, "\"2deg\"",
       "of the lines that have none; else repeats of a point tell", "table"},
      {"v_sd_mm_s", Kind::above_zero, milli<&D::v_sd>, "0.1", "likewise", "table"},
      {"track_unit", Kind::one_of(kTrackUnits), at<&D::tracks, &TrackReading::unit>, "\"mm\"",
       "of tracks whose columns name none: px (with mm_per_px), um, mm, cm, m"},
      {"track_y", Kind::one_of(kTrackY), at<&D::tracks, &TrackReading::y>, "\"up\"",
       "where y of tracks points, if not down in pixels and up in lengths"},
      {"track_frame", Kind::one_of(kTrackFrames), at<&D::tracks, &TrackReading::frame>, "\"platform\"",
       "of tracks: \"platform\": its motion is taken out of them already; else by track_mark, or \"camera\""},
      {"track_point", Kind::text, at<&D::tracks, &TrackReading::point>, "\"mass A\"",
       "which point of tracks is the part, where there are several"},
      {"track_mark", Kind::text, at<&D::tracks, &TrackReading::mark>, "\"mass B\"",
       "and which is fixed to the platform, if one is"},
  };
  return keys;
}

namespace {

/// Of [fit.fixed] and [fit.guess].
KeyFacts of_parameter(fit::FitParameter parameter, const char* example, const char* meaning = "") {
  return {fit::to_string(parameter), kind_of(parameter), example, meaning};
}

}  // namespace

const std::vector<CampaignSection>& campaign_sections() {
  using Quantity = fit::FitParameter;
  static const std::vector<CampaignSection> sections = {
      {"", "the campaign as a whole", facts_of(top_keys())},
      {"platform", "xi = A cos(wt) to the right, eta = A_y cos(wt + epsilon) upwards",
       facts_of(platform_keys())},
      {"part", "what lies on the platform", facts_of(part_keys())},
      {"camera", "the picture: its scale, its time, and what lies where in the first analysed frame",
       facts_of(camera_keys())},
      {"scope", "oscilloscope traces that runs name by `scope`", facts_of(scope_keys())},
      {"data", "alpha and v from a spreadsheet, and tracks of other programs", facts_of(data_keys())},
      {"fit", "what is fitted, to what", facts_of(fit_keys())},
      {"fit.fixed",
       "values of mu1, mu2, phase_lag_rad or delay_s that are not among `parameters`",
       {of_parameter(Quantity::mu1, "0.1"), of_parameter(Quantity::mu2, "0.01"),
        of_parameter(Quantity::lag, "0.2"),
        of_parameter(Quantity::delay, "0.003", "the lag as a time, the same at all frequencies")}},
      {"fit.guess",
       "first guesses, where the fit needs better ones than its own",
       {of_parameter(Quantity::mu1, "0.1", "or any other of `parameters`")}},
      {"fit.prior",
       "what is known beforehand of what is fitted",
       {{"mu1", Kind::mean_and_sd, "{ mean = 0.1, sd = 0.01 }", "or any other of `parameters`"}}},
      {"run", "one per recording. Vary phi AND dtau: phi alone cannot separate mu1 from the lag",
       facts_of(run_keys()), true},
  };
  return sections;
}

std::vector<std::string> sections_with(const std::string& key) {
  std::vector<std::string> names;
  for (const CampaignSection& section : campaign_sections())
    if (std::ranges::count(section.keys, key, &KeyFacts::name) > 0) names.push_back(section.name);
  return names;
}

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

namespace {

Json fit_configuration(const FitSection& fit) {
  Json json = written(fit_keys(), fit);
  for (const auto& [name, values] : {std::pair{"fixed", &fit.fixed}, std::pair{"guess", &fit.guess}}) {
    json[name] = Json::object();
    for (const auto& [parameter, value] : *values) json[name][fit::to_string(parameter)] = value;
  }
  json["prior"] = Json::object();
  for (const auto& [parameter, prior] : fit.prior)
    json["prior"][fit::to_string(parameter)] = {{"mean", prior.mean}, {"sd", prior.sd}};
  return json;
}

/// What a run says itself; what it does not stands in the sections.
Json run_configuration(const CampaignRun& run) {
  Json json = Json::object();
  const Json own = written(run_keys(), run);
  for (const auto& [key, value] : own.items())
    if (!value.is_null() && value != "" && (run.track || !key.starts_with("track"))) json[key] = value;
  if (!run.pooled_from.empty()) json["pooled_from"] = run.pooled_from;
  return json;
}

}  // namespace

Json Campaign::effective_configuration() const {
  Json json;
  if (!title.empty()) json["title"] = title;
  json["platform"] = written(platform_keys(), platform);
  json["part"] = written(part_keys(), part);
  json["camera"] = written(camera_keys(), camera);
  json["scope"] = written(scope_keys(), scope);
  json["data"] = written(data_keys(), data);
  json["fit"] = fit_configuration(fit);
  json["runs"] = Json::array();
  for (const CampaignRun& run : runs) json["runs"].push_back(run_configuration(run));
  return json;
}

}  // namespace tribotrack::apps
