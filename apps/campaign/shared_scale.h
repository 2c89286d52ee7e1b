// One camera, one part: the scale that a campaign's runs share.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/campaign/conditions.h"
#include "vision/millimetres.h"

namespace tribotrack::apps {

/// What became of the runs' own scales.
struct SharedScale {
  vision::PooledScale pooled;
  bool used = false;
  std::string finding;  ///< one sentence
};

/// A run whose part is of another size than the others' has failed (three or more runs, with the platform's
/// motion seen). Where two or more runs are scaled by the part's diameter and one scale explains them, all
/// get the mean (vision::pooled_scale) and are measured again with it: the noise of each run's radius is then
/// common to all. Where none does (the camera moved, another part) each keeps its own. A run that cannot be
/// measured again has failed. Nothing for fewer than two such runs.
std::optional<SharedScale> share_scale(const Campaign& campaign, std::vector<AnalysedRun>& runs);

/// The same track at another scale.
void rescale(TrackFile& track, const vision::Scale& scale);

/// Into fit.json: `shared_scale`, and a warning where the runs do not agree.
void add_to(Json& fit, const std::optional<SharedScale>& shared);

}  // namespace tribotrack::apps
