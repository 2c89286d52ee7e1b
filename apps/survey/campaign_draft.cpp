#include "apps/survey/campaign_draft.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "apps/files/campaign/keys.h"
#include "apps/files/traces/scope_file.h"
#include "apps/program/errors.h"
#include "apps/program/progress.h"
#include "apps/survey/survey_text.h"
#include "apps/text/input_file.h"
#include "apps/text/output_file.h"
#include "apps/text/strict_toml.h"
#include "fit/motion.h"
#include "model/parallel.h"
#include "vision/survey.h"
#include "vision/tracker.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

constexpr double kSamePlace = 1.5;  ///< px: marks that lie so near to each other in all recordings are one

constexpr std::int64_t kMostTracked = 1500;  ///< frames that tell how a part moves

/// A recording, and what it shows.
struct Look {
  fs::path path;
  Json listed = Json::object();  ///< keys of its run that a list gives
  NameGuess guess;
  vision::SourceInfo info;
  vision::Survey seen;
  std::optional<fit::ShownMotion> motion;  ///< of the part, where that decides what is drafted
  std::string failure;
};

void look_at(Look& look, const std::optional<double>& fps) {
  try {
    toml_text(look.path.filename().string());
    const auto source = vision::open_source(look.path, {fps});
    look.info = source->info();
    look.seen = vision::survey(*source);
  } catch (const std::exception& error) {
    look.failure = error.what();
  }
}

/// How the part moves, from frame to frame: its places in some frames do not tell circles from a slide. Where
/// the recording does not say how fast it was taken its frames count.
std::optional<fit::ShownMotion> motion_in(const Look& look, const std::optional<double>& fps) {
  if (look.seen.part() == nullptr) return std::nullopt;
  try {
    const auto source = vision::open_source(
        look.path, {look.info.time_base.known() ? fps : std::optional(1.0), "frames count"});
    vision::TrackOptions options;
    options.target.kind = vision::Target::Kind::disc;
    options.target.disc = look.seen.part()->circle;
    options.marker.kind = vision::MarkerChoice::Kind::none;
    options.layers = vision::Layers::off;
    options.first_frame = look.seen.frame;
    options.last_frame =
        std::min(look.seen.frame + kMostTracked, look.info.first_number + look.info.frame_count) - 1;
    fit::TrackTable table;
    for (const vision::TrackPoint& p : vision::track(*source, options).track.points) {
      if (p.status != vision::TrackStatus::ok) continue;
      table.frame.push_back(p.frame);
      table.time.push_back(p.time_s);
      table.position.emplace_back(p.x, p.y);
      table.covariance.push_back(Eigen::Vector2d(p.sigma_x * p.sigma_x, p.sigma_y * p.sigma_y).asDiagonal());
    }
    return fit::shown_motion(table);
  } catch (const std::exception&) {  // what cannot be followed decides nothing
    return std::nullopt;
  }
}

/// The place that all recordings show, where they show one.
std::optional<vision::Circle> common_place(const std::vector<std::optional<vision::Circle>>& places) {
  if (places.empty() || !places.front()) return std::nullopt;
  const vision::Circle& first = *places.front();
  const bool same = std::ranges::all_of(places, [&](const std::optional<vision::Circle>& c) {
    return c && std::hypot(c->x - first.x, c->y - first.y) < kSamePlace + first.radius / 4 &&
           std::abs(c->radius - first.radius) < kSamePlace;
  });
  return same ? places.front() : std::nullopt;
}

DraftValue angle_guess(const std::string& text) {
  return text.empty() ? DraftValue{"\"0deg\"", "not in the recording's name: fill it in", true}
                      : DraftValue{text.ends_with("deg") ? toml_text(text) : text, "guess: by the name"};
}

/// A trace of the same name beside the recording.
std::optional<fs::path> trace_beside(const fs::path& recording) {
  fs::path trace = recording;
  trace.replace_extension(".csv");
  if (fs::is_directory(recording) || !fs::exists(trace)) return std::nullopt;
  try {
    read_scope_file(trace);
  } catch (const InvalidInput&) {
    return std::nullopt;
  }
  return trace;
}

bool any_of_role(const vision::Survey& seen, vision::DiscRole role) {
  return std::ranges::count(seen.discs, role, &vision::SurveyedDisc::role) > 0;
}

/// Where others could be taken for the part. Where several move, only the user knows which it is.
void place_part(const vision::Survey& seen, DraftTable& run) {
  if (seen.part() == nullptr) return;
  const std::string circle = circle_text(seen.part()->circle);
  if (any_of_role(seen, vision::DiscRole::like_part))
    run["disc_px"] = {circle, "several discs move; `tribotrack probe VIDEO --picture F.png` numbers them",
                      true};
  else if (any_of_role(seen, vision::DiscRole::resting))
    run["disc_px"] = {circle, "guess: of several discs, that which moves farthest"};
}

