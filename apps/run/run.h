// A run of a campaign: what is given of it, and what each stage has added.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/files/campaign/campaign.h"
#include "apps/files/track_file.h"
#include "apps/measuring/measure_run.h"
#include "apps/text/input_file.h"
#include "apps/text/json.h"
#include "fit/problem.h"
#include "model/scenario.h"

namespace tribotrack::apps {

/// A run as far as it got: given -> tracked -> measured -> under its conditions. What a stage has not
/// reached, or what the run does not have, is empty. The fit's residuals are in fit::FitResult::runs, by
/// name.
struct Run {
  CampaignRun given;

  // Tracked.
  std::optional<Track> track;  ///< of a recording, or another program's
  std::vector<Input> inputs;   ///< the files its numbers were read from

  // Measured.
  std::optional<ScopeEvidence> scope;         ///< runs with an oscilloscope trace
  std::optional<RunMeasurement> measurement;  ///< runs with pulses and a track
  fit::Displacement displacement;             ///< runs with pulses

  // Conditions: measured where the track shows them, else as given.
  model::Scenario scenario;  ///< mu1, mu2, lag still to be filled in
  fit::OwnErrors own;        ///< of what this run alone is known by
  /// Of what was seen of the gate that which is known better than the command; empty: as commanded.
  std::optional<fit::GateTiming> gate;
  std::string gate_reference;         ///< RunMeasurement's, or "command": phi is the commanded one
  bool amplitude_from_track = false;  ///< A was measured in the same picture

  std::string failure;  ///< why it went no further, one sentence; empty when all went well
  std::string repeats;  ///< name of the run whose recording this one is again; it is counted once
  /// Did all go well, and is it not counted already?
  bool takes_part() const { return failure.empty() && repeats.empty(); }

  /// How the work went, for run.json.
  struct Log {
    bool skipped = false;  ///< its track was current
    std::string again;     ///< why it was not, where there was one
    double seconds = 0, frames_per_second = 0;
    Json stage_seconds = Json::object();  ///< of tracking
  } log;
};

}  // namespace tribotrack::apps
