#include "apps/files/campaign.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

#include "apps/files/kinds/toml_kind.h"
#include "apps/files/meta_file.h"
#include "apps/program/errors.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;
using fit::FitParameter;

namespace {

constexpr const char* kGuessHint =
    "is a word, how the runs start; first guesses of parameters stand in the table [fit.guess]";

const std::vector<FitParameter> kFitParameters = {
    FitParameter::mu1,   FitParameter::mu2,       FitParameter::lag,
    FitParameter::delay, FitParameter::amplitude, FitParameter::angular_frequency,
    FitParameter::scale, FitParameter::tilt_x,    FitParameter::tilt_y};

std::vector<std::string> fit_parameter_names() {
  std::vector<std::string> names;
  for (const FitParameter parameter : kFitParameters) names.emplace_back(fit::to_string(parameter));
  return names;
}

ScopeSection read_scope(StrictTable& table) {
  ScopeSection scope;
  const auto channel = [&](const char* key, int fallback) {
    const auto value = table.integer(key).value_or(fallback);
    if (value < 0 || value > 4)
      table.fail(key, fmt::format("must be 1 to 4, the file's first to fourth channel, or 0 for none, not {}",
                                  value));
    return static_cast<int>(value);
  };
  scope.sensor_channel = channel("sensor_channel", scope.sensor_channel);
  scope.actuator_channel = channel("actuator_channel", scope.actuator_channel);
  if (scope.sensor_channel != 0 && scope.sensor_channel == scope.actuator_channel)
    table.fail(
        table.has("sensor_channel") ? "sensor_channel" : "actuator_channel",
        fmt::format("is {}, and so is `{}`: one channel holds either the sensor's pulses or the actuator's "
                    "bursts",
                    scope.sensor_channel,
                    table.has("sensor_channel") ? "actuator_channel" : "sensor_channel"));
  scope.carrier_hz = table.positive("carrier_hz").value_or(scope.carrier_hz);
  scope.sensor_delay_s = table.number("sensor_delay_s").value_or(0);
  scope.sensor_delay_sd_s = table.not_negative("sensor_delay_sd_s").value_or(0);
  constexpr std::array<const char*, 3> ties = {"sensor", "trigger", "lamp"};
  scope.tie = ties[table.choice("tie", {"sensor", "trigger", "lamp"}).value_or(0)];
  scope.trigger_time_s = table.number("trigger_time_s");
  scope.tie_sd_s = table.not_negative("tie_sd_s").value_or(0);
  table.finish();
  return scope;
}

FitParameter require_fit_parameter(const StrictTable& table, std::string_view key, const std::string& name) {
  if (const auto parameter = fit_parameter_named(name)) return *parameter;
  const std::string near = nearest_word(name, fit_parameter_names());
  table.fail(key,
             fmt::format("names \"{}\", which cannot be fitted; {}", name,
                         near.empty() ? fmt::format("these can: {}", fmt::join(fit_parameter_names(), ", "))
                                      : fmt::format("did you mean \"{}\"?", near)));
}

/// One value of a parameter, as [fit.fixed], [fit.guess] and [fit.prior] give it. Angles may be texts.
std::optional<double> read_value(StrictTable& table, const char* key, FitParameter parameter) {
  const bool angle = std::string_view(fit::to_string(parameter)).ends_with("_rad");
  return angle ? table.angle(key) : table.number(key);
}

/// `place`: the key of `table` that an error is said of.
void require_in_range(const StrictTable& table, const char* place, FitParameter parameter, double value) {
  switch (parameter) {
    case FitParameter::mu1:
    case FitParameter::mu2:
      if (value < 0) table.fail(place, fmt::format("must be 0 or more, not {}", value));
      break;
    case FitParameter::amplitude:
    case FitParameter::angular_frequency:
    case FitParameter::scale:
      if (!(value > 0)) table.fail(place, fmt::format("must be greater than 0, not {}", value));
      break;
    default:
      break;
  }
}

/// A table of values by parameter name.
std::map<FitParameter, double> read_values(StrictTable table, const std::vector<FitParameter>& allowed) {
  std::map<FitParameter, double> values;
  for (const FitParameter parameter : allowed) {
    const char* name = fit::to_string(parameter);
    if (const auto value = read_value(table, name, parameter)) {
      require_in_range(table, name, parameter, *value);
      values[parameter] = *value;
    }
  }
  table.finish();
  return values;
}

struct FitDefaults {
  model::Start start = model::Start::rest;
  int cycles = 20;
};

int read_cycles(StrictTable& table, int fallback) {
  const auto cycles = table.integer("cycles").value_or(fallback);
  if (cycles < 1 || cycles > 1'000'000)
    table.fail("cycles", fmt::format("must be between 1 and 1000000, not {}", cycles));
  return static_cast<int>(cycles);
}

model::Start read_start(StrictTable& table, model::Start fallback) {
  const auto choice = table.choice("start", {"rest", "circling", "steady"});
  return choice ? static_cast<model::Start>(*choice) : fallback;
}

FitSection read_fit(StrictTable& table, FitDefaults& defaults) {
  FitSection section;
  if (const auto names = table.texts("parameters")) {
    section.parameters.clear();
    for (const auto& name : *names) {
      const FitParameter parameter = require_fit_parameter(table, "parameters", name);
      if (std::count(section.parameters.begin(), section.parameters.end(), parameter) > 0)
        table.fail("parameters", fmt::format("names \"{}\" twice", name));
      section.parameters.push_back(parameter);
    }
    if (section.parameters.empty())
      table.fail("parameters", "is empty; name what is to be fitted, such as [\"mu1\"]");
  }
  section.trajectory = table.choice("data", {"summary", "trajectory"}).value_or(0) == 1;
  if (table.is_table("start")) table.fail("start", kGuessHint);
  defaults.start = read_start(table, defaults.start);
  if (auto guesses = table.table("guess")) section.guess = read_values(*guesses, kFitParameters);
  defaults.cycles = read_cycles(table, defaults.cycles);
  if (auto fixed = table.table("fixed"))
    section.fixed =
        read_values(*fixed, {FitParameter::mu1, FitParameter::mu2, FitParameter::lag, FitParameter::delay});
  for (const auto& [parameter, value] : section.fixed)
    if (std::count(section.parameters.begin(), section.parameters.end(), parameter) > 0)
      table.fail("fixed",
                 fmt::format("holds {}, which `parameters` lists as fitted; take it out of one of them",
                             fit::to_string(parameter)));
  if (auto prior = table.table("prior")) {
    for (const std::string& name : prior->keys()) {
      const FitParameter parameter = require_fit_parameter(*prior, name, name);
      if (std::count(section.parameters.begin(), section.parameters.end(), parameter) == 0)
        prior->fail(name,
                    "is not among `parameters`, and a prior of what is not fitted has no effect: add it "
                    "there, or give the value with its sd where it belongs");
      auto entry = prior->table(name);
      const auto mean = read_value(*entry, "mean", parameter);
      const auto sd = entry->positive("sd");
      entry->finish();
      if (!mean || !sd) prior->fail(name, "needs a mean and an sd: { mean = 0.1, sd = 0.01 }");
      require_in_range(*prior, name.c_str(), parameter, *mean);
      section.prior[parameter] = {*mean, *sd};
    }
    prior->finish();
  }
  table.finish();
  return section;
}

/// The sds of what this run alone is given.
void read_sds(StrictTable& table, CampaignRun& run) {
  for (const auto& [key, sd] : {std::pair{"phi_rad", &run.phi_sd}, std::pair{"dtau_rad", &run.dtau_sd},
                                std::pair{"amplitude_mm", &run.amplitude_sd},
                                std::pair{"angular_frequency_rad_s", &run.angular_frequency_sd},
                                std::pair{"phase_at_zero_rad", &run.phase_at_zero_sd},
                                std::pair{"start_phase_rad", &run.start_phase_sd}}) {
    *sd = read_sd(table, key);
    if (*sd && run.free_slide)
      table.fail(std::string(key) + "_sd", "belongs to a driven run: a free slide's platform rests");
  }
  if (run.amplitude_sd) *run.amplitude_sd *= 1e-3;
  run.mm_per_px_sd = read_sd(table, "mm_per_px");
  if (!run.has_track())
    for (const auto& [key, sd] : {std::pair{"phase_at_zero_rad_sd", run.phase_at_zero_sd},
                                  std::pair{"mm_per_px_sd", run.mm_per_px_sd}})
      if (sd) table.fail(key, "belongs to a run with a video or a track");
  if (run.start_phase_sd && run.phase_at_zero)
    table.fail("start_phase_rad_sd", "is not needed: phase_at_zero_rad gives the phase at the start");
}

/// A finished track. What belongs to tracking does not belong to it.
void read_track(StrictTable& table, const Campaign& campaign, CampaignRun& run) {
  if (const auto track = table.text("track")) run.track = campaign.file.parent_path() / *track;
  if (run.track && run.video)
    table.fail("track", "and `video` are two sources of one motion; a run has one of them");
  if (!run.track)
    for (const char* key : {"track_unit", "track_y", "track_point", "track_mark"})
      if (table.has(key)) table.fail(key, "belongs to a run with a `track`");
  if (run.track)
    for (const char* key : {"disc_px", "template_px", "marker_px"})
      if (table.has(key)) table.fail(key, "is for tracking a `video`; this run's `track` is finished");
  run.reading = read_track_reading(table, campaign.data.tracks);
}

/// What the campaign's other keys say of a run's track.
void complete_reading(const CameraSection& camera, CampaignRun& run) {
  TrackReading& reading = run.reading;
  reading.mm_per_px = run.mm_per_px ? run.mm_per_px : camera.mm_per_px;
  reading.mm_per_px_sd = run.mm_per_px ? run.mm_per_px_sd.value_or(0) : camera.mm_per_px_sd;
  reading.frame_rate_hz = camera.frame_rate_hz;
  reading.xi_axis_rad = camera.xi_axis_rad;
  reading.first_frame = run.first_frame;
  reading.last_frame = run.last_frame;
}

CampaignRun read_run(StrictTable& table, const Campaign& campaign, const FitDefaults& defaults) {
  CampaignRun run;
  run.place = table.place();
  if (const auto video = table.text("video")) run.video = campaign.file.parent_path() / *video;
  read_track(table, campaign, run);
  run.name = table.text("name").value_or("");
  run.free_slide = table.choice("kind", {"pulses", "free_slide"}).value_or(0) == 1;
  const auto phi = table.angle("phi_rad");
  const auto dtau = table.angle("dtau_rad");
  if (dtau && !(*dtau >= 0 && *dtau <= 6.283185307179587))
    table.fail("dtau_rad",
               fmt::format("must lie between 0 and 2pi, not {0}: degrees? write \"{0}deg\"", *dtau));
  run.phi = phi.value_or(0);
  run.dtau = dtau.value_or(0);
  if (const auto amplitude = table.not_negative("amplitude_mm")) run.amplitude = *amplitude * 1e-3;
  run.angular_frequency = table.positive("angular_frequency_rad_s");
  run.phase_at_zero = table.angle("phase_at_zero_rad");
  run.start_phase = table.angle("start_phase_rad");
  run.start = read_start(table, defaults.start);
  run.cycles = read_cycles(table, defaults.cycles);
  if (const auto frames = table.integers("frames", 2)) {
    if ((*frames)[0] > (*frames)[1]) table.fail("frames", "must be [first, last], both included");
    run.first_frame = (*frames)[0];
    run.last_frame = (*frames)[1];
  }
  run.mm_per_px = table.positive("mm_per_px");
  read_sds(table, run);
  run.disc_px = read_circle(table, "disc_px");
  run.template_px = read_template(table);
  run.marker_px = read_circle(table, "marker_px");
  if (const auto scope = table.text("scope")) run.scope = campaign.file.parent_path() / *scope;
  run.alpha = table.angle("alpha_rad");
  run.alpha_sd = table.positive("alpha_sd_rad");
  run.v = table.not_negative("v_mm_s");
  run.v_sd = table.positive("v_sd_mm_s");
  table.finish();
  for (auto* value : {&run.v, &run.v_sd})
    if (*value) **value *= 1e-3;

  const bool any_summary = run.alpha || run.alpha_sd || run.v || run.v_sd;
  const bool whole_summary = run.alpha && run.alpha_sd && run.v && run.v_sd;
  complete_reading(campaign.camera, run);
  if (run.has_track() && any_summary)
    throw InvalidInput(fmt::format(
        "{}: a run has either a video (or track) or alpha_rad, v_mm_s measured elsewhere, not both",
        run.place));
  if (!run.has_track() && !whole_summary)
    throw InvalidInput(fmt::format(
        "{}: a run needs `video` or `track`, or all of alpha_rad, alpha_sd_rad, v_mm_s, v_sd_mm_s",
        run.place));
  if (!run.has_track() && run.free_slide)
    throw InvalidInput(
        fmt::format("{}: a free slide needs `video` or `track`: mu1 comes from its whole track", run.place));
  if (!run.free_slide && (!phi || !dtau))
    throw InvalidInput(
        fmt::format("{}: a run needs `phi_rad` and `dtau_rad` (or kind = \"free_slide\")", run.place));
  const bool scale_given = run.mm_per_px || campaign.camera.mm_per_px || campaign.camera.calibration;
  if (run.video && !scale_given && (run.template_px || (campaign.camera.template_px && !run.disc_px)))
    throw InvalidInput(fmt::format(
        "{}: a part that is followed by template_px has no diameter to scale by: give `mm_per_px` or "
        "`calibration` in [camera]",
        run.place));
  if (run.video && !scale_given && !campaign.part.diameter_mm)
    throw InvalidInput(
        fmt::format("{}: the size of a pixel is not known; give `diameter_mm` in [part], or `mm_per_px` or "
                    "`calibration` in [camera]",
                    run.place));
  return run;
}

void name_runs(std::vector<CampaignRun>& runs) {
  std::set<std::string> taken;
  for (const CampaignRun& run : runs)
    if (!run.name.empty() && !taken.insert(run.name).second)
      throw InvalidInput(fmt::format("{}: the name \"{}\" is taken by an earlier run", run.place, run.name));
  for (std::size_t k = 0; k < runs.size(); ++k) {
    CampaignRun& run = runs[k];
    if (run.name.find('/') != std::string::npos || run.name == "." || run.name == "..")
      throw InvalidInput(fmt::format("{}: the name \"{}\" cannot be a folder's name", run.place, run.name));
    if (!run.name.empty()) continue;
    const std::string base = run.video   ? run.video->stem().string()
                             : run.track ? run.track->stem().string()
                                         : fmt::format("run{:02}", k + 1);
    run.name = base;
    for (int n = 2; !taken.insert(run.name).second; ++n) run.name = fmt::format("{}_{}", base, n);
  }
}

}  // namespace

