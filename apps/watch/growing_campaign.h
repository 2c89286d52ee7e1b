// The goals of `watch --until` as text.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "apps/files/campaign/campaign.h"
#include "apps/program/context.h"
#include "apps/survey/campaign_draft.h"
#include "fit/goal.h"

namespace tribotrack::apps {

/// "mu1=1%,mu2=3%,phase_lag_rad=0.5deg". Throws UsageError.
std::vector<fit::Goal> goals_from(const std::string& text);

/// "mu1 to 1 %: 0.46 %; mu2 to 3 %: reached, 1.2 %".
std::string progress_of(const std::vector<fit::Goal>& goals, const fit::FitResult& result);

/// Throws UsageError where a goal names a parameter that is not among those fitted.
void require_fitted(const std::vector<fit::Goal>& goals, const std::vector<fit::FitParameter>& fitted);

// A campaign that gains a [[run]] for each recording that arrives.

class GrowingCampaign {
 public:
  /// draft.folder/campaign.toml; where there is none, one is made as `init` does, for which the scale must be
  /// given. Throws InvalidInput.
  explicit GrowingCampaign(const DraftOptions& draft);

  const std::filesystem::path& file() const { return file_; }

  /// Adds a [[run]] for every recording that the campaign does not name: phi and dtau by its name, mark and
  /// lamp as they are seen. What cannot be added is said once.
  void add(const std::vector<std::filesystem::path>& finished, const Context& context);

  /// Whether the file has changed since the last read().
  bool has_changed() const;

  /// As it stands, without the runs whose recordings are not there yet, or not finished. Empty of runs where
  /// none is left. Throws InvalidInput.
  Campaign read(const std::vector<std::filesystem::path>& unfinished);

  /// Whether a run of it has this recording.
  bool names(const std::filesystem::path& recording) const;

  /// Names of the runs left out by the last read().
  const std::vector<std::string>& awaited() const { return awaited_; }

 private:
  std::filesystem::path folder_, file_;
  DraftOptions draft_;
  std::filesystem::file_time_type read_at_;
  std::vector<std::string> awaited_;
  std::set<std::filesystem::path> refused_;
};

}  // namespace tribotrack::apps
