#include "apps/files/campaign/sections.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>

#include "apps/program/errors.h"

namespace tribotrack::apps {

namespace {

/// An incline beyond 45 degrees is none that a part rests on.
constexpr double kSteepest = std::numbers::pi / 4;

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

/// A trace, or two of an oscilloscope that writes a file for each channel.
void read_scope_files(StrictTable& table, const Campaign& campaign, CampaignRun& run) {
  const auto folder = campaign.file.parent_path();
  if (!table.is_list("scope")) {
    if (const auto scope = table.text("scope")) run.scope = folder / *scope;
    return;
  }
  const auto files = table.texts("scope");
  if (files->empty() || files->size() > 2)
    table.fail("scope", fmt::format("must name one file, or two of one channel each, not {}", files->size()));
  run.scope = folder / files->front();
  if (files->size() == 2) run.second_scope = folder / files->back();
}

/// A free slide's plane.
void read_slope(StrictTable& table, CampaignRun& run) {
  run.slope = table.angle("slope_rad");
  run.slope_sd = read_sd(table, "slope_rad");
  if (!run.slope) return;
  if (!run.free_slide)
    table.fail("slope_rad", "belongs to a run of kind = \"free_slide\": its part slides on a plane at rest");
  if (!(std::abs(*run.slope) <= kSteepest))
    table.fail("slope_rad",
               fmt::format("must lie within pi/4, not {0}: degrees? write \"{0}deg\"", *run.slope));
  if (*run.slope == 0) run.slope.reset();
}

/// Which of several parts this run shows, and where each lies at first.
void read_parts(StrictTable& table, CampaignRun& run) {
  run.part = table.text("part").value_or("");
  auto places = table.table("parts");
  if (!places) return;
  if (!run.part.empty())
    table.fail("parts", "and `part` both say which part this run is about; give one of them");
  for (const char* key : {"disc_px", "template_px", "track", "alpha_rad"})
    if (table.has(key)) table.fail("parts", fmt::format("says where each part lies, and so does `{}`", key));
  for (const std::string& name : places->keys()) run.parts[name] = read_place(*places, name.c_str());
  places->finish();
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

}  // namespace

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
  read_slope(table, run);
  read_parts(table, run);
  run.disc_px = read_circle(table, "disc_px");
  run.template_px = read_template(table);
  run.marker_px = read_circle(table, "marker_px");
  read_scope_files(table, campaign, run);
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
  return run;
}

void require_scale(const Campaign& campaign, const CampaignRun& run) {
  const bool scale_given =
      run.mm_per_px || campaign.camera.mm_per_px || campaign.camera.calibration || campaign.camera.tag_mm;
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

using fit::FitParameter;

namespace {

const std::vector<FitParameter> kFitParameters = {
    FitParameter::mu1,   FitParameter::mu2,       FitParameter::lag,
    FitParameter::delay, FitParameter::amplitude, FitParameter::angular_frequency,
    FitParameter::scale, FitParameter::tilt_x,    FitParameter::tilt_y};

std::vector<std::string> fit_parameter_names() {
  std::vector<std::string> names;
  for (const FitParameter parameter : kFitParameters) names.emplace_back(fit::to_string(parameter));
  return names;
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

}  // namespace

std::optional<FitParameter> fit_parameter_named(const std::string& name) {
  for (const FitParameter parameter : kFitParameters)
    if (name == fit::to_string(parameter)) return parameter;
  return std::nullopt;
}

double si_per_campaign_unit(FitParameter parameter) {
  return parameter == FitParameter::amplitude ? 1e-3 : 1;
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
    section.parameters_given = true;
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

}  // namespace tribotrack::apps
