#include "apps/campaign/fit_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <numeric>
#include <string>
#include <utility>

#include "apps/campaign/fit_json.h"
#include "apps/campaign/problem.h"
#include "apps/files/meta_file.h"
#include "apps/program/parallel.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/text/output_file.h"
#include "vision/frame_sink.h"

namespace tribotrack::apps {

namespace {

/// What a lossy coder does to the parameters.
std::string coding_sentence(const fit::FitResult& result) {
  std::string list;
  const Eigen::VectorXd sd = result.sd_from(fit::kFromCoder);
  for (std::size_t i = 0; i < result.parameters.size(); ++i)
    list += fmt::format("{}{} +- {:.2g}", i > 0 ? ", " : "", fit::to_string(result.parameters[i].parameter),
                        sd(static_cast<Eigen::Index>(i)));
  return fmt::format(
      "what the recordings' coder does to the platform's motion exceeds the interval that the data give: it "
      "is counted in the intervals ({}, SI); film uncompressed or with every frame coded by itself, or track "
      "with --rehearse where the coder is known",
      list);
}

/// Large recordings first: one that began last would leave the other threads without work.
std::vector<std::size_t> order_of_work(const Campaign& campaign) {
  std::vector<std::uintmax_t> bytes;
  for (const CampaignRun& run : campaign.runs) {
    std::error_code not_a_file;
    const std::uintmax_t size = run.video ? std::filesystem::file_size(*run.video, not_a_file) : 0;
    bytes.push_back(not_a_file ? 0 : size);
  }
  std::vector<std::size_t> order(bytes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::ranges::greater(), [&](std::size_t k) { return bytes[k]; });
  return order;
}

}  // namespace

std::vector<AnalysedRun> for_each_run(const Campaign& campaign, const Context& context,
                                      const std::function<AnalysedRun(std::size_t index)>& work) {
  std::vector<AnalysedRun> runs(campaign.runs.size());
  Progress progress("runs", context.quiet);
  std::atomic<long> done = 0;
  const auto count = static_cast<long>(runs.size());
  const std::vector<std::size_t> order = order_of_work(campaign);
  for_each_index(count, threads_to_use(context), [&](long k) {
    const std::size_t index = order[static_cast<std::size_t>(k)];
    const CampaignRun& run = campaign.runs[index];
    try {
      runs[index] = work(index);
    } catch (const OutputError&) {
      throw;  // a full disk is no fault of this run
    } catch (const vision::OutputError&) {
      throw;
    } catch (const std::exception& error) {
      runs[index] = {};
      runs[index].run = &run;
      runs[index].failure = failure_of(run, error);
    }
    progress.update(++done, count);
  });
  return runs;
}

FitStage fit_runs(const Campaign& campaign, const std::vector<AnalysedRun>& runs, SharedFindings shared,
                  const Context& context, fit::FitOptions options) {
  FitStage stage;
  stage.shared = std::move(shared);
  options.threads = threads_to_use(context);
  StageProgress progress(context.quiet);
  options.progress = [&progress](const char* name, std::size_t done, std::size_t total) {
    progress.update(std::string("fit, ") + name, done, total);
  };
  stage.result = fit::estimate(problem_of(campaign, runs, stage.shared.conditions), options);
  stage.json = fit_json(campaign, runs, stage.result);
  add_to(stage.json, stage.shared.scale);
  add_to(stage.json, stage.shared.conditions);
  return stage;
}

MetaFile meta_of_fit(const Campaign& campaign, const std::vector<AnalysedRun>& runs) {
  MetaFile meta;
  meta.command = "fit";
  meta.inputs = {campaign.input};
  for (const AnalysedRun& run : runs)
    if (run.failure.empty()) meta.inputs.insert(meta.inputs.end(), run.inputs.begin(), run.inputs.end());
  meta.configuration = campaign.effective_configuration();
  return meta;
}

void write_fit(const std::filesystem::path& path, const FitStage& stage, const MetaFile& meta) {
  write_result(path, text_of(stage.json), meta);
}

void report_fit(const Campaign& campaign, const FitStage& stage, bool explain, const std::string& look_at,
                Context& context) {
  const fit::FitResult& result = stage.result;
  say(context.quiet, explain ? result.full_report() : result.brief_report());
  if (explain) say(context.quiet, conditions_text(stage.shared.conditions.table));
  for (const Json& warning : stage.json["warnings"])
    say(context.quiet, "warning: " + warning.get<std::string>());
  if (coder_exceeds_interval(result)) {
    complain(fmt::format("{}: {}", campaign.file.string(), coding_sentence(result)));
    context.exit_code = kQualityGate;
  }
  if (result.usable()) return;
  complain(fmt::format(
      "{}: the fit is not usable: {}", campaign.file.string(),
      !result.converged ? "it did not converge; give first guesses in [fit.guess]"
      : result.identifiability.verdict == fit::Verdict::not_identifiable
          ? "the data do not determine these parameters separately; see " + look_at
          : "the runs scatter about the model by more than a tenth of what they measure; see " + look_at));
  for (const std::string& sentence : remedies(result)) print_error("  " + sentence);
  context.exit_code = kFitUnusable;
}

}  // namespace tribotrack::apps