std::optional<FitParameter> fit_parameter_named(const std::string& name) {
  for (const FitParameter parameter : kFitParameters)
    if (name == fit::to_string(parameter)) return parameter;
  return std::nullopt;
}

double si_per_campaign_unit(FitParameter parameter) {
  return parameter == FitParameter::amplitude ? 1e-3 : 1;
}

namespace {

/// TOML calls `start = "rest"` in [fit] beside a table [fit.start] one key defined twice.
StrictTable parse_campaign(const std::string& text, const fs::path& file) {
  try {
    return StrictTable::parse(text, file.string());
  } catch (const InvalidInput& error) {
    const std::string message = error.what();
    if (message.find("start` is given twice") == std::string::npos) throw;
    throw InvalidInput(
        fmt::format("{}: `start` in [fit] {}", message.substr(0, message.find(": ")), kGuessHint));
  }
}

}  // namespace

namespace {

/// sds that have nothing to act on, or that say the same as a prior.
void check_sds(const Campaign& campaign, StrictTable& top) {
  const CameraSection& camera = campaign.camera;
  if (campaign.part.height_sd_mm && !camera.working_distance_mm && !camera.calibration)
    top.table("part")->fail("height_mm_sd",
                            "needs working_distance_mm (or a calibration) in [camera]: without "
                            "it the height is not used");
  if (camera.working_distance_sd_mm && (!campaign.part.height_mm || camera.calibration))
    top.table("camera")->fail("working_distance_mm_sd",
                              camera.calibration
                                  ? "is not used: the calibration holds its own distance"
                                  : "needs height_mm in [part]: without it the distance is not "
                                    "used");
  const PlatformSection& p = campaign.platform;
  const std::map<FitParameter, bool> known = {
      {FitParameter::amplitude, p.amplitude_sd.has_value()},
      {FitParameter::angular_frequency, p.angular_frequency_sd.has_value()},
      {FitParameter::tilt_x, p.tilt_x_sd.has_value()},
      {FitParameter::tilt_y, p.tilt_y_sd.has_value()},
      {FitParameter::scale, camera.mm_per_px_sd > 0}};
  for (const auto& [parameter, has_sd] : known)
    if (has_sd && campaign.fit.prior.contains(parameter))
      top.table("fit")->table("prior")->fail(
          fit::to_string(parameter),
          fmt::format("and {}_sd are the same knowledge; give one of them", fit::to_string(parameter)));
}

/// What the runs' motion depends on and is neither fitted nor given. A lag that is left out would count as 0.
void require_all_parameters(const Campaign& campaign, StrictTable& top) {
  const auto known = [&](FitParameter parameter) {
    return campaign.fit.fixed.contains(parameter) ||
           std::count(campaign.fit.parameters.begin(), campaign.fit.parameters.end(), parameter) > 0;
  };
  const auto demand = [&](const char* names) {
    top.table("fit")->fail("parameters",
                           fmt::format("does not name {0}, and [fit.fixed] holds no value of {0}: "
                                       "fit it, or give it there",
                                       names));
  };
  const bool pulses = std::any_of(campaign.runs.begin(), campaign.runs.end(),
                                  [](const CampaignRun& run) { return !run.free_slide && run.dtau > 0; });
  if (!known(FitParameter::mu1)) demand("mu1");
  if (pulses && !known(FitParameter::mu2)) demand("mu2");
  if (pulses && !known(FitParameter::lag) && !known(FitParameter::delay))
    demand("phase_lag_rad (or delay_s)");
}

/// Gravity at the ground lies between 9.76 (Huascaran) and 9.84 (the poles).
void note_gravity(Campaign& campaign) {
  const double g = campaign.platform.gravity;
  if (g < 9.7 || g > 9.9)
    campaign.warnings.push_back(
        fmt::format("gravity_m_s2 = {} is not the earth's, 9.78 to 9.83: mu1 and mu2 come out too large by "
                    "as much as it is "
                    "too small",
                    g));
}

/// Everything but what only holds between sections.
FitDefaults read_sections(StrictTable& top, Campaign& campaign) {
  campaign.title = top.text("title").value_or("");
  if (auto table = top.table("platform")) campaign.platform = read_platform(*table, WithSd::yes);
  if (auto table = top.table("part")) campaign.part = read_part(*table, WithSd::yes);
  if (auto table = top.table("camera"))
    campaign.camera = read_camera(*table, campaign.file.parent_path(), WithSd::yes);
  if (auto table = top.table("scope")) campaign.scope = read_scope(*table);
  if (auto table = top.table("data")) campaign.data = read_data(*table, campaign.file.parent_path());
  FitDefaults defaults;
  if (auto table = top.table("fit")) campaign.fit = read_fit(*table, defaults);
  campaign.start = defaults.start;
  for (StrictTable& table : top.tables("run")) campaign.runs.push_back(read_run(table, campaign, defaults));
  top.finish();
  return defaults;
}

Campaign campaign_in(StrictTable top, const fs::path& file, const Input& input, Runs runs) {
  require_kind(top, TomlKind::campaign, file.string());
  Campaign campaign;
  campaign.file = file;
  campaign.input = input;
  const FitDefaults defaults = read_sections(top, campaign);
  add_table_runs(campaign, defaults.cycles);
  check_sds(campaign, top);
  note_gravity(campaign);
  if (campaign.runs.empty() && runs == Runs::required)
    throw InvalidInput(fmt::format(
        "{}: has no [[run]]; add one for each recording, or have them written by `tribotrack "
        "init DIR --from RECORDINGS`, or name a table of alpha and v, [data] table = \"alpha_v.csv\"",
        file.string()));
  require_all_parameters(campaign, top);
  name_runs(campaign.runs);
  return campaign;
}

}  // namespace

