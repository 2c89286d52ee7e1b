#include "apps/open/session.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "apps/files/campaign/data_section.h"
#include "apps/files/run_folder.h"
#include "apps/open/campaign_text.h"
#include "apps/page/assets/embedded_assets.h"
#include "apps/survey/campaign_draft.h"
#include "apps/text/angle.h"
#include "apps/text/input_file.h"
#include "apps/text/output_file.h"
#include "apps/text/strict_toml.h"
#include "vision/overlay.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

constexpr const char* kText = "text/plain; charset=utf-8";

Answer answer_of(const Json& json) {
  return {json.dump(-1, ' ', false, Json::error_handler_t::replace)};
}

Answer refusal(int status, const std::string& why) {
  return {why, kText, status};
}

Json parsed(const std::string& text) {
  Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) throw InvalidInput("the request is no JSON object");
  return json;
}

/// Of canonical paths.
bool is_in(const fs::path& folder, const fs::path& path) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end();
}

/// Of the last change of a file; null where there is none.
Json time_of(const fs::path& path) {
  std::error_code error;
  const auto time = fs::last_write_time(path, error);
  return error ? Json() : Json(time.time_since_epoch().count());
}

std::string text_in(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_string() ? found->get<std::string>() : "";
}

}  // namespace

OpenSession::OpenSession(const fs::path& given, const Context& context) : context_(context) {
  const bool is_folder = fs::is_directory(given);
  if (!is_folder && !fs::is_regular_file(given))
    throw InvalidInput("{}: there is no such folder or campaign; give the folder of the recordings",
                       given.string());
  if (!is_folder) StrictTable::read(given);
  folder_ = fs::canonical(is_folder ? given : fs::absolute(given).parent_path());
  name_ = is_folder ? "campaign.toml" : given.filename().string();
  if (!fs::exists(file())) return;
  campaign_text();
  try {
    for (const CampaignRun& run : read_campaign(file(), Runs::may_be_missing).runs)
      if (run.video) named_.insert(fs::weakly_canonical(*run.video));
  } catch (const std::exception&) {  // the page says what is wrong with it
  }
}

bool OpenSession::is_inside(const fs::path& path) const {
  return is_in(folder_, fs::weakly_canonical(path));
}

fs::path OpenSession::recording(const std::string& video) {
  const fs::path path = (folder_ / video).lexically_normal();
  const fs::path real = fs::weakly_canonical(path);
  const std::lock_guard lock(mutex_);
  if (named_.contains(real)) return path;
  if (!is_inside(path) || !may_be_recording(path) ||
      !std::ranges::all_of(files_of_input(path), [&](const fs::path& file) { return is_inside(file); }))
    throw InvalidInput("{}: is no recording in {}", video, folder_.string());
  named_.insert(real);
  return path;
}

std::string OpenSession::campaign_text() const {
  if (!is_inside(file()))
    throw InvalidInput("{}: is a link out of {}; give the campaign that it leads to", name_,
                       folder_.string());
  return read_text(file());
}

std::string OpenSession::revision() const {
  return fs::exists(file()) ? hash_of_text(campaign_text()) : "none";
}

Json OpenSession::state() {
  Json state = {{"folder", folder_.string()}, {"campaign", name_}, {"output", output_of(name_).string()}};
  const std::lock_guard lock(mutex_);
  state["revision"] = revision();
  Json recordings = Json::array();
  for (const fs::path& path : recordings_in(folder_))
    if (is_inside(path)) recordings.push_back(relative_to(path, folder_));
  state["recordings"] = recordings;
  const RunFolder results{folder_ / output_of(name_)};
  state["report"] = time_of(results.report());
  if (fs::exists(results.fit())) try {
      const Json fit = read_json(results.fit());
      for (const char* key : {"verdict", "verdict_reasons", "parameters"})
        if (fit.contains(key)) state["fit"][key] = fit[key];
    } catch (const InvalidInput&) {  // the report says it
    }
  if (state["revision"] == "none") return state;
  const std::string text = campaign_text();
  state["text"] = text;
  try {
    const Json values = values_of_campaign(text, name_);
    Json runs = Json::array();  // as far as they can be told of a campaign that is not filled in yet
    for (const Json& run : values.value("run", Json::array())) {
      const std::string video = text_in(run, "video");
      runs.push_back(Json{{"name", run.value("name", fs::path(video).stem().string())}, {"video", video}});
    }
    state["values"] = values;
    state["runs"] = runs;
    const Campaign campaign = read_campaign(file(), Runs::may_be_missing);
    state["conditions"] = conditions_of(campaign);
    state["runs"] = Json::array();
    for (const CampaignRun& run : campaign.runs)
      state["runs"].push_back({{"name", run.name},
                               {"video", run.video ? Json(relative_to(*run.video, folder_)) : Json()},
                               {"free_slide", run.free_slide},
                               {"scope", run.scope.has_value()}});
  } catch (const std::exception& error) {
    state["problem"] = error.what();
  }
  return state;
}

