// Errors that all runs of a campaign share: of what is given with an sd, of the pooled measurements, and of
// what the recordings have in common (scale, exposure, coder, clock).
#pragma once

#include <map>
#include <string>
#include <vector>

#include "apps/campaign/conditions.h"
#include "apps/campaign/shared_conditions.h"
#include "fit/problem.h"

namespace tribotrack::apps {

/// Track::scale_source of a scale by the part's diameter.
inline constexpr const char* kScaledByDiameter = "part's diameter";
inline constexpr const char* kScaledByTag = "tag";

/// Of the true length that the recordings' scales were measured by, the part's diameter or the side of a tag,
/// relative; 0: exact, or the scale was given.
double length_error(const Campaign& campaign);

/// How A, A_y, w or epsilon came into the runs' scenarios.
struct SharedQuantity {
  double shared_sd = 0;   ///< relative, of an angle rad: what all runs share of its error; 0 exact, or own
  bool exact = false;     ///< some run takes a given value as exact
  bool measured = false;  ///< the markers decide it, with the errors that all that is measured shares
  bool own = false;       ///< some run has an error of its own
  bool given_with_sd = false;  ///< by the campaign, for all runs
  std::string from;
};

/// sd of what one run shows, without what all runs share of it and with what its own scale adds.
double own_sd(const Campaign& campaign, const std::vector<Run>& runs, const Run& run,
              model::Parameter quantity, const fit::Estimate& seen);

/// What all runs share of what their markers show of a quantity: relative, or of an angle rad.
double common_error(const Campaign& campaign, const std::vector<Run>& runs, model::Parameter quantity);

/// Fills `errors` and `taken_as_exact`. `one_amplitude`: A_y is A, not a quantity of its own.
void add_errors(const Campaign& campaign, std::vector<Run>& runs,
                const std::map<model::Parameter, SharedQuantity>& found, bool one_amplitude,
                SharedConditions& shared);

}  // namespace tribotrack::apps
