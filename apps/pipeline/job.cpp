#include "apps/pipeline/job.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <new>
#include <system_error>
#include <vector>

#include "apps/campaign/conditions.h"
#include "apps/files/run_folder.h"
#include "apps/program/errors.h"
#include "apps/recording/recording.h"
#include "apps/text/output_file.h"
#include "apps/text/strict_toml.h"
#include "vision/frame_sink.h"

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

Recording checked_recording(const Campaign& campaign, const CampaignRun& run) {
  if (!may_be_recording(*run.video))
    throw InvalidInput(fmt::format("{}: run \"{}\": there is no recording {}; check `video`", run.place,
                                   run.name, run.video->string()));
  require_trace(run);
  return checked(recording_of(campaign, run));
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

/// What a job of its own has made of a run. Throws what it left word of where there is no track.
Track track_of_job(const std::filesystem::path& csv) {
  const std::filesystem::path word = RunFolder::failure_beside(csv);
  std::string sentence;
  if (!std::filesystem::exists(csv) && std::filesystem::is_regular_file(word)) sentence = read_text(word);
  while (sentence.ends_with('\n')) sentence.pop_back();
  if (!sentence.empty()) throw InvalidInput(sentence);
  return read_track_file(csv);
}

}  // namespace tribotrack::apps