/// A name that tells no phase, and nothing but the part moves, by more than a platform could move it.
bool may_slide(const Look& look) {
  const vision::Survey& seen = look.seen;
  return look.guess.phi_text.empty() && look.guess.dtau_text.empty() && seen.part() != nullptr &&
         !seen.platform_moves() && seen.lamps.empty() && seen.part()->moved_px > seen.part()->circle.radius;
}

bool repeats(const Look& look) {
  return look.motion && look.motion->oscillation;
}

/// Does a list say that a run is driven, whatever its recording seems to show?
bool is_driven(const Json& listed) {
  return listed.contains("phi_rad") || listed.contains("dtau_rad") || listed.value("kind", "") == "pulses";
}

DraftTable run_of(const Look& look, const fs::path& folder) {
  const NameGuess& guess = look.guess;
  DraftTable run;
  run["video"] = {toml_text(relative_to(look.path, folder)), ""};
  if (guess.free_slide || (look.motion && look.motion->braking)) {
    run["kind"] = {"\"free_slide\"",
                   guess.free_slide ? "guess: by the name" : "guess: the part is seen to slide"};
    if (look.motion && look.motion->kind == fit::MotionKind::incline)
      run["slope_rad"] = {"\"20deg\"", "it gains speed, as down an incline: fill it in", true};
  } else {
    run["phi_rad"] = angle_guess(guess.phi_text);
    run["dtau_rad"] = angle_guess(guess.dtau_text);
    if (repeats(look) && guess.phi_text.empty())
      run["phi_rad"].why = "the part circles or swings, a drive's: fill it in";
  }
  place_part(look.seen, run);
  if (const auto trace = trace_beside(look.path))
    run["scope"] = {toml_text(relative_to(*trace, folder)), "guess: by the name"};
  return run;
}

/// Where parts circle and no mark shows how the platform moves.
void place_drive(CampaignDraft& draft, const std::vector<Look>& looks) {
  const auto look =
      std::ranges::find_if(looks, [](const Look& one) { return repeats(one) && !one.seen.platform_moves(); });
  if (look == looks.end()) return;
  const double w = look->motion->oscillation->angular_frequency.value;
  const bool timed = look->info.time_base.known();
  if (timed)
    draft.tables["platform"]["angular_frequency_rad_s"] = {
        fmt::format("{:.4g}", w), "what the part shows: fill in what the drive is set to", true};
  draft.missing.push_back(
      fmt::format("angular_frequency_rad_s and amplitude_mm in [platform]: no mark shows them; the part in "
                  "{} goes round{}",
                  look->path.stem().string(), timed ? fmt::format(" at about {:.4g} rad/s", w) : ""));
}

/// Marks and lamps: under [camera] where all recordings agree, else with each run.
void place_marks(CampaignDraft& draft, const std::vector<Look>& looks, bool with_runs) {
  const auto place = [&](const char* key, const char* why, bool of_runs, auto of) {
    std::vector<std::optional<vision::Circle>> places, driven;
    for (std::size_t k = 0; k < looks.size(); ++k) {
      places.push_back(of(looks[k].seen));
      if (!looks[k].guess.free_slide) driven.push_back(places.back());
    }
    if (const auto common = common_place(driven); common && !with_runs) {
      draft.tables["camera"][key] = {circle_text(*common), why};
      return;
    }
    if (!of_runs) return;
    for (std::size_t k = 0; k < looks.size(); ++k)
      if (places[k] && !looks[k].guess.free_slide) draft.runs[k][key] = {circle_text(*places[k]), why};
  };
  place("marker_px", "guess: a disc that moves and stays near its place", true,
        [](const vision::Survey& seen) -> std::optional<vision::Circle> {
          return seen.mark() ? std::optional(seen.mark()->circle) : std::nullopt;
        });
  place("gate_px", "guess: a place that switches between two levels", false,
        [](const vision::Survey& seen) -> std::optional<vision::Circle> {
          return seen.lamps.empty() ? std::nullopt : std::optional(seen.lamps.front().circle);
        });
}

void place_frame_rate(CampaignDraft& draft, const std::vector<Look>& looks) {
  DraftTable& camera = draft.tables["camera"];
  if (camera.contains("frame_rate_hz")) return;  // given
  const auto unknown =
      std::ranges::find_if(looks, [](const Look& look) { return !look.info.time_base.known(); });
  if (unknown == looks.end()) return;
  const auto& rate = unknown->guess.frame_rate_hz;
  if (rate &&
      std::ranges::all_of(looks, [&](const Look& look) { return look.guess.frame_rate_hz == rate; })) {
    camera["frame_rate_hz"] = {fmt::format("{}", *rate), "guess: by the names"};
    camera["frame_rate_reason"] = {"\"the recordings' names\"", ""};
    return;
  }
  camera["frame_rate_hz"] = {"1000.0", "fill it in: the recordings do not say how fast they were taken",
                             true};
  draft.missing.push_back(
      fmt::format("frame_rate_hz in [camera]: {}", unknown->info.time_base.why_unknown()));
}