Campaign read_campaign(const fs::path& file, Runs runs) {
  const std::string text = read_text(file);
  return campaign_in(parse_campaign(text, file), file, hashed_input(file, text), runs);
}

Campaign campaign_of(const Json& object, const std::string& name) {
  return campaign_in(StrictTable::of(object, name), name, hashed_input(name, object.dump()), Runs::required);
}

std::vector<AskedKey> keys_asked_of_campaign() {
  constexpr const char* every_section =
      "[platform]\n[part]\ndiameter_mm = "
      "1\n[camera]\n[scope]\n[data]\n[fit]\n[fit.fixed]\n[fit.guess]\n[fit.prior]\n"
      "mu1 = { mean = 1, sd = 1 }\n[[run]]\nvideo = \"v\"\nphi_rad = 0\ndtau_rad = 0\n";
  StrictTable top = StrictTable::parse(every_section, "campaign");
  Campaign campaign;
  read_sections(top, campaign);
  std::vector<AskedKey> asked = top.asked();
  std::erase_if(asked, [](const AskedKey& key) { return key.section.starts_with("fit.prior."); });
  asked.push_back({"fit.prior", "mu1", "{ mean, sd }"});
  return asked;
}

std::vector<fs::path> Campaign::input_files() const {
  std::vector<fs::path> files = {file};
  const auto add = [&](const std::optional<fs::path>& path) {
    if (!path) return;
    for (const fs::path& one : files_of_input(*path)) files.push_back(one);
  };
  add(camera.calibration);
  for (const CampaignRun& run : runs) {
    add(run.video);
    add(run.scope);
    if (run.track) {
      files.push_back(*run.track);
      files.push_back(run.track->string() + ".meta.json");
    }
  }
  files.insert(files.end(), data.tables.begin(), data.tables.end());
  return files;
}

