// What `fit` does with a campaign: a track of every run, read or made, then one fit.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/campaign/fit_stage.h"
#include "apps/files/campaign/campaign.h"
#include "apps/program/context.h"
#include "fit/estimate.h"

namespace tribotrack::apps {

struct FitChoices {
  std::filesystem::path tracks;  ///< folder of the runs' tracks, NAME.csv; empty: videos are tracked now
  std::filesystem::path
      measurements;              ///< folder for each run's measurement, NAME.json; empty: none is written
  int allow_missing = 0;         ///< runs that may fail
  std::string loss = "squares";  ///< one of losses()
  /// Where a picture goes that asks which disc is the part: beside this result. Nothing: no picture.
  std::optional<std::filesystem::path> result;
  fit::FitOptions fit;  ///< bootstrap, its seed, rivals
};

/// "squares", "huber".
const std::vector<std::string>& losses();

/// Throws InvalidInput for the first of more failed runs than are allowed (those that are allowed for are
/// told on stderr, unless quiet), UsageError for another loss, fit::DataError.
FittedCampaign fit_campaign(const Campaign& campaign, const FitChoices& choices, const Context& context);

}  // namespace tribotrack::apps