std::string line_of(const std::string& key, const DraftValue& value) {
  const std::string line = fmt::format("{}{} = {}", value.missing ? "# " : "", key, value.value);
  return value.why.empty() ? line + "\n" : fmt::format("{:<44}  # {}\n", line, toml_comment(value.why));
}

/// All that a section may hold: the draft's values, the others as comments with an example.
std::string lines_of(const CampaignSection& section, const DraftTable& values) {
  std::string text;
  for (const KeyFacts& key : section.keys) {
    const auto found = values.find(key.name);
    DraftValue value =
        found != values.end() ? found->second : DraftValue{key.example, key.meaning, /*missing=*/true};
    if (value.why.empty()) value.why = key.meaning;
    text += line_of(key.name, value);
  }
  return text;
}

/// [platform], [part], [camera] and [fit] may stand empty; the others are comments where nothing is filled
/// in.
std::string section_text(const CampaignSection& section, const DraftTable& values) {
  const bool always = section.name == "platform" || section.name == "part" || section.name == "camera" ||
                      section.name == "fit";
  const bool live = always || std::ranges::any_of(values, [](const auto& v) { return !v.second.missing; });
  const std::string heading = fmt::format("{}[{}]", live ? "" : "# ", section.name);
  return (section.name.empty() ? "" : fmt::format("\n{:<44}  # {}\n", heading, section.remark)) +
         lines_of(section, values);
}

std::string runs_text(const CampaignDraft& draft) {
  const CampaignSection& section = campaign_sections().back();
  std::string text = fmt::format("\n# [[run]]: {}.\n", section.remark);
  for (const DraftTable& run : draft.runs) text += toml_of_run(run);
  text += draft.runs.empty() ? "\n# [[run]]\n" : "\n# All that a run may hold:\n# [[run]]\n";
  return text + lines_of(section, {});
}

bool is_series_frame(const fs::path& path) {
  if (names_a_picture(path)) return true;
  const std::string suffix = path.extension().string();
  if (suffix != ".tif" && suffix != ".tiff") return false;
  try {
    return vision::open_source(path)->info().frame_count == 1;
  } catch (const vision::InputError&) {
    return false;  // what is wrong with it is said where it is looked into
  }
}

bool holds_pictures(const fs::path& folder) {
  return std::ranges::any_of(fs::directory_iterator(folder), [](const fs::directory_entry& entry) {
    return entry.is_regular_file() && is_series_frame(entry.path());
  });
}

}  // namespace

std::string relative_to(const fs::path& recording, const fs::path& folder) {
  const fs::path relative =
      fs::absolute(recording).lexically_normal().lexically_relative(fs::absolute(folder).lexically_normal());
  return relative.empty() ? fs::absolute(recording).string() : relative.string();
}

std::vector<fs::path> recordings_in(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw InvalidInput("{}: is not a folder", folder.string());
  std::vector<fs::path> recordings;
  bool pictures = false;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const fs::path& path = entry.path();
    if (path.filename().string().starts_with('.')) continue;
    if (entry.is_directory()) {
      if (holds_pictures(path)) recordings.push_back(path);
    } else if (names_a_recording(path)) {
      if (is_series_frame(path))
        pictures = true;
      else
        recordings.push_back(path);
    }
  }
  // Pictures without anything else: the folder itself is the recording.
  if (recordings.empty() && pictures) recordings.push_back(folder);
  std::ranges::sort(recordings);
  return recordings;
}