void OpenSession::take_list(const std::string& list, std::string& text) const {
  const RunList rows = read_run_list("pasted", list);
  const Json values = values_of_campaign(text, name_);
  std::vector<fs::path> videos;
  if (values.contains("run"))
    for (const Json& run : values["run"]) videos.push_back(folder_ / text_in(run, "video"));
  std::vector<CampaignEdit> edits;
  std::vector<std::string> absent;
  for (const RunList::Line& line : rows.lines) {
    const std::string name = text_in(line.keys, "video");
    const auto found = recording_named(name, videos, folder_);
    if (!found) {
      absent.push_back(fmt::format("{} ({})", line.place, name));
      continue;
    }
    const auto run = static_cast<std::size_t>(std::ranges::find(videos, *found) - videos.begin());
    for (const auto& [key, value] : line.keys.items())
      if (key != "video") edits.push_back({"run", run, key, toml_value(value)});
  }
  if (!absent.empty())
    throw InvalidInput("{}: no run of the campaign has this recording; nothing was taken over",
                       fmt::join(absent, ", "));
  text = with_edits(std::move(text), edits, name_);
}

/// {"text": all of it} or {"edits": [{section, run, key, value}], "add": [recording], "list": pasted table}.
std::string OpenSession::with_changes(const Json& wanted, std::string text) const {
  if (wanted.contains("text")) return text_in(wanted, "text");
  std::vector<CampaignEdit> edits;
  for (const Json& edit : wanted.value("edits", Json::array()))
    edits.push_back({text_in(edit, "section"), edit.value("run", std::size_t{0}), text_in(edit, "key"),
                     text_in(edit, "value")});
  text = with_edits(std::move(text), edits, name_);
  for (const Json& recording : wanted.value("add", Json::array()))
    text = with_recording(std::move(text), recording.get<std::string>());
  if (wanted.contains("list")) take_list(text_in(wanted, "list"), text);
  return text;
}

Answer OpenSession::changed(const Json& wanted) {
  {
    const std::lock_guard lock(mutex_);
    const std::string now = revision();
    if (text_in(wanted, "revision") != now)
      return refusal(409, name_ +
                              " has changed since this page read it, in another tab or an editor: nothing "
                              "was written. The page now shows it as it is.");
    if (now == "none") return refusal(400, "there is no campaign yet: draft one first");
    write_campaign(file(), with_changes(wanted, campaign_text()));
  }
  return answer_of(state());
}

Answer OpenSession::probe(const std::string& video) {
  const fs::path path = recording(video);
  std::error_code error;
  const auto time = fs::last_write_time(path, error);
  {
    const std::lock_guard lock(mutex_);
    if (const auto known = probed_.find(path); known != probed_.end() && known->second.first == time)
      return {known->second.second};
  }
  const Printed printed = run_itself({"probe", video, "--json"}, folder_);
  if (printed.exit_code != 0) return refusal(400, printed.err);
  const std::lock_guard lock(mutex_);
  probed_[path] = {time, printed.out};
  return {printed.out};
}

std::shared_ptr<OpenSession::Opened> OpenSession::opened(const fs::path& path) {
  constexpr std::size_t kOpen = 4;
  const std::lock_guard lock(mutex_);
  auto found = std::ranges::find_if(opened_, [&](const auto& one) { return one->path == path; });
  if (found == opened_.end()) {
    opened_.push_front(std::make_shared<Opened>());
    opened_.front()->path = path;
    if (opened_.size() > kOpen) opened_.pop_back();
    found = opened_.begin();
  }
  return *found;
}

Answer OpenSession::frame(const Query& query) {
  const auto one = opened(recording(query("recording")));
  const std::lock_guard lock(one->mutex);
  if (!one->source) one->source = vision::open_source(one->path);
  const vision::SourceInfo& info = one->source->info();
  const auto whole = [&](const char* name, std::int64_t otherwise) {
    const std::string text = query(name);
    return text.empty() ? otherwise : static_cast<std::int64_t>(std::atoll(text.c_str()));
  };
  const auto index =
      std::clamp<std::int64_t>(whole("index", 0), 0, std::max<std::int64_t>(0, info.frame_count - 1));
  const int side = static_cast<int>(std::clamp<std::int64_t>(whole("side", 1280), 32, 4096));
  const auto jpeg = vision::first_frame_jpeg(*one->source, info.first_number + index, side);
  return {std::string(jpeg.begin(), jpeg.end()), "image/jpeg"};
}

/// A file of the results. A report is shown as what it is, a page of its own that may not ask for anything.
Answer OpenSession::output(const std::string& name) const {
  const fs::path root = folder_ / output_of(name_), path = root / name;
  const fs::path real = fs::weakly_canonical(path);
  if (!is_inside(root) || !is_in(fs::weakly_canonical(root), real))
    return refusal(403, "403: lies outside the results");
  if (!fs::is_regular_file(real)) return refusal(404, name + " is not there yet");
  const std::string suffix = path.extension().string();
  if (suffix == ".html")
    return {read_text(real), "text/html; charset=utf-8", 200,
            "sandbox allow-scripts allow-downloads allow-modals; frame-ancestors 'self'"};
  return {read_text(real), suffix == ".json" ? "application/json" : kText};
}

