// Then: what all runs of a campaign share. One platform, one camera, one part: A, A_y, epsilon and w are one
// quantity each, unless the campaign gives different values or the data refuse.
#pragma once

#include <string>
#include <vector>

#include "apps/campaign/conditions.h"
#include "apps/measuring/condition_table.h"
#include "fit/problem.h"

namespace tribotrack::apps {

/// An error of a quantity that all runs share. Relative for lengths, scale and w, else SI.
struct SharedError {
  fit::FitParameter quantity = fit::FitParameter::amplitude;
  double sd = 0;
  std::string from;  ///< fit::Condition::from
  /// Known apart from these runs' platform: a prior of the quantity where it is fitted.
  bool known_beforehand = false;
};

struct SharedConditions {
  std::vector<ConditionRow> table;
  std::vector<SharedError> errors;
  std::vector<std::string> taken_as_exact;  ///< campaign keys of what was given, or by default, without an sd
  std::vector<std::string> warnings;
};

/// Pools what the runs' markers show of A, A_y, w and epsilon (fit/pooling.h) and compares it, once for all
/// runs, with what the campaign gives. The runs' scenarios then hold
///   the given value, where it has no sd;
///   the mean of given and measured, weighted by 1/sd^2, where it has;
///   the mean of all runs that show it, where none is given (of runs given different values their ratios to
///   these are pooled), its error being one that all share;
///   each run's own where the runs' values scatter as chance would in fewer than one campaign of a thousand,
///   with its error in Run::own, and a warning.
/// Displacements are measured again over the whole cycles of the w used. Beyond 3 sd of given and measured
/// one warning; throws InvalidInput, naming the likely slip, where they differ by more than kSlipShare.
SharedConditions share_conditions(const Campaign& campaign, std::vector<Run>& runs);

/// The same refusal, of what all of these runs show: for the first of many, before the others are tracked.
void require_no_slips(const Campaign& campaign, std::vector<Run>& runs);

/// Into fit.json: `conditions`, `taken_as_exact` and the warnings.
void add_to(Json& fit, const SharedConditions& shared);

}  // namespace tribotrack::apps
