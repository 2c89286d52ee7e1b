#include "apps/campaign/suspects.h"

#include <fmt/format.h>

#include <algorithm>

namespace tribotrack::apps {

namespace {

/// The farthest that the part gets from where it was first seen.
double way_of(const fit::TrackTable& track) {
  double way = 0;
  for (const auto& position : track.position) way = std::max(way, (position - track.position.front()).norm());
  return way;
}

std::vector<std::string> no_slides(const fit::Problem& problem, const fit::FitResult& result) {
  constexpr double kShare = 0.1;
  std::vector<std::string> sentences;
  for (const fit::RunResult& fitted : result.runs) {
    const auto run = std::ranges::find(problem.trajectory_runs, fitted.name, &fit::TrajectoryRun::name);
    if (run == problem.trajectory_runs.end() || !run->free_slide ||
        fitted.rms_m < kShare * way_of(run->track))
      continue;
    sentences.push_back(fmt::format(
        "run \"{}\" is given as kind = \"free_slide\", but its points lie {:.2g} mm off the slide: is it the "
        "recording of a driven run, or do `frames` hold more than the slide?",
        fitted.name, 1e3 * fitted.rms_m));
  }
  return sentences;
}

}  // namespace

std::vector<std::string> suspicious_runs(const fit::Problem& problem, const fit::FitResult& result) {
  return result.usable() ? std::vector<std::string>() : no_slides(problem, result);
}

}  // namespace tribotrack::apps
