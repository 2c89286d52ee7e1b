#include "apps/files/campaign/campaign.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "apps/files/campaign/keys.h"
#include "apps/files/run_folder.h"
#include "apps/files/scenario_file.h"
#include "apps/program/errors.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;
using fit::FitParameter;

namespace {

/// TOML calls `start = "rest"` in [fit] beside a table [fit.start] one key defined twice.
StrictTable parse_campaign(const std::string& text, const fs::path& file) {
  try {
    return StrictTable::parse(text, file.string());
  } catch (const InvalidInput& error) {
    const std::string message = error.what();
    if (message.find("start` is given twice") == std::string::npos) throw;
    throw InvalidInput("{}: `start` in [fit] {}", message.substr(0, message.find(": ")), kGuessHint);
  }
}

/// sds that have nothing to act on, or that say the same as a prior.
void check_sds(const Campaign& campaign, StrictTable& top) {
  const CameraSection& camera = campaign.camera;
  if (campaign.part.height_sd_mm && !camera.working_distance_mm && !camera.calibration)
    top.table("part")->fail(
        "height_mm_sd",
        "needs working_distance_mm (or a calibration) in [camera]: without it the height is not used");
  if (camera.working_distance_sd_mm && (!campaign.part.height_mm || camera.calibration))
    top.table("camera")->fail("working_distance_mm_sd",
                              camera.calibration
                                  ? "is not used: the calibration holds its own distance"
                                  : "needs height_mm in [part]: without it the distance is not used");
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

/// A quantity that is exact has no sd.
void check_exact(const Campaign& campaign, StrictTable& top) {
  for (const char* section : {"platform", "part", "camera"}) {
    if (!top.is_table(section)) continue;
    for (const std::string& key : campaign.fit.exact.keys)
      if (auto table = top.table(section); table->has(key + "_sd"))
        table->fail(key + "_sd", fmt::format("and exact = [\"{}\"] in [fit] contradict each other", key));
  }
}

/// What the runs' motion depends on and is neither fitted nor given. A lag that is left out would count as 0.
void require_all_parameters(const Campaign& campaign, StrictTable& top) {
  const auto known = [&](FitParameter parameter) {
    return campaign.fit.fixed.contains(parameter) ||
           std::count(campaign.fit.parameters.begin(), campaign.fit.parameters.end(), parameter) > 0;
  };
  const auto demand = [&](const char* names) {
    top.table("fit")->fail(
        "parameters",
        fmt::format("does not name {0}, and [fit.fixed] holds no value of {0}: fit it, or give it there",
                    names));
  };
  const bool pulses = std::any_of(campaign.runs.begin(), campaign.runs.end(),
                                  [](const CampaignRun& run) { return !run.free_slide && run.dtau > 0; });
  if (!known(FitParameter::mu1)) demand("mu1");
  if (pulses && !known(FitParameter::mu2)) demand("mu2");
  if (pulses && !known(FitParameter::lag) && !known(FitParameter::delay))
    demand("phase_lag_rad (or delay_s)");
}

/// Runs that are kept out are driven ones of this campaign, and not all of them.
void check_hold_out(const Campaign& campaign, StrictTable& top) {
  const std::vector<std::string>& names = campaign.fit.hold_out;
  if (names.empty()) return;
  const auto fail = [&](const std::string& what) { top.table("fit")->fail("hold_out", what); };
  for (const std::string& name : names) {
    const auto run = std::ranges::find(campaign.runs, name, &CampaignRun::name);
    if (run == campaign.runs.end())
      fail(fmt::format("names \"{}\", which is no run of this campaign", name));
    else if (run->free_slide)
      fail(fmt::format("names \"{}\", a free slide; only driven runs are predicted", name));
  }
  if (std::ranges::all_of(campaign.runs,
                          [&](const CampaignRun& run) { return std::ranges::count(names, run.name) > 0; }))
    fail("names every run; leave some to fit to");
}

/// Gravity at the ground lies between 9.76 (Huascaran) and 9.84 (the poles).
void note_gravity(Campaign& campaign) {
  const double g = campaign.platform.gravity;
  if (g < 9.7 || g > 9.9)
    campaign.warnings.push_back(
        fmt::format("gravity_m_s2 = {} is not the earth's, 9.78 to 9.83: mu1 and mu2 come out too large by "
                    "as much as it is too small",
                    g));
}

std::vector<std::string> names_of(const std::vector<PartSection>& parts) {
  std::vector<std::string> names;
  for (const PartSection& part : parts) names.push_back(part.name);
  return names;
}

/// Does the run show this part?
bool shows(const CampaignRun& run, const PartSection& part) {
  if (!run.parts.empty()) return run.parts.contains(part.name);
  return run.part.empty() || run.part == part.name;
}

/// The run as that of one part: where it lies at first is said by the run, else by the part.
CampaignRun run_of_part(CampaignRun run, const PartSection& part) {
  if (const auto place = run.parts.find(part.name); place != run.parts.end())
    run.target = place->second;
  else if (!is_given(run.target))
    run.target = part.target;
  run.parts.clear();
  run.part = part.name;
  return run;
}

void require_known(const Campaign& campaign, const CampaignRun& run, const std::string& name) {
  const std::vector<std::string> names = names_of(campaign.parts);
  if (std::ranges::find(names, name) != names.end()) return;
  throw InvalidInput("{}: there is no [[part]] named \"{}\"; there are: {}", run.place, name,
                     fmt::join(names, ", "));
}

/// [part], or [[part]] for several. One [[part]] is a [part].
void read_part_or_parts(StrictTable& top, Campaign& campaign) {
  if (!top.is_list("part")) {
    if (auto table = top.table("part")) campaign.part = read_part(*table);
    return;
  }
  std::set<std::string> taken;
  for (StrictTable& table : top.tables("part")) {
    campaign.parts.push_back(read_part(table));
    const std::string& name = campaign.parts.back().name;
    if (name.empty()) table.fail("name", "is missing: each of several [[part]] has a `name`");
    if (name.find('/') != std::string::npos || name == "." || name == "..")
      table.fail("name", fmt::format("\"{}\" cannot be a folder's name", name));
    if (!taken.insert(name).second)
      table.fail("name", fmt::format("\"{}\" is taken by an earlier part", name));
  }
  if (campaign.parts.size() != 1) return;
  campaign.part = campaign.parts.front();
  campaign.parts.clear();
}

/// Refuses runs whose part is not known, or where it is not known where a part lies.
void check_parts(const Campaign& campaign) {
  if (campaign.parts.empty()) {
    for (const CampaignRun& run : campaign.runs)
      if (!run.parts.empty() || (!run.part.empty() && run.part != campaign.part.name))
        throw InvalidInput("{}: names a part, but the campaign has no [[part]] of that name", run.place);
    return;
  }
  if (!campaign.data.tables.empty())
    throw InvalidInput(
        "{}: a table of alpha and v is one part's, and this campaign has {}: give it a campaign of its own",
        campaign.file.string(), campaign.parts.size());
  for (const CampaignRun& run : campaign.runs) {
    if (!run.part.empty()) require_known(campaign, run, run.part);
    for (const auto& [name, place] : run.parts) require_known(campaign, run, name);
    if (!run.part.empty() || !run.parts.empty()) continue;
    const bool placed = std::ranges::all_of(campaign.parts, is_given, &PartSection::target);
    if (!run.video || !placed || is_given(run.target))
      throw InvalidInput(
          "{}: run \"{}\": does not say where each part lies; give parts = {{ {} = [X, Y, R] }} ([X, Y, "
          "WIDTH, HEIGHT] for a part of any shape), or part = \"{}\" where it shows one; `tribotrack probe "
          "VIDEO --picture FIRST.png` shows what lies where",
          run.place, run.name, fmt::join(names_of(campaign.parts), " = [X, Y, R], "),
          campaign.parts.front().name);
  }
}

/// Everything but what only holds between sections.
void read_sections(StrictTable& top, Campaign& campaign) {
  const fs::path folder = campaign.file.parent_path();
  read_keys(top, top_keys(), campaign);
  if (auto table = top.table("platform")) campaign.platform = read_platform(*table);
  read_part_or_parts(top, campaign);
  if (auto table = top.table("camera")) campaign.camera = read_camera(*table, folder);
  if (auto table = top.table("scope")) campaign.scope = read_scope(*table);
  if (auto table = top.table("data")) campaign.data = read_data(*table, folder);
  if (auto table = top.table("fit")) campaign.fit = read_fit(*table);
  for (StrictTable& table : top.tables("run")) campaign.runs.push_back(read_run(table, campaign));
  top.finish();
}

Campaign campaign_in(StrictTable top, const fs::path& file, const Input& input, Runs runs) {
  require_kind(top, TomlKind::campaign, file.string());
  Campaign campaign;
  campaign.file = file;
  campaign.input = input;
  top.say_where_keys_belong(sections_with);
  read_sections(top, campaign);
  add_listed_runs(campaign);
  add_table_runs(campaign);
  if (!campaign.fit.parameters_given && !campaign.runs.empty() &&
      std::ranges::all_of(campaign.runs, &CampaignRun::free_slide))
    campaign.fit.parameters = {FitParameter::mu1};
  check_sds(campaign, top);
  check_exact(campaign, top);
  note_gravity(campaign);
  if (campaign.runs.empty() && runs == Runs::required)
    throw InvalidInput(
        "{}: has no [[run]]; add one for each recording, or have them written by `tribotrack init DIR --from "
        "RECORDINGS`, or name a table of alpha and v, [data] table = \"alpha_v.csv\"",
        file.string());
  require_all_parameters(campaign, top);
  name_runs(campaign.runs);
  check_hold_out(campaign, top);
  check_parts(campaign);
  for (const Campaign& part : campaigns_by_part(campaign))
    for (const CampaignRun& run : part.runs) require_scale(part, run);
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

std::vector<fs::path> Campaign::input_files(const std::vector<CampaignRun>& of) const {
  std::vector<fs::path> files = {file};
  const auto add = [&](const std::optional<fs::path>& path) {
    if (!path) return;
    for (const fs::path& one : files_of_input(*path)) files.push_back(one);
  };
  add(camera.calibration);
  for (const CampaignRun& run : of) {
    add(run.video);
    add(run.scope);
    add(run.second_scope);
    if (run.track) {
      files.push_back(*run.track);
      files.push_back(run.track->string() + ".meta.json");
    }
  }
  files.insert(files.end(), data.tables.begin(), data.tables.end());
  if (data.runs) files.push_back(*data.runs);
  return files;
}

fs::path campaign_file(const fs::path& given) {
  if (given == "-" || given == "/dev/stdin" || given == "/dev/fd/0" || given == "/proc/self/fd/0")
    throw InvalidInput(
        "{}: a campaign is not read from standard input: what it names lies relative to its file; give a "
        "file",
        given.string());
  if (given.extension() == ".csv" && fs::is_regular_file(given))
    throw InvalidInput(
        "{}: is a table, not a campaign; write a campaign with [platform] and, if it holds alpha and v, "
        "[data] table = \"{}\", or, if it is a track, a [[run]] with track = \"{}\"",
        given.string(), given.filename().string(), given.filename().string());
  if (!fs::is_directory(given)) return given;
  if (fs::exists(given / "campaign.toml")) return given / "campaign.toml";
  throw InvalidInput(
      "{}: is a folder without a campaign.toml; write one there with `tribotrack init {}` and name its "
      "recordings in it",
      given.string(), given.string());
}

fs::path output_of(const fs::path& campaign) {
  return campaign.parent_path() / (campaign.stem().string() + "-out");
}

std::vector<Campaign> campaigns_by_part(const Campaign& campaign) {
  if (campaign.parts.empty()) return {campaign};
  std::vector<Campaign> campaigns;
  for (const PartSection& part : campaign.parts) {
    Campaign one = campaign;
    one.parts.clear();
    one.part = part;
    if (one.title.empty()) one.title = one.file.stem().string();
    one.title += ": " + part.name;
    one.runs.clear();
    for (const CampaignRun& run : campaign.runs)
      if (shows(run, part)) one.runs.push_back(run_of_part(run, part));
    if (one.runs.empty())
      throw InvalidInput("{}: no [[run]] shows the part \"{}\"; take it out, or add one",
                         campaign.file.string(), part.name);
    campaigns.push_back(std::move(one));
  }
  return campaigns;
}

Campaign campaign_of_part(const Campaign& campaign, const std::string& part) {
  const std::vector<std::string> names = names_of(campaign.parts);
  if (part.empty() && names.empty()) return campaign;
  const auto found = std::ranges::find(names, part);
  if (found == names.end())
    throw InvalidInput(names.empty()
                           ? fmt::format("{}: has no [[part]] named \"{}\"", campaign.file.string(), part)
                           : fmt::format("{}: has several parts, each with a fit of its own: {}; say which "
                                         "one is meant (`run` and `fit` take --part NAME)",
                                         campaign.file.string(), fmt::join(names, ", ")));
  return campaigns_by_part(campaign)[static_cast<std::size_t>(found - names.begin())];
}

}  // namespace tribotrack::apps
