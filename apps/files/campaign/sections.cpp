#include "apps/files/campaign/sections.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>

#include "apps/files/campaign/keys.h"
#include "apps/program/errors.h"
#include "apps/program/streams.h"
#include "fit/conditions.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;
using fit::FitParameter;

namespace {

/// An incline beyond 45 degrees is none that a part rests on.
constexpr double kSteepest = std::numbers::pi / 4;

void check_sds(const StrictTable& table, const CampaignRun& run) {
  if (run.free_slide)
    for (const char* key : {"phi_rad_sd", "dtau_rad_sd", "amplitude_mm_sd", "angular_frequency_rad_s_sd",
                            "phase_at_zero_rad_sd", "start_phase_rad_sd"})
      if (table.has(key)) table.fail(key, "belongs to a driven run: a free slide's platform rests");
  if (!run.has_track())
    for (const char* key : {"phase_at_zero_rad_sd", "mm_per_px_sd"})
      if (table.has(key)) table.fail(key, "belongs to a run with a video or a track");
  if (run.start_phase_sd && run.phase_at_zero)
    table.fail("start_phase_rad_sd", "is not needed: phase_at_zero_rad gives the phase at the start");
}

/// A free slide's plane.
void check_slope(const StrictTable& table, CampaignRun& run) {
  if (!run.slope) return;
  if (!run.free_slide)
    table.fail("slope_rad", "belongs to a run of kind = \"free_slide\": its part slides on a plane at rest");
  if (!(std::abs(*run.slope) <= kSteepest))
    table.fail("slope_rad",
               fmt::format("must lie within pi/4, not {0}: degrees? write \"{0}deg\"", *run.slope));
  if (*run.slope == 0) run.slope.reset();
}

/// Which of several parts this run shows is said once.
void check_places(const StrictTable& table, const CampaignRun& run) {
  if (!table.has("parts")) return;
  if (!run.part.empty())
    table.fail("parts", "and `part` both say which part this run is about; give one of them");
  for (const char* key : {"disc_px", "template_px", "track", "alpha_rad"})
    if (table.has(key)) table.fail("parts", fmt::format("says where each part lies, and so does `{}`", key));
}

/// What belongs to tracking does not belong to a finished track.
void check_track(const StrictTable& table, const CampaignRun& run) {
  if (run.track && run.video)
    table.fail("track", "and `video` are two sources of one motion; a run has one of them");
  if (run.track)
    for (const char* key : {"disc_px", "template_px", "marker_px"})
      if (table.has(key)) table.fail(key, "is for tracking a `video`; this run's `track` is finished");
}

/// A run has one source of its motion, and all that the fit needs to know of it.
void check_source(const StrictTable& table, const CampaignRun& run, bool with_sds) {
  const bool any_summary = run.alpha || run.alpha_sd || run.v || run.v_sd;
  const bool whole_summary = run.alpha && run.v && (!with_sds || (run.alpha_sd && run.v_sd));
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
  if (!run.free_slide && (!table.has("phi_rad") || !table.has("dtau_rad")))
    throw InvalidInput(
        fmt::format("{}: a run needs `phi_rad` and `dtau_rad` (or kind = \"free_slide\")", run.place));
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

void read_frames(StrictTable& table, CampaignRun& run, const fs::path&) {
  const auto frames = table.integers("frames", table.count("frames") == 3 ? 3 : 2);
  if (!frames) return;
  if ((*frames)[0] > (*frames)[1] || (frames->size() == 3 && frames->back() < 1))
    table.fail("frames", "must be [first, last], both included, or [first, last, step]");
  run.first_frame = (*frames)[0];
  run.last_frame = (*frames)[1];
  if (frames->size() == 3) run.frame_step = (*frames)[2];
}

Json written_frames(const CampaignRun& run) {
  if (!run.first_frame) return {};
  Json frames = Json::array({*run.first_frame, *run.last_frame});
  if (run.frame_step > 1) frames.push_back(run.frame_step);
  return frames;
}

void read_scope_files(StrictTable& table, CampaignRun& run, const fs::path& folder) {
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

Json written_scope_files(const CampaignRun& run) {
  if (!run.scope) return {};
  const std::string file = run.scope->filename().string();
  return run.second_scope ? Json::array({file, run.second_scope->filename().string()}) : Json(file);
}

void read_parts(StrictTable& table, CampaignRun& run, const fs::path&) {
  auto places = table.table("parts");
  if (!places) return;
  for (const std::string& name : places->keys()) run.parts[name] = read_place(*places, name.c_str());
  places->finish();
}

CampaignRun read_run(StrictTable& table, const Campaign& campaign, bool with_sds) {
  CampaignRun run;
  run.place = table.place();
  run.reading = campaign.data.tracks;
  run.start = campaign.fit.start;
  run.cycles = campaign.fit.cycles;
  read_keys(table, run_keys(), run, campaign.file.parent_path());
  if (!(run.dtau >= 0 && run.dtau <= 2 * std::numbers::pi))
    table.fail("dtau_rad",
               fmt::format("must lie between 0 and 2pi, not {0}: degrees? write \"{0}deg\"", run.dtau));
  check_track(table, run);
  check_sds(table, run);
  check_slope(table, run);
  check_places(table, run);
  table.finish();
  complete_reading(campaign.camera, run);
  check_source(table, run, with_sds);
  return run;
}

void require_scale(const Campaign& campaign, const CampaignRun& run) {
  const bool scale_given =
      run.mm_per_px || campaign.camera.mm_per_px || campaign.camera.calibration || campaign.camera.tag_mm;
  const vision::Target& target = is_given(run.target) ? run.target : campaign.camera.target;
  if (run.video && !scale_given && target.kind == vision::Target::Kind::rectangle)
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
  const auto controls = [](unsigned char c) { return c < 0x20 || c == 0x7F; };
  std::set<std::string> taken;
  for (const CampaignRun& run : runs)
    if (!run.name.empty() && !taken.insert(run.name).second)
      throw InvalidInput(fmt::format("{}: the name \"{}\" is taken by an earlier run", run.place, run.name));
  for (std::size_t k = 0; k < runs.size(); ++k) {
    CampaignRun& run = runs[k];
    if (run.name.find('/') != std::string::npos || run.name == "." || run.name == "..")
      throw InvalidInput(fmt::format("{}: the name \"{}\" cannot be a folder's name", run.place, run.name));
    if (std::ranges::any_of(run.name, controls))
      throw InvalidInput(
          fmt::format("{}: the name \"{}\" holds a control character; results bear it: take it out",
                      run.place, printable(run.name)));
    if (!run.name.empty()) continue;
    std::string base = run.video   ? run.video->stem().string()
                       : run.track ? run.track->stem().string()
                                   : fmt::format("run{:02}", k + 1);
    std::ranges::replace_if(base, controls, '_');
    run.name = base;
    for (int n = 2; !taken.insert(run.name).second; ++n) run.name = fmt::format("{}_{}", base, n);
  }
}

const std::vector<FitParameter>& fit_parameters() {
  static const std::vector<FitParameter> parameters = {
      FitParameter::mu1,   FitParameter::mu2,       FitParameter::lag,
      FitParameter::delay, FitParameter::amplitude, FitParameter::angular_frequency,
      FitParameter::scale, FitParameter::tilt_x,    FitParameter::tilt_y};
  return parameters;
}

Kind kind_of(FitParameter parameter) {
  switch (parameter) {
    case FitParameter::mu1:
    case FitParameter::mu2:
      return Kind::not_negative;
    case FitParameter::amplitude:
    case FitParameter::angular_frequency:
    case FitParameter::scale:
      return Kind::above_zero;
    default:
      return std::string_view(fit::to_string(parameter)).ends_with("_rad") ? Kind::angle : Kind::number;
  }
}

std::optional<FitParameter> fit_parameter_named(const std::string& name) {
  for (const FitParameter parameter : fit_parameters())
    if (name == fit::to_string(parameter)) return parameter;
  return std::nullopt;
}

double si_per_campaign_unit(FitParameter parameter) {
  return parameter == FitParameter::amplitude ? 1e-3 : 1;
}

namespace {

FitParameter require_fit_parameter(const StrictTable& table, std::string_view key, const std::string& name) {
  if (const auto parameter = fit_parameter_named(name)) return *parameter;
  std::vector<std::string> names;
  for (const FitParameter known : fit_parameters()) names.emplace_back(fit::to_string(known));
  const std::string near = nearest_word(name, names);
  table.fail(key, fmt::format("names \"{}\", which cannot be fitted; {}", name,
                              near.empty() ? fmt::format("these can: {}", fmt::join(names, ", "))
                                           : fmt::format("did you mean \"{}\"?", near)));
}

/// A table of values by parameter name.
std::map<FitParameter, double> read_values(StrictTable table, const std::vector<FitParameter>& allowed) {
  std::map<FitParameter, double> values;
  for (const FitParameter parameter : allowed) {
    if (const auto value = read_number(table, kind_of(parameter), fit::to_string(parameter)))
      values[parameter] = *value;
  }
  table.finish();
  return values;
}

void read_priors(StrictTable prior, FitSection& fit) {
  for (const std::string& name : prior.keys()) {
    const FitParameter parameter = require_fit_parameter(prior, name, name);
    if (std::ranges::count(fit.parameters, parameter) == 0)
      prior.fail(name,
                 "is not among `parameters`, and a prior of what is not fitted has no effect: add it "
                 "there, or give the value with its sd where it belongs");
    auto entry = prior.table(name);
    const auto mean = read_number(*entry, kind_of(parameter), "mean");
    const auto sd = entry->positive("sd");
    entry->finish();
    if (!mean || !sd) prior.fail(name, "needs a mean and an sd: { mean = 0.1, sd = 0.01 }");
    fit.prior[parameter] = {*mean, *sd};
  }
  prior.finish();
}

}  // namespace

void read_parameters(StrictTable& table, FitSection& fit, const fs::path&) {
  const auto names = table.texts("parameters");
  if (!names) return;
  fit.parameters_given = true;
  fit.parameters.clear();
  for (const auto& name : *names) {
    const FitParameter parameter = require_fit_parameter(table, "parameters", name);
    if (std::ranges::count(fit.parameters, parameter) > 0)
      table.fail("parameters", fmt::format("names \"{}\" twice", name));
    fit.parameters.push_back(parameter);
  }
  if (fit.parameters.empty())
    table.fail("parameters", "is empty; name what is to be fitted, such as [\"mu1\"]");
}

Json written_parameters(const FitSection& fit) {
  Json names = Json::array();
  for (const FitParameter parameter : fit.parameters) names.push_back(fit::to_string(parameter));
  return names;
}

bool Exact::holds(std::string_view key) const {
  return all || std::ranges::count(keys, key) > 0;
}

void read_exact(StrictTable& table, FitSection& fit, const fs::path&) {
  if (!table.is_list("exact")) {
    fit.exact.all = table.boolean("exact").value_or(false);
    return;
  }
  std::map<std::string, std::string> known;  // by every name of it the key of what may have an sd
  for (const CampaignSection& section : campaign_sections())
    for (const KeyFacts& key : section.keys) {
      if (std::ranges::count(section.keys, key.name + "_sd", &KeyFacts::name) == 0) continue;
      known[key.name] = key.name;
      for (const OtherName& other : other_names(key.name)) known[other.name] = key.name;
    }
  const std::string law = fit::to_string(fit::Source::friction_law);
  known[law] = law;
  std::vector<std::string> names;
  for (const auto& [name, key] : known) names.push_back(name);
  const std::vector<std::string> given = table.texts("exact").value();
  for (const std::string& name : given) {
    const std::string near = nearest_word(name, names);
    if (!known.contains(name))
      table.fail("exact", fmt::format("names \"{}\", which is no quantity with an sd; {}", name,
                                      near.empty() ? fmt::format("these are: {}", fmt::join(names, ", "))
                                                   : fmt::format("did you mean \"{}\"?", near)));
    fit.exact.keys.push_back(known.at(name));
  }
}

Json written_exact(const FitSection& fit) {
  return fit.exact.all ? Json(true) : Json(fit.exact.keys);
}

double default_sd(const Exact& exact, std::string_view key, double value, const Digits& digits) {
  struct Trade {
    std::string_view key;
    double absolute, relative;
  };
  constexpr double degree = std::numbers::pi / 180;
  constexpr double kCaliper = 0.02, kLevel = 2e-3;
  constexpr Trade kTrade[] = {{"amplitude_mm", 0, 0.005},
                              {"amplitude_y_mm", 0, 0.005},
                              {"amplitude_ratio", 0, 0.01},
                              {"angular_frequency_rad_s", 0, 1e-4},
                              {"phase_shift_rad", degree, 0},
                              {"tilt_x_rad", kLevel, 0},
                              {"tilt_y_rad", kLevel, 0},
                              {"slope_rad", 0.1 * degree, 0},
                              {"diameter_mm", kCaliper, 0},
                              {"tag_mm", kCaliper, 0},
                              {"mm_per_px", 0, 0},
                              {"phi_rad", 0, 0},
                              {"dtau_rad", 0, 0},
                              {"start_phase_rad", 0, 0},
                              {"phase_at_zero_rad", 0, 0}};
  const auto* trade = std::ranges::find(kTrade, key, &Trade::key);
  if (trade == std::end(kTrade) || exact.holds(key)) return 0;
  const auto digit = digits.find(key);
  // No instrument of the trade errs by more than a twentieth: a value that small is a slip.
  const double absolute =
      trade->absolute == kCaliper ? std::min(kCaliper, 0.05 * std::abs(value)) : trade->absolute;
  return std::max({digit == digits.end() ? 0 : digit->second, absolute, trade->relative * std::abs(value)});
}

FitSection read_fit(StrictTable& table) {
  if (table.is_table("start")) table.fail("start", kGuessHint);
  FitSection fit;
  read_keys(table, fit_keys(), fit);
  if (auto guesses = table.table("guess")) fit.guess = read_values(*guesses, fit_parameters());
  if (auto fixed = table.table("fixed"))
    fit.fixed =
        read_values(*fixed, {FitParameter::mu1, FitParameter::mu2, FitParameter::lag, FitParameter::delay});
  for (const auto& [parameter, value] : fit.fixed)
    if (std::ranges::count(fit.parameters, parameter) > 0)
      table.fail("fixed",
                 fmt::format("holds {}, which `parameters` lists as fitted; take it out of one of them",
                             fit::to_string(parameter)));
  if (auto prior = table.table("prior")) read_priors(*prior, fit);
  table.finish();
  return fit;
}

ScopeSection read_scope(StrictTable& table) {
  ScopeSection scope;
  read_keys(table, scope_keys(), scope);
  if (scope.sensor_channel != 0 && scope.sensor_channel == scope.actuator_channel) {
    const bool of_sensor = table.has("sensor_channel");
    table.fail(of_sensor ? "sensor_channel" : "actuator_channel",
               fmt::format("is {}, and so is `{}`: one channel holds either the sensor's pulses or the "
                           "actuator's bursts",
                           scope.sensor_channel, of_sensor ? "actuator_channel" : "sensor_channel"));
  }
  table.finish();
  return scope;
}

}  // namespace tribotrack::apps
