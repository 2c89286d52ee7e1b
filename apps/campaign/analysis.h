// A campaign's runs from recordings to one least-squares problem: where vision's tracks meet the model's
// scenarios.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/campaign/measure_run.h"
#include "apps/campaign/track_recording.h"
#include "apps/files/campaign.h"
#include "fit/problem.h"

namespace tribotrack::apps {

/// A run as far as it got. One with a failure takes no part in the fit.
struct AnalysedRun {
  const CampaignRun* run = nullptr;
  std::optional<TrackFile> track;             ///< runs with a video
  std::optional<RunMeasurement> measurement;  ///< runs with pulses and a video
  model::Scenario scenario;                   ///< mu1, mu2, lag still to be filled in
  fit::Displacement displacement;             ///< runs with pulses
  bool amplitude_from_track = false;
  std::string failure;  ///< one sentence, empty when all went well
};

/// How this run's video is to be tracked.
RecordingJob job_for(const Campaign& campaign, const CampaignRun& run);

/// Measures one run. `track` is empty for runs measured elsewhere. Throws what measure_run throws, and
/// InvalidInput where a condition is neither given nor measured.
AnalysedRun analyse(const Campaign& campaign, const CampaignRun& run, std::optional<TrackFile> track);

/// The least-squares problem of all runs that did not fail.
fit::Problem problem_of(const Campaign& campaign, const std::vector<AnalysedRun>& runs);

/// mm/px that the fit parameter `scale` is a factor on: the mean over the runs with a video; 1 where there is
/// none.
double reference_mm_per_px(const std::vector<AnalysedRun>& runs);

}  // namespace tribotrack::apps
