// A given value that is far from the one seen: by which slip?
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/text/json.h"
#include "fit/measurement.h"

namespace tribotrack::apps {

/// "9.995 is 62.8 rad/s in Hz", for a campaign key and its given and measured value in the unit of the key;
/// empty where none of the usual slips (another unit, peak to peak, radius for diameter, period for
/// frequency) comes within a tenth. The slips of one quantity differ by 40 % and more.
std::string likely_slip(const std::string& quantity, double given, double measured);

// The conditions of a campaign in one table: given, measured, their difference, and what the fit used.

/// One quantity, in the unit that its name carries. Where runs were given different values these are the
/// first one's, and the measured is in proportion.
struct ConditionRow {
  std::string quantity;                    ///< campaign key, "amplitude_mm"
  std::optional<fit::Estimate> given;      ///< sd 0: none was given, exact
  std::optional<fit::Estimate> measured;   ///< of all runs that show it, pooled; sd: all that is known of it
  std::size_t runs = 0;                    ///< that show it
  double p_value = 1;                      ///< that one value scatters so between the runs
  std::optional<double> difference_in_sd;  ///< measured less given, over the sd of both
  fit::Estimate used;
  std::string from;  ///< where `used` came from: "campaign, taken as exact", "marker, 14 runs"
};

/// The array `conditions` of fit.json.
Json conditions_json(const std::vector<ConditionRow>& rows);

/// For people, a line each. Empty without rows.
std::string conditions_text(const std::vector<ConditionRow>& rows);

}  // namespace tribotrack::apps
