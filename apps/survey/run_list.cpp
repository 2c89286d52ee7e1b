// A campaign drafted from a folder of recordings and a list of its runs.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "apps/program/errors.h"
#include "apps/survey/campaign_draft.h"
#include "apps/text/angle.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

std::optional<fs::path> recording_named(const std::string& name, const std::vector<fs::path>& recordings,
                                        const fs::path& folder) {
  const fs::path whole = (folder / name).lexically_normal();
  for (const fs::path& recording : recordings)
    if (recording.lexically_normal() == whole) return recording;
  const std::string last = lower(name.substr(name.find_last_of("/\\") + 1));  // of a path of any system
  for (const bool with_suffix : {true, false}) {
    std::optional<fs::path> found;
    for (const fs::path& recording : recordings) {
      const fs::path own = with_suffix ? recording.filename() : recording.stem();
      if (lower(own.string()) != last) continue;
      if (found) return std::nullopt;
      found = recording;
    }
    if (found) return found;
  }
  return std::nullopt;
}

namespace {

/// A run without a recording to look into: a track, or what was measured elsewhere.
DraftTable run_without_video(const RunList::Line& line) {
  DraftTable run;
  for (const auto& [key, value] : line.keys.items()) run[key] = {toml_value(value), ""};
  return run;
}

/// Files that a line names lie in the folder of the recordings, and are named from that of the campaign.
void name_files(RunList::Line& line, const fs::path& from, const fs::path& folder,
                std::vector<std::string>& absent) {
  for (const char* key : {"track", "scope"}) {
    if (!line.keys.contains(key)) continue;
    const fs::path file = from / line.keys[key].get<std::string>();
    if (!fs::exists(file)) absent.push_back(fmt::format("{} ({})", line.place, file.filename().string()));
    line.keys[key] = relative_to(file, folder);
  }
}

std::string names_of(const std::vector<fs::path>& paths) {
  std::vector<std::string> names;
  for (const fs::path& path : paths) names.push_back(path.filename().string());
  return fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace

CampaignDraft draft_of(const RunList& list, const fs::path& from, DraftOptions options,
                       const Context& context) {
  const std::vector<fs::path> recordings = recordings_in(from);
  std::vector<fs::path> used;
  std::vector<DraftTable> others;
  std::vector<std::string> absent;
  for (RunList::Line line : list.lines) {
    name_files(line, from, options.folder, absent);
    if (!line.keys.contains("video")) {
      if (!line.keys.contains("track") && !line.keys.contains("alpha_rad"))
        throw InvalidInput("{}: names no recording; fill in the column video", line.place);
      others.push_back(run_without_video(line));
      continue;
    }
    const std::string name = line.keys["video"];
    if (const auto recording = recording_named(name, recordings, from)) {
      line.keys.erase("video");
      used.push_back(*recording);
      options.listed.push_back(std::move(line.keys));
    } else {
      absent.push_back(fmt::format("{} ({})", line.place, name));
    }
  }
  std::vector<fs::path> unlisted;
  std::ranges::copy_if(recordings, std::back_inserter(unlisted),
                       [&](const fs::path& one) { return std::ranges::count(used, one) == 0; });
  if (!absent.empty())
    throw InvalidInput("{}: names what is not in {}, or could be several there{}", fmt::join(absent, ", "),
                       from.string(),
                       unlisted.empty() ? "; correct the names" : "; no line names " + names_of(unlisted));
  CampaignDraft draft = used.empty() ? CampaignDraft{} : draft_of(used, options, context);
  std::ranges::move(others, std::back_inserter(draft.runs));
  if (!unlisted.empty())
    draft.left_out.push_back(fmt::format("no line of the list names {}", names_of(unlisted)));
  return draft;
}

}  // namespace tribotrack::apps
