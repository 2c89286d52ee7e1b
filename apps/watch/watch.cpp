#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "apps/files/campaign/campaign.h"
#include "apps/program/errors.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/text/angle.h"
#include "apps/text/input_file.h"
#include "apps/text/output_file.h"
#include "apps/text/strict_toml.h"
#include "apps/watch/arrivals.h"
#include "apps/watch/growing_campaign.h"
#include "vision/frame_source.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

/// Nothing where the path is no recording, or vanishes while it is looked at.
std::optional<FileState> state_of(const fs::path& path) {
  std::error_code error;
  const auto add = [&](FileState& state, const fs::path& file) {
    const std::uintmax_t bytes = fs::file_size(file, error);
    const auto changed = fs::last_write_time(file, error);
    if (error) return;
    state.bytes += bytes;
    ++state.files;
    state.changed = std::max(state.changed, changed);
  };
  FileState state;
  if (fs::is_directory(path, error)) {
    for (fs::directory_iterator at(path, error), end; !error && at != end; at.increment(error))
      if (names_a_picture(at->path())) add(state, at->path());
  } else if (names_a_recording(path)) {
    add(state, path);
  }
  if (error || state.files == 0) return std::nullopt;
  return state;
}

bool opens_whole(const fs::path& path) {
  try {
    vision::open_source(path);
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

}  // namespace

Arrivals::Arrivals(fs::path folder, const Options& options) : folder_(std::move(folder)), options_(options) {
  if (!fs::is_directory(folder_))
    throw InvalidInput("{}: is not a folder; give the one that the camera writes into", folder_.string());
}

void Arrivals::look() {
  std::map<fs::path, Recording> there;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
    const fs::path& path = entry.path();
    if (path.filename().string().starts_with('.')) continue;
    const auto state = state_of(path);
    if (!state) continue;
    const auto known = recordings_.find(path);
    const bool same = known != recordings_.end() && known->second.state == *state;
    there[path] = same ? known->second : Recording{*state, Clock::now()};
  }
  recordings_ = std::move(there);
}

bool Arrivals::is_finished(const fs::path& path, const Recording& recording) const {
  const double unchanged = std::chrono::duration<double>(Clock::now() - recording.since).count();
  return unchanged >= options_.settled_s && (opens_whole(path) || unchanged >= options_.give_up_s);
}

std::vector<fs::path> Arrivals::next(double patience_s) {
  const auto until = Clock::now() + std::chrono::duration<double>(patience_s);
  for (;;) {
    look();
    std::vector<fs::path> finished;
    for (auto& [path, recording] : recordings_)
      if (!recording.handed_out && is_finished(path, recording)) {
        recording.handed_out = true;
        finished.push_back(path);
      }
    const double left = std::chrono::duration<double>(until - Clock::now()).count();
    if (!finished.empty() || left <= 0) return finished;
    std::this_thread::sleep_for(std::chrono::duration<double>(std::min(left, options_.poll_s)));
  }
}

std::vector<fs::path> Arrivals::unfinished() const {
  std::vector<fs::path> paths;
  for (const auto& [path, recording] : recordings_)
    if (!recording.handed_out) paths.push_back(path);
  return paths;
}

namespace {

fit::Goal goal_from(const std::string& text) {
  const auto refuse = [&](const std::string& why) {
    return UsageError("--until: \"{}\" {}; write mu1=1% or phase_lag_rad=0.01", text, why);
  };
  const auto equals = text.find('=');
  if (equals == std::string::npos) throw refuse("is no goal");
  const std::string name = text.substr(0, equals);
  const auto parameter = fit_parameter_named(name);
  if (!parameter) throw refuse("names nothing that can be fitted");
  std::string value = text.substr(equals + 1);
  const bool relative = value.ends_with('%');
  if (relative) value.pop_back();
  const auto number = name.ends_with("_rad") && !relative ? parse_angle(value) : parse_number(value);
  if (!number || !(*number > 0)) throw refuse("needs a width above 0");
  return {*parameter, *number * (relative ? 0.01 : si_per_campaign_unit(*parameter)), relative};
}

/// "1 %", or "0.01" in the campaign's unit.
std::string width_text(const fit::Goal& goal, double half_width) {
  return goal.relative ? fmt::format("{:.2g} %", 100 * half_width)
                       : fmt::format("{:.2g}", half_width / si_per_campaign_unit(goal.parameter));
}

}  // namespace

