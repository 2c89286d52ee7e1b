// A recording that stands twice in a campaign tells nothing twice.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/campaign/conditions.h"
#include "fit/fit_result.h"
#include "fit/problem.h"
#include "vision/millimetres.h"

namespace tribotrack::apps {

/// 'run "b" is the recording of run "a" once more: it is counted once', one for each.
std::vector<std::string> repeated_text(const std::vector<Run>& runs);

// One camera, one part: the scale that a campaign's runs share.

/// Track::scale_source of a scale by a length that each recording shows.
inline constexpr const char* kScaledByDiameter = "part's diameter";
inline constexpr const char* kScaledByTag = "tag";

/// What became of the runs' own scales.
struct SharedScale {
  vision::PooledScale pooled;  ///< used where it is one_scale
  std::string finding;         ///< one sentence
};

/// A run whose part is of another size than the others' has failed (three or more runs, with the platform's
/// motion seen). Where two or more runs are scaled by the part's diameter and one scale explains them, all
/// get the mean (vision::pooled_scale) and are measured again with it: the noise of each run's radius is then
/// common to all. Where none does (the camera moved, another part) each keeps its own. A run that cannot be
/// measured again has failed. Nothing for fewer than two such runs.
std::optional<SharedScale> share_scale(const Campaign& campaign, std::vector<Run>& runs);

/// The same track at another scale.
void rescale(Track& track, const vision::Scale& scale);

/// Into fit.json: `shared_scale`, and a warning where the runs do not agree.
void add_to(Json& fit, const std::optional<SharedScale>& shared);

// Then, where the fit is not usable: the runs whose kind may be wrong.

/// A sentence for each free slide whose points lie off the fitted slide by more than a tenth of its way;
/// empty where the fit is usable.
std::vector<std::string> suspicious_runs(const fit::Problem& problem, const fit::FitResult& result);

}  // namespace tribotrack::apps
