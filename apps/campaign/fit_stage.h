// Last: all runs as one least-squares problem.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/campaign/compared_runs.h"
#include "apps/campaign/conditions.h"
#include "apps/campaign/shared_conditions.h"
#include "apps/files/campaign/campaign.h"
#include "apps/files/run_folder.h"
#include "apps/program/context.h"
#include "apps/text/json.h"
#include "fit/estimate.h"
#include "fit/problem.h"

namespace tribotrack::apps {

/// The least-squares problem of all runs that did not fail.
fit::Problem problem_of(const Campaign& campaign, const std::vector<Run>& runs,
                        const SharedConditions& shared);

/// mm/px that the fit parameter `scale` is a factor on: the mean over the runs with a video; 1 where there is
/// none.
double reference_mm_per_px(const std::vector<Run>& runs);

// What `run` and `fit` share: every run of a campaign side by side, then one fit to all of them.

/// What is done for a run: `frames_done` is told of the frames of its recording that have been worked on, and
/// of all.
using FramesDone = std::function<void(std::int64_t done, std::int64_t total)>;
using RunWork = std::function<Run(std::size_t index, const FramesDone& frames_done)>;

/// Does the work for every run of the campaign, large recordings first, on the command's threads, showing
/// progress. A run whose work throws anything, lack of memory included, has failed; the others go on.
std::vector<Run> for_each_run(const Campaign& campaign, const Context& context, const RunWork& work);

/// What the runs share, as found before the fit.
struct SharedFindings {
  std::optional<SharedScale> scale;
  SharedConditions conditions;
};

struct FitStage {
  SharedFindings shared;
  fit::FitResult result;
  Json json;  ///< the object of fit.json
};

/// Fits all runs that did not fail, whose scale and conditions have been shared. Throws fit::DataError.
FitStage fit_runs(const Campaign& campaign, const std::vector<Run>& runs, SharedFindings shared,
                  const Context& context, fit::FitOptions options = {});

/// What stands beside fit.json: the campaign and what its runs were read from.
MetaFile meta_of_fit(const Campaign& campaign, const std::vector<Run>& runs);

/// Writes fit.json and its meta file.
void write_fit(const std::filesystem::path& path, const FitStage& stage, const MetaFile& meta);

/// What stands against using the fit as it is, with the exit code that says so.
struct Reservation {
  ExitCode exit_code = kDone;
  std::string sentence;
  std::vector<std::string> remedies;
};

/// The weightiest last; empty for a sound fit. `look_at` names where the user finds more.
std::vector<Reservation> reservations(const Campaign& campaign, const FitStage& stage,
                                      const std::string& look_at);

/// The fit's report and warnings on stderr, unless quiet; its reservations in any case, which set the exit
/// code.
void report_fit(const Campaign& campaign, const FitStage& stage, bool explain, const std::string& look_at,
                Context& context);

}  // namespace tribotrack::apps
