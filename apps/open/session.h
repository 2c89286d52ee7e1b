// One campaign in a folder, as the page of `open` sees and changes it.
#pragma once

#include <filesystem>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>

#include "apps/files/campaign/campaign.h"
#include "apps/open/child.h"
#include "apps/open/server.h"
#include "apps/program/context.h"
#include "vision/frame_source.h"

namespace tribotrack::apps {

/// What these runs could tell before any is tracked: every driven run's displacement as the model has it for
/// mu1, mu2 and lag of [fit.guess] (else 0.1, mu1/8 and 0), known to 1 % and 0.01 mm, fitted as `fit` does.
/// Object with `sentence`, and where A and w are given `parameters` {name: {assumed, sd}}, `weak` and `next`.
Json forecast_of(const Campaign& campaign, const Context& context);

/// What all runs share, one entry a quantity: {name, section, key, given, sd, from}; `from` says whether it
/// is given, measured from the recordings or assumed.
Json conditions_of(const Campaign& campaign);

class OpenSession {
 public:
  /// A folder, or a campaign in one. Throws InvalidInput.
  OpenSession(const std::filesystem::path& given, const Context& context);
  const std::filesystem::path& folder() const { return folder_; }
  /// By any of the server's threads.
  Answer answer(const Asked& asked);

 private:
  using Query = std::function<std::string(const std::string&)>;
  Json state();
  Answer changed(const Json& wanted);
  std::string with_changes(const Json& wanted, std::string text) const;
  void take_list(const std::string& list, std::string& text) const;
  Answer probe(const std::string& recording);
  Answer frame(const Query& query);
  Answer output(const std::string& path) const;
  Answer started(const Json& wanted);
  Words arguments_of(const Json& wanted);
  Words first_second(const std::string& run);
  std::filesystem::path file() const { return folder_ / name_; }
  std::string campaign_text() const;
  std::string revision() const;
  /// The recording of a campaign's key `video`; throws InvalidInput for what lies outside the folder, links
  /// followed.
  std::filesystem::path recording(const std::string& video);
  bool is_inside(const std::filesystem::path& path) const;

  struct Opened {
    std::filesystem::path path;
    std::mutex mutex;
    std::unique_ptr<vision::FrameSource> source;
  };
  std::shared_ptr<Opened> opened(const std::filesystem::path& path);

  const Context& context_;
  std::filesystem::path folder_;           ///< canonical
  std::string name_;                       ///< of the campaign in it
  std::set<std::filesystem::path> named_;  ///< recordings that the campaign named when the page was opened
  std::mutex mutex_;                       ///< of the campaign's file and of what follows
  std::map<std::filesystem::path, std::pair<std::filesystem::file_time_type, std::string>> probed_;
  std::list<std::shared_ptr<Opened>> opened_;
  Job job_;
};

}  // namespace tribotrack::apps
