#include "apps/campaign/repeated.h"

#include <fmt/format.h>

#include "apps/program/errors.h"

namespace tribotrack::apps {
namespace {

bool same_recording(const AnalysedRun& a, const AnalysedRun& b) {
  if (!a.track || !b.track || a.run->free_slide != b.run->free_slide) return false;
  const fit::TrackTable &one = a.track->table, &other = b.track->table;
  return !one.position.empty() && one.frame == other.frame && one.time == other.time &&
         one.position == other.position;
}

}  // namespace

void set_aside_repeated(std::vector<AnalysedRun>& runs) {
  for (std::size_t i = 0; i < runs.size(); ++i)
    for (std::size_t k = 0; k < i && runs[i].takes_part(); ++k) {
      const CampaignRun &here = *runs[i].run, &before = *runs[k].run;
      if (!runs[k].takes_part() || !same_recording(runs[i], runs[k])) continue;
      if (here.phi != before.phi || here.dtau != before.dtau)
        throw InvalidInput(
            fmt::format("{}: run \"{}\" is the recording of run \"{}\" once more, with another phi_rad or "
                        "dtau_rad: take one "
                        "of them out, or name the right recording",
                        here.place, here.name, before.name));
      runs[i].repeats = before.name;
    }
}

std::vector<std::string> repeated_text(const std::vector<AnalysedRun>& runs) {
  std::vector<std::string> sentences;
  for (const AnalysedRun& run : runs)
    if (!run.repeats.empty())
      sentences.push_back(
          fmt::format("run \"{}\" is the recording of run \"{}\" once more: it is counted once",
                      run.run->name, run.repeats));
  return sentences;
}

}  // namespace tribotrack::apps
