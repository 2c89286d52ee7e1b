// One camera, one part: the scale that a campaign's runs share.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/campaign/analysis.h"
#include "vision/millimetres.h"

namespace tribotrack::apps {

/// What became of the runs' own scales.
struct SharedScale {
  vision::PooledScale pooled;
  bool used = false;
  std::string finding;  ///< one sentence
};

/// Where two or more runs are scaled by the part's diameter and one scale explains them, all get the mean
/// (vision/scale.h) and are analysed again with it: each run's noise in the radius is then no longer one of
/// its own. Where none does (the camera moved, another part) each keeps its own. Nothing for fewer
/// than two such runs.
std::optional<SharedScale> share_scale(const Campaign& campaign, std::vector<AnalysedRun>& runs);

/// The same track at another scale.
void rescale(TrackFile& track, const vision::Scale& scale);

/// Into fit.json: `shared_scale`, and a warning where the runs do not agree.
void add_to(Json& fit, const std::optional<SharedScale>& shared);

}  // namespace tribotrack::apps