/// `track` for a look at one run: its first second, with what the campaign says.
Words OpenSession::first_second(const std::string& name) {
  const Campaign campaign = campaign_of_part(read_campaign(file(), Runs::may_be_missing), "");
  const auto run = std::ranges::find(campaign.runs, name, &CampaignRun::name);
  if (run == campaign.runs.end() || !run->video) throw InvalidInput(name + ": is no run with a recording");
  const std::string video = relative_to(*run->video, folder_);
  const auto one = opened(recording(video));
  const std::lock_guard lock(one->mutex);
  if (!one->source) one->source = vision::open_source(one->path);
  const vision::SourceInfo& info = one->source->info();
  const double rate = campaign.camera.frame_rate_hz.value_or(info.time_base.rate_hz.value_or(250));
  const std::int64_t first = run->first_frame.value_or(info.first_number),
                     last = std::min<std::int64_t>(first + std::max<std::int64_t>(10, std::llround(rate)),
                                                   info.first_number + info.frame_count - 1);
  const RunFolder look{fs::path(output_of(name_)) / "first_second"};
  create_folder(folder_ / look.tracks());
  const std::string frames = fmt::format("{}:{}", first, last), csv = look.track(name).string();
  return {"track", "--campaign", name_, "--run", name, "--frames", frames, "-o", csv};
}

/// The command lines that the page may start: their words are the campaign's, and numbers and names of the
/// page.
Words OpenSession::arguments_of(const Json& wanted) {
  const std::string what = text_in(wanted, "what"), run = text_in(wanted, "run");
  if (what == "init") {
    if (name_ != "campaign.toml") throw InvalidInput("there is a campaign already");
    Words words = {"init", ".", "--from", "."};
    for (const auto& [key, flag] :
         {std::pair("diameter_mm", "--disc-diameter-mm"), {"chamfer_mm", "--chamfer-mm"}, {"fps", "--fps"}})
      if (const std::string number = text_in(wanted, key); !number.empty())
        words.insert(words.end(), {flag, number});
    return words;
  }
  if (what == "run") return {"run", name_};
  if (what == "plan") return {"run", name_, "--dry-run"};
  if (what == "watch") {
    if (name_ != "campaign.toml") throw InvalidInput("only campaign.toml can gain runs as they are filmed");
    Words words = {"watch", ".", "-o", output_of(name_).string()};
    if (const std::string until = text_in(wanted, "until"); !until.empty())
      words.insert(words.end(), {"--until", until});
    return words;
  }
  if (what == "first_second") return first_second(run);
  if (what == "track") {
    const RunFolder results{output_of(name_)};
    create_folder(folder_ / results.tracks());
    if (run.find('/') != std::string::npos) throw InvalidInput("no such run");
    return {"track", "--campaign", name_, "--run", run, "-o", results.track(run).string()};
  }
  throw InvalidInput("no such command");
}

Answer OpenSession::started(const Json& wanted) {
  if (!job_.start(arguments_of(wanted), folder_))
    return refusal(409, "another command is at work: stop it, or wait");
  return answer_of(job_.state(-1));
}

Answer OpenSession::answer(const Asked& asked) {
  const EmbeddedAssets& assets = embedded_assets();
  const std::string& path = asked.path;
  if (asked.post) {
    if (path == "campaign") return changed(parsed(asked.body));
    if (path == "start") return started(parsed(asked.body));
    if (path == "stop") job_.stop();
    return path == "stop" ? answer_of(Json::object()) : refusal(404, "404");
  }
  if (path.empty()) return {std::string(assets.open_html), "text/html; charset=utf-8"};
  if (path == "open.js")
    return {std::string(assets.frames_js).append(assets.open_js), "text/javascript; charset=utf-8"};
  if (path == "open.css")
    return {std::string(assets.page_css).append(assets.open_css), "text/css; charset=utf-8"};
  if (path == "state") return answer_of(state());
  if (path == "probe") return probe(asked.parameter("recording"));
  if (path == "frame") return frame(asked.parameter);
  if (path == "forecast") {
    Campaign campaign = read_campaign(file());
    // As they are imagined: what a campaign gives is held against what the camera sees.
    PlatformSection& platform = campaign.platform;
    if (const auto mm = parse_number(asked.parameter("amplitude_mm"))) platform.amplitude = *mm * 1e-3;
    if (const auto hz = parse_number(asked.parameter("frequency_hz")))
      platform.angular_frequency = 2 * M_PI * *hz;
    return answer_of(forecast_of(campaign, context_));
  }
  if (path == "job") {
    Json job = job_.state(std::atoll(asked.parameter("seen").c_str()));
    job["revision"] = revision();
    job["report"] = time_of(RunFolder{folder_ / output_of(name_)}.report());
    return answer_of(job);
  }
  if (path.starts_with("out/")) return output(path.substr(4));
  return refusal(404, "404");
}

}  // namespace tribotrack::apps