CampaignDraft draft_of(const std::vector<fs::path>& recordings, const DraftOptions& options,
                       const Context& context) {
  CampaignDraft draft;
  take_given(options, draft);
  std::vector<Look> looks(recordings.size());
  for (std::size_t k = 0; k < looks.size(); ++k) {
    looks[k].path = recordings[k];
    if (!options.listed.empty()) looks[k].listed = options.listed[k];
  }
  Progress progress("looking into recordings", context);
  std::atomic<std::int64_t> done = 0;
  parallel_for(looks.size(), threads_to_use(context), [&](std::size_t k) {
    look_at(looks[k], options.fps);
    progress.update(++done, static_cast<std::int64_t>(looks.size()));
  });
  for (const Look& look : looks)
    if (!look.failure.empty()) draft.left_out.push_back(look.failure);
  std::erase_if(looks, [](const Look& look) { return !look.failure.empty(); });
  if (looks.empty())
    throw InvalidInput(draft.left_out.empty()
                           ? "there are no recordings to look into"
                           : fmt::format("no recording can be read; the first: {}", draft.left_out.front()));
  std::vector<std::string> names;
  for (const Look& look : looks) names.push_back(look.path.stem().string());
  names.insert(names.end(), options.other_names.begin(), options.other_names.end());
  const std::vector<NameGuess> guesses = guesses_from(names);
  parallel_for(looks.size(), threads_to_use(context), [&](std::size_t k) {
    Look& look = looks[k];
    look.guess = guesses[k];
    bool& slide = look.guess.free_slide;
    slide =
        look.listed.contains("kind") ? look.listed["kind"] == "free_slide" : slide && !is_driven(look.listed);
    if (slide || (!is_driven(look.listed) && may_slide(look))) look.motion = motion_in(look, options.fps);
    if (repeats(look)) slide = false;  // whatever its name says
  });
  for (const Look& look : looks) {
    DraftTable& run = draft.runs.emplace_back(run_of(look, options.folder));
    for (const auto& [key, value] : look.listed.items()) run[key] = {toml_value(value), ""};
    if (run.contains("phi_rad") && (run["phi_rad"].missing || run["dtau_rad"].missing))
      draft.missing.push_back(fmt::format("phi_rad and dtau_rad of {}: {} not tell them",
                                          look.path.stem().string(),
                                          options.listed.empty() ? "its name does" : "list and name do"));
  }
  place_drive(draft, looks);
  place_marks(draft, looks, options.marks_with_runs);
  place_frame_rate(draft, looks);
  if (!options.diameter_mm)
    draft.missing.insert(draft.missing.begin(),
                         "diameter_mm in [part] (or mm_per_px in [camera]): the scale");
  return draft;
}

void take_given(const DraftOptions& options, CampaignDraft& draft) {
  const auto require_positive = [](const char* flag, const std::optional<double>& value) {
    if (value && !(*value > 0)) throw UsageError("{} must be greater than 0, not {:g}", flag, *value);
  };
  require_positive("--disc-diameter-mm", options.diameter_mm);
  require_positive("--fps", options.fps);
  if (options.chamfer_mm && !options.diameter_mm) throw UsageError("--chamfer-mm needs --disc-diameter-mm");
  if (options.chamfer_mm && !can_be_chamfer(*options.chamfer_mm, *options.diameter_mm))
    throw UsageError("--chamfer-mm {:g} must be less than the radius and not negative", *options.chamfer_mm);
  const auto take = [&](const char* section, const char* key, const std::optional<double>& value) {
    if (value) draft.tables[section][key] = {fmt::format("{}", *value), "given"};
  };
  take("part", "diameter_mm", options.diameter_mm);
  take("part", "chamfer_mm", options.chamfer_mm);
  take("camera", "frame_rate_hz", options.fps);
}

std::string toml_of_run(const DraftTable& run) {
  std::string text = "\n[[run]]\n";
  for (const KeyFacts& key : run_keys())
    if (const auto found = run.find(key.name); found != run.end()) text += line_of(key.name, found->second);
  for (const auto& [name, value] : run)  // frequency_hz, and other second names of keys
    if (std::ranges::count(run_keys(), name, &KeyFacts::name) == 0) text += line_of(name, value);
  return text;
}

std::string toml_of(const CampaignDraft& draft) {
  std::string text =
      "#:schema campaign.schema.json\n"
      "# (an editor that knows TOML checks and completes by it: tribotrack help campaign --json "
      ">campaign.schema.json)\n"
      "# A tribotrack campaign:  tribotrack run campaign.toml\n"
      "# Units stand in the key names. Angles are radians: a number, or a text such as \"pi/3\" or "
      "\"60deg\".\n"
      "# KEY_sd is the standard deviation of KEY: the intervals count it; without one, that of its last "
      "digit or of the trade.\n"
      "# What is given and also seen in the recordings is compared. All keys: tribotrack help campaign\n";
  for (const std::string& missing : draft.missing)
    text += fmt::format("# TO FILL IN: {}\n", toml_comment(missing));
  for (const std::string& left_out : draft.left_out)
    text += fmt::format("# LEFT OUT: {}\n", toml_comment(left_out));
  text += "\n";
  for (const CampaignSection& section : campaign_sections()) {
    if (section.repeated) continue;
    const auto found = draft.tables.find(section.name);
    text += section_text(section, found == draft.tables.end() ? DraftTable{} : found->second);
  }
  return text + runs_text(draft);
}

void write_campaign(const fs::path& file, const std::string& text) {
  StrictTable::parse(text, file.string());
  write_file(file, text);
}

}  // namespace tribotrack::apps
