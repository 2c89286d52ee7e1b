// Then: the conditions under which a run was made, measured where its track shows them, else as given.
#pragma once

#include <exception>
#include <optional>
#include <string>
#include <vector>

#include "apps/files/campaign/campaign.h"
#include "apps/files/track_file.h"
#include "apps/measuring/measure_run.h"
#include "apps/text/input_file.h"
#include "fit/problem.h"

namespace tribotrack::apps {

/// A run as far as it got. One with a failure takes no part in the fit.
struct AnalysedRun {
  const CampaignRun* run = nullptr;
  std::optional<TrackFile> track;             ///< runs with a video
  std::optional<ScopeEvidence> scope;         ///< runs with an oscilloscope trace
  std::vector<Input> inputs;                  ///< the files its numbers were read from
  std::optional<RunMeasurement> measurement;  ///< runs with pulses and a video
  model::Scenario scenario;                   ///< mu1, mu2, lag still to be filled in
  fit::Displacement displacement;             ///< runs with pulses
  fit::OwnErrors own;                         ///< of what this run alone is known by
  bool amplitude_from_track = false;
  std::string failure;  ///< one sentence, empty when all went well
  std::string repeats;  ///< name of the run whose recording this one is again; it is counted once
  /// Did all go well, and is it not counted already?
  bool takes_part() const { return failure.empty() && repeats.empty(); }
};

/// Reads the run's oscilloscope trace and measures the run. `track` is empty for runs measured elsewhere.
/// Throws what measure_run throws, and InvalidInput where the part was lost too often or a condition is
/// neither given nor measured.
AnalysedRun analyse(const Campaign& campaign, const CampaignRun& run, std::optional<TrackFile> track);

/// Throws InvalidInput, naming run and file, where the run's oscilloscope trace is not there.
void require_trace(const CampaignRun& run);

/// One sentence on why a run failed: the message of any exception, naming the run.
std::string failure_of(const CampaignRun& run, const std::exception& error);

/// Measures it again, after a change of its track's scale.
void measure_again(const Campaign& campaign, AnalysedRun& analysed);

}  // namespace tribotrack::apps