std::vector<fit::Goal> goals_from(const std::string& text) {
  std::vector<fit::Goal> goals;
  if (text.empty()) return goals;
  for (const std::string& goal : parts_of(text, ',')) goals.push_back(goal_from(goal));
  return goals;
}

std::string progress_of(const std::vector<fit::Goal>& goals, const fit::FitResult& result) {
  std::string text;
  for (const fit::Goal& goal : goals) {
    const double ratio = ratio_to(goal, result);
    text += fmt::format("{}{} to {}: {}{}", text.empty() ? "" : "; ", fit::to_string(goal.parameter),
                        width_text(goal, goal.half_width), ratio <= 1 ? "reached, " : "",
                        std::isfinite(ratio) ? width_text(goal, ratio * goal.half_width) : "not determined");
  }
  return text;
}

void require_fitted(const std::vector<fit::Goal>& goals, const std::vector<fit::FitParameter>& fitted) {
  for (const fit::Goal& goal : goals)
    if (std::ranges::count(fitted, goal.parameter) == 0)
      throw UsageError("--until: {} is not fitted; add it to `parameters` in [fit], or take it out",
                       fit::to_string(goal.parameter));
}

namespace {

bool same_file(const fs::path& a, const fs::path& b) {
  return fs::weakly_canonical(a) == fs::weakly_canonical(b);
}

/// What [camera] says of all runs is not said again of one.
void leave_to_camera(const fs::path& file, DraftTable& run) {
  StrictTable top = StrictTable::read(file);
  auto camera = top.table("camera");
  if (!camera) return;
  if (camera->has("marker_px") || camera->has("marker")) run.erase("marker_px");
  if (camera->has("disc_px")) run.erase("disc_px");
}

}  // namespace

GrowingCampaign::GrowingCampaign(const DraftOptions& draft)
    : folder_(draft.folder), file_(folder_ / "campaign.toml"), draft_(draft) {
  draft_.marks_with_runs = true;
  if (fs::exists(file_)) return;
  if (!draft.diameter_mm)
    throw InvalidInput(
        "{}: there is no campaign yet, and its scale is not known: give --disc-diameter-mm, or write one "
        "with `tribotrack init {}`",
        file_.string(), folder_.string());
  CampaignDraft first;
  take_given(draft, first);
  write_campaign(file_, toml_of(first));
}

bool GrowingCampaign::names(const fs::path& recording) const {
  StrictTable top = StrictTable::read(file_);
  for (StrictTable& run : top.tables("run"))
    if (const auto video = run.text("video"); video && same_file(folder_ / *video, recording)) return true;
  return false;
}

void GrowingCampaign::add(const std::vector<fs::path>& finished, const Context& context) {
  for (const fs::path& recording : finished) {
    if (names(recording) || refused_.contains(recording)) continue;
    CampaignDraft draft;
    try {
      draft_.other_names.clear();
      for (const fs::path& other : recordings_in(folder_))
        draft_.other_names.push_back(other.stem().string());
      Context quiet = context;
      quiet.quiet = true;
      draft = draft_of({recording}, draft_, quiet);
    } catch (const InvalidInput& error) {
      refused_.insert(recording);
      complain(error.what());
      continue;
    }
    DraftTable& run = draft.runs.front();
    if (const auto phi = run.find("phi_rad"), dtau = run.find("dtau_rad");
        run.contains("phi_rad") && (phi->second.missing || dtau->second.missing)) {
      refused_.insert(recording);
      complain(fmt::format(
          "{}: its name tells no phi and dtau (as phi045_dtau060 does): add a [[run]] for it to {}",
          recording.filename().string(), file_.string()));
      continue;
    }
    leave_to_camera(file_, run);
    write_campaign(file_, read_text(file_) + toml_of_run(run));
  }
}

bool GrowingCampaign::has_changed() const {
  std::error_code error;
  return fs::last_write_time(file_, error) != read_at_;
}

Campaign GrowingCampaign::read(const std::vector<fs::path>& unfinished) {
  read_at_ = fs::last_write_time(file_);
  Campaign campaign = campaign_of_part(read_campaign(file_, Runs::may_be_missing), "");
  awaited_.clear();
  std::erase_if(campaign.runs, [&](const CampaignRun& run) {
    if (!run.video) return false;
    const bool there = fs::exists(*run.video) && std::ranges::none_of(unfinished, [&](const fs::path& path) {
                         return same_file(path, *run.video);
                       });
    if (!there) awaited_.push_back(run.name);
    return !there;
  });
  return campaign;
}

}  // namespace tribotrack::apps