fs::path campaign_file(const fs::path& given) {
  if (given == "-" || given == "/dev/stdin" || given == "/dev/fd/0" || given == "/proc/self/fd/0")
    throw InvalidInput(fmt::format(
        "{}: a campaign is not read from standard input: what it names lies relative to its file; give "
        "a file",
        given.string()));
  if (given.extension() == ".csv" && fs::is_regular_file(given))
    throw InvalidInput(fmt::format(
        "{}: is a table, not a campaign; write a campaign with [platform] and, if it holds alpha and v, "
        "[data] table = \"{}\", or, if it is a track, a [[run]] with track = \"{}\"",
        given.string(), given.filename().string(), given.filename().string()));
  if (!fs::is_directory(given)) return given;
  if (fs::exists(given / "campaign.toml")) return given / "campaign.toml";
  throw InvalidInput(fmt::format(
      "{}: is a folder without a campaign.toml; write one there with `tribotrack init {}` and name its "
      "recordings in it",
      given.string(), given.string()));
}

namespace {

Json in_mm(const std::optional<double>& metres) {
  return metres ? Json(*metres * 1e3) : Json();
}

}  // namespace

Json Campaign::effective_configuration(const CampaignRun& run) const {
  Json json = {
      {"name", run.name},
      {"video", run.video ? Json(run.video->filename().string()) : Json()},
      {"kind", run.free_slide ? "free_slide" : "pulses"},
      {"phi_rad", run.phi},
      {"phi_rad_sd", optional_json(run.phi_sd)},
      {"dtau_rad", run.dtau},
      {"dtau_rad_sd", optional_json(run.dtau_sd)},
      {"start", model::to_string(run.start)},
      {"cycles", run.cycles},
      {"amplitude_mm", in_mm(run.amplitude ? run.amplitude : platform.amplitude)},
      {"amplitude_mm_sd", in_mm(run.amplitude ? run.amplitude_sd : platform.amplitude_sd)},
      {"amplitude_y_mm", in_mm(platform.amplitude_y)},
      {"angular_frequency_rad_s",
       optional_json(run.angular_frequency ? run.angular_frequency : platform.angular_frequency)},
      {"angular_frequency_rad_s_sd",
       optional_json(run.angular_frequency ? run.angular_frequency_sd : platform.angular_frequency_sd)},
      {"phase_shift_rad", optional_json(platform.phase_shift)},
      {"phase_at_zero_rad", optional_json(run.phase_at_zero)},
      {"phase_at_zero_rad_sd", optional_json(run.phase_at_zero_sd)},
      {"start_phase_rad", optional_json(run.start_phase)},
      {"start_phase_rad_sd", optional_json(run.start_phase_sd)},
      {"frames", run.first_frame ? Json::array({*run.first_frame, *run.last_frame}) : Json()},
      {"frame_rate_hz", optional_json(camera.frame_rate_hz)},
      {"frame_rate_hz_sd", optional_json(camera.frame_rate_sd_hz)},
      {"mm_per_px", optional_json(run.mm_per_px ? run.mm_per_px : camera.mm_per_px)},
      {"mm_per_px_sd", run.mm_per_px ? run.mm_per_px_sd.value_or(0) : camera.mm_per_px_sd},
      {"calibration", camera.calibration ? Json(camera.calibration->filename().string()) : Json()},
      {"diameter_mm", optional_json(part.diameter_mm)},
      {"diameter_sd_mm", part.diameter_sd_mm},
      {"height_mm", optional_json(part.height_mm)},
      {"height_mm_sd", optional_json(part.height_sd_mm)},
      {"working_distance_mm", optional_json(camera.working_distance_mm)},
      {"working_distance_mm_sd", optional_json(camera.working_distance_sd_mm)},
      {"xi_axis_rad", camera.xi_axis_rad},
      {"xi_axis_rad_sd", optional_json(camera.xi_axis_sd_rad)},
      {"rehearse", camera.rehearse},
      {"row_time_s", camera.row_time_s},
      {"disc_px", circle_json(run.template_px ? std::nullopt
                              : run.disc_px   ? run.disc_px
                                              : camera.disc_px)},
      {"template_px", rect_json(run.disc_px       ? std::nullopt
                                : run.template_px ? run.template_px
                                                  : camera.template_px)},
      {"marker_px", circle_json(run.marker_px ? run.marker_px : camera.marker_px)},
      {"marker", camera.marker == vision::MarkerChoice::Kind::texture ? "texture"
                 : camera.marker == vision::MarkerChoice::Kind::find  ? "auto"
                 : camera.marker == vision::MarkerChoice::Kind::none  ? "none"
                                                                      : "texture where the ground moves"},
      {"gate_px", circle_json(camera.gate_px)},
      {"scope", run.scope ? Json(run.scope->filename().string()) : Json()}};
  if (run.track) {
    json["track"] = run.track->filename().string();
    json["track_unit"] = run.reading.unit;
    json["track_y"] = run.reading.y == TrackReading::YAxis::up     ? "up"
                      : run.reading.y == TrackReading::YAxis::down ? "down"
                                                                   : "by unit";
    json["track_point"] = run.reading.point;
    json["track_mark"] = run.reading.mark;
  }
  if (!run.pooled_from.empty()) json["pooled_from"] = run.pooled_from;
  return json;
}

