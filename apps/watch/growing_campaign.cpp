#include "apps/watch/growing_campaign.h"

#include <fmt/format.h>

#include <algorithm>

#include "apps/program/errors.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/text/output_file.h"
#include "apps/text/strict_toml.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

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

GrowingCampaign::GrowingCampaign(const fs::path& folder, const DraftOptions& draft)
    : folder_(folder), file_(folder / "campaign.toml"), draft_(draft) {
  draft_.folder = folder;
  draft_.marks_with_runs = true;
  if (fs::exists(file_)) return;
  if (!draft.diameter_mm)
    throw InvalidInput(
        fmt::format("{}: there is no campaign yet, and its scale is not known: give --disc-diameter-mm, or "
                    "write one with `tribotrack init {}`",
                    file_.string(), folder.string()));
  CampaignDraft first;
  first.tables["part"]["diameter_mm"] = {fmt::format("{}", *draft.diameter_mm), "given"};
  if (draft.fps) first.tables["camera"]["frame_rate_hz"] = {fmt::format("{}", *draft.fps), "given"};
  write_file(file_, toml_of(first));
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
    std::string text = read_text(file_);
    if (!text.empty() && text.back() != '\n') text += '\n';
    write_file(file_, text + toml_of_run(run));
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
