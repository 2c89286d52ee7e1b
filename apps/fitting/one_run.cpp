#include "apps/fitting/one_run.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <new>
#include <vector>

#include "apps/campaign/conditions.h"
#include "apps/files/run_folder.h"
#include "apps/program/errors.h"
#include "apps/recording/job.h"
#include "apps/text/output_file.h"
#include "vision/frame_sink.h"
#include "vision/overlay.h"

namespace tribotrack::apps {

const CampaignRun& run_named(const Campaign& campaign, const std::string& name) {
  constexpr std::size_t kFew = 12;
  const auto found = std::ranges::find(campaign.runs, name, &CampaignRun::name);
  if (found == campaign.runs.end()) {
    std::vector<std::string> names;
    for (const CampaignRun& run : campaign.runs)
      if (names.size() < kFew) names.push_back(run.name);
    throw InvalidInput(fmt::format("{}: has no run \"{}\"; its runs are {}{}", campaign.file.string(), name,
                                   fmt::join(names, ", "), campaign.runs.size() > kFew ? ", ..." : ""));
  }
  if (!found->has_track())
    throw InvalidInput(
        fmt::format("{}: run \"{}\" was measured elsewhere: there is nothing to track", found->place, name));
  return *found;
}

PreparedJob prepare_run(const Campaign& campaign, const CampaignRun& run) {
  if (!may_be_recording(*run.video))
    throw InvalidInput(fmt::format("{}: run \"{}\": there is no recording {}; check `video`", run.place,
                                   run.name, run.video->string()));
  require_trace(run);
  return prepare(job_for(campaign, run));
}

void write_first_frame(const std::filesystem::path& picture, const TrackedRecording& recording) {
  const auto jpeg = vision::first_frame_jpeg(*recording.source, recording.result.track.first_seen());
  write_file(picture, {reinterpret_cast<const char*>(jpeg.data()), jpeg.size()}, Content::pictures);
}

void leaving_word(const CampaignRun& run, const std::filesystem::path& track,
                  const std::function<void()>& work) {
  const std::filesystem::path word = RunFolder::failure_beside(track);
  try {
    work();
  } catch (const OutputError&) {
    throw;
  } catch (const vision::OutputError&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    write_file(word, failure_of(run, error) + "\n");
    throw;
  }
  std::error_code none;
  std::filesystem::remove(word, none);
}

}  // namespace tribotrack::apps