Json Campaign::effective_configuration() const {
  Json json;
  if (!title.empty()) json["title"] = title;
  json["platform"] = {{"amplitude_mm", in_mm(platform.amplitude)},
                      {"amplitude_mm_sd", in_mm(platform.amplitude_sd)},
                      {"amplitude_y_mm", in_mm(platform.amplitude_y)},
                      {"amplitude_y_mm_sd", in_mm(platform.amplitude_y_sd)},
                      {"angular_frequency_rad_s", optional_json(platform.angular_frequency)},
                      {"angular_frequency_rad_s_sd", optional_json(platform.angular_frequency_sd)},
                      {"phase_shift_rad", optional_json(platform.phase_shift)},
                      {"phase_shift_rad_sd", optional_json(platform.phase_shift_sd)},
                      {"gravity_m_s2", platform.gravity},
                      {"gravity_m_s2_sd", optional_json(platform.gravity_sd)},
                      {"tilt_x_rad", platform.tilt_x},
                      {"tilt_x_rad_sd", optional_json(platform.tilt_x_sd)},
                      {"tilt_y_rad", platform.tilt_y},
                      {"tilt_y_rad_sd", optional_json(platform.tilt_y_sd)}};
  json["scope"] = {{"sensor_channel", scope.sensor_channel},
                   {"actuator_channel", scope.actuator_channel},
                   {"carrier_hz", scope.carrier_hz},
                   {"sensor_delay_s", scope.sensor_delay_s},
                   {"sensor_delay_sd_s", scope.sensor_delay_sd_s},
                   {"tie", scope.tie},
                   {"trigger_time_s", optional_json(scope.trigger_time_s)},
                   {"tie_sd_s", scope.tie_sd_s}};
  if (!data.tables.empty()) {
    json["data"] = {{"table", Json::array()},
                    {"alpha_sd_rad", optional_json(data.alpha_sd)},
                    {"v_sd_mm_s", in_mm(data.v_sd)}};
    for (const std::filesystem::path& table : data.tables)
      json["data"]["table"].push_back(table.filename().string());
  }
  json["part"] = {{"diameter_mm", optional_json(part.diameter_mm)},
                  {"diameter_sd_mm", part.diameter_sd_mm},
                  {"height_mm", optional_json(part.height_mm)},
                  {"height_mm_sd", optional_json(part.height_sd_mm)}};
  Json fit_json;
  fit_json["parameters"] = Json::array();
  for (const FitParameter parameter : fit.parameters)
    fit_json["parameters"].push_back(fit::to_string(parameter));
  fit_json["data"] = fit.trajectory ? "trajectory" : "summary";
  for (const auto& [name, values] : {std::pair{"fixed", &fit.fixed}, std::pair{"guess", &fit.guess}}) {
    fit_json[name] = Json::object();
    for (const auto& [parameter, value] : *values) fit_json[name][fit::to_string(parameter)] = value;
  }
  fit_json["prior"] = Json::object();
  for (const auto& [parameter, prior] : fit.prior)
    fit_json["prior"][fit::to_string(parameter)] = {{"mean", prior.mean}, {"sd", prior.sd}};
  json["fit"] = fit_json;
  json["runs"] = Json::array();
  for (const CampaignRun& run : runs) {
    Json entry = effective_configuration(run);
    if (run.alpha)
      for (const auto& [name, value] :
           {std::pair{"alpha_rad", *run.alpha}, std::pair{"alpha_sd_rad", *run.alpha_sd},
            std::pair{"v_mm_s", *run.v * 1e3}, std::pair{"v_sd_mm_s", *run.v_sd * 1e3}})
        entry[name] = value;
    json["runs"].push_back(entry);
  }
  return json;
}

}  // namespace tribotrack::apps
