// tribotrack watch: the experiment in closed loop, from each recording to the run to film next.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <numbers>

#include "apps/commands/command.h"
#include "apps/pipeline/campaign_runner.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/text/output_file.h"
#include "apps/watch/arrivals.h"
#include "apps/watch/growing_campaign.h"

namespace tribotrack::apps {

namespace {

constexpr double kLookForChanges = 1;  ///< s: how soon an edited campaign is read again
constexpr const char* kFirst = "phi = 0 (0deg), dtau = pi/3 (60deg): any run tells which comes next";

struct WatchOptions {
  DraftOptions draft;
  std::string output, until;
  std::optional<double> until_idle_s;
  bool json = false, wait = false;
};

std::string degrees(double rad) {
  return fmt::format("{:.4g} rad ({:.4g}deg)", rad, rad * 180 / std::numbers::pi);
}

class Watcher {
 public:
  Watcher(const WatchOptions& options, Context& context)
      : options_(options),
        context_(context),
        goals_(goals_from(options.until)),
        arrivals_(options.draft.folder, {}),
        campaign_(options.draft),
        lock_(RunFolder{options.output}, campaign_.file(), options.wait) {}

  void watch() {
    say(context_.quiet, fmt::format("watching {}; stop with Ctrl-C", options_.draft.folder.string()));
    auto last = std::chrono::steady_clock::now();
    for (bool first = true;; first = false) {
      const auto finished = arrivals_.next(first ? 0 : kLookForChanges);
      campaign_.add(finished, context_);
      const bool wanted =
          std::ranges::any_of(finished, [&](const auto& path) { return campaign_.names(path); });
      if (wanted || campaign_.has_changed()) {
        round(finished.size());
        last = std::chrono::steady_clock::now();
      }
      if (reached_) return;
      const double idle = std::chrono::duration<double>(std::chrono::steady_clock::now() - last).count();
      if (options_.until_idle_s && idle >= *options_.until_idle_s && arrivals_.unfinished().empty()) return;
    }
  }

  void finish() {
    if (!fitted_) throw InvalidInput("{}: no recording could be used", options_.draft.folder.string());
    if (!reached_ && !campaign_.awaited().empty()) context_.doubt(kQualityGate, awaited());
    if (options_.json) print_text(text_of(json_));
  }

 private:
  /// One way through the campaign. What is wrong with it, or with all runs there are so far, is said, and the
  /// next recording or an edited campaign is waited for.
  void round(std::size_t arrived) {
    try {
      Campaign campaign = campaign_.read(arrivals_.unfinished());
      if (!campaign_.awaited().empty()) say(context_.quiet, awaited());
      if (campaign.runs.empty()) {
        say_next(kFirst);
        return;
      }
      require_fitted(goals_, campaign.fit.parameters);
      CampaignRunner runner({.campaign = campaign_.file().string(),
                             .output = options_.output,
                             .command = "watch",
                             .json = options_.json,
                             .locked = true,
                             .new_recordings = arrived},
                            std::move(campaign), context_);
      context_.exit_code = kDone;
      runner.take_folder();
      runner.measure();
      runner.fit_all();
      tell(runner);
      runner.report();
      runner.write_log();
      json_ = runner.fitted().json;
      fitted_ = true;
    } catch (const OutputError&) {
      throw;
    } catch (const InvalidInput& error) {
      complain(error.what());
    } catch (const fit::DataError& error) {
      complain(error.what());
    }
  }

  std::string awaited() const {
    return fmt::format("recordings of the campaign that are not there yet, or not finished: {}",
                       fmt::join(campaign_.awaited(), ", "));
  }

  void tell(const CampaignRunner& runner) {
    const FittedCampaign& fit = runner.fitted();
    say_result(fmt::format("{} runs: {}", fit.runs.size(), fit.result.brief_report()));
    for (const Json& warning : fit.json["warnings"])
      say(context_.quiet, "warning: " + warning.get<std::string>());
    if (const auto failed = runner.failed())
      context_.doubt(kQualityGate,
                     fmt::format("{} of {} runs failed and were left out", failed, fit.runs.size()));
    if (!fit.result.usable()) context_.exit_code = kFitUnusable;
    if (!goals_.empty()) say_result(progress_of(goals_, fit.result));
    reached_ = all_reached(goals_, fit.result);
    if (reached_)
      say_result("reached: nothing more needs to be filmed");
    else if (const fit::NextExperiment* next = next_for(goals_, fit.result))
      say_next(fmt::format("phi = {}, dtau = {}{}", degrees(next->phi), degrees(next->dtau), gain(*next)));
  }

  /// ": sd(mu1) 5e-05 -> 1.1e-05", of the sentence that the fit itself says.
  static std::string gain(const fit::NextExperiment& next) {
    const auto colon = next.sentence.find(": ");
    return colon == std::string::npos ? "" : next.sentence.substr(colon);
  }

  void say_result(const std::string& line) {
    if (!options_.json) print("{}\n", line);
    flush_output();
  }
  void say_next(const std::string& what) { say_result("film next: " + what); }

  const WatchOptions& options_;
  Context& context_;
  const std::vector<fit::Goal> goals_;
  Arrivals arrivals_;
  GrowingCampaign campaign_;
  RunFolderLock lock_;
  Json json_;  ///< of fit.json
  bool fitted_ = false, reached_ = false;
};

}  // namespace

void add_watch(CLI::App& app, Context& context) {
  auto options = std::make_shared<WatchOptions>();
  CLI::App& command = *app.add_subcommand(
      "watch", "Take each recording as it arrives in a folder, refit, and say which run to film next");
  add_option(command, "FOLDER", options->draft.folder, "FOLDER",
             "Folder that recordings are written into; its campaign.toml gains a [[run]] for each")
      ->required();
  add_option(command, "-o,--output", options->output, "DIR",
             "Folder for tracks, fit.json and report.html, as of `run`")
      ->required();
  add_option(
      command, "--until", options->until, "mu1=1%,mu2=3%",
      "End when half the 95 % interval of each is no wider: a share of the value, or a width in its unit");
  add_number(command, "--until-idle-s", options->until_idle_s,
             "End when nothing has arrived for so long, s (default: never)");
  add_number(command, "--disc-diameter-mm", options->draft.diameter_mm,
             "The part's diameter, where there is no campaign.toml yet");
  add_number(command, "--chamfer-mm", options->draft.chamfer_mm,
             "Width of its chamfer seen from above, likewise");
  add_number(command, "--fps", options->draft.fps,
             "Frame rate, where there is no campaign.toml yet and the recordings do not say it");
  command.add_flag("--json", options->json, "Print the last fit as one JSON object, at the end");
  command.add_flag("--wait", options->wait,
                   "Wait while another process is writing into DIR (default: refuse)");
  add_common(command, context, "  tribotrack watch recordings --until mu1=1%,mu2=3% -o out");
  command.callback([options, &context] {
    Watcher watcher(*options, context);
    watcher.watch();
    watcher.finish();
  });
}

}  // namespace tribotrack::apps
