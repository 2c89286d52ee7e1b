// From a campaign's recordings to its report: every run tracked and measured, one fit, the results in a
// folder. What is there already and current is kept. Of several parts each has its own tracks, fit and
// report.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/campaign/fit_stage.h"
#include "apps/files/campaign/campaign.h"
#include "apps/files/run_folder.h"
#include "apps/pipeline/line.h"
#include "apps/program/context.h"
#include "apps/recording/recording.h"

namespace tribotrack::apps {

struct RunnerOptions {
  std::string campaign;  ///< as the user names it
  std::string output;    ///< the folder
  std::string command = "run";
  bool explain = false, json = false;
  bool wait = false;               ///< while another process is writing into the folder
  bool locked = false;             ///< the caller holds the folder's lock
  std::size_t new_recordings = 0;  ///< the others are tracked already; 0: not known
};

/// One way through a campaign: its verbs in the order in which they are to be called.
class CampaignRunner {
 public:
  CampaignRunner(const RunnerOptions& options, Campaign campaign, Context& context);

  /// What would be done, on stdout.
  void print_plan() const;
  /// From here on only this process writes into the folder, and only over earlier results of `run`.
  void take_folder();
  /// Every run, and what they share. Refuses a campaign that contradicts its recordings, and one that has no
  /// run left; finished tracks stay for the next call. Failed runs are named.
  void measure();
  void fit_all();
  void report() const;
  void write_log() const;
  /// To standard output, and what is to be said of it to standard error.
  void print_result() const;
  void say_what_happened() const;

  const FittedCampaign& fitted() const { return fitted_; }
  std::size_t failed() const;

 private:
  Track track_of(const CampaignRun& given, const FramesDone& frames_done, Run::Log& log) const;
  std::optional<std::string> why_outdated(const CampaignRun& run, const Recording& recording) const;
  void name_failed(const std::vector<Run>& runs) const;

  const RunnerOptions options_;
  Context& context_;
  const std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
  const Campaign campaign_;
  const RunFolder folder_;
  std::optional<RunFolderLock> lock_;
  FittedCampaign fitted_;
};

/// Of one part. With `plan_only` nothing is done but said.
void run_campaign(const Campaign& campaign, const RunnerOptions& options, bool plan_only, Context& context);

/// Each part into a folder of its name, and DIR/parts.csv with the parameters of all. A part that cannot be
/// fitted is named and left out, with exit code 4; throws InvalidInput where that is all of them.
void run_part_by_part(const Campaign& campaign, const RunnerOptions& options, bool plan_only,
                      Context& context);

}  // namespace tribotrack::apps
