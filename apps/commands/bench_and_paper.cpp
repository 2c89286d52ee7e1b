// tribotrack bench: error against run time, ours and others', the stiff and extreme cases, what omissions
// save, and how often intervals hold. tribotrack paper: the source paper's figures and claims, computed
// again.
#include <fmt/format.h>

#include <memory>

#include "apps/bench/comparison.h"
#include "apps/bench/page.h"
#include "apps/commands/command.h"
#include "apps/files/run_folder.h"
#include "apps/page/assets/embedded_assets.h"
#include "apps/paper/paper.h"
#include "apps/program/errors.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/text/input_file.h"
#include "apps/text/output_file.h"
#include "apps/usage/wrong_usage.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

struct BenchCall {
  std::string what, output;
  bool json = false;
  bench::BenchOptions options;
};

void write_results(const BenchCall& asked, const Context& context, const bench::BenchResults& results,
                   const bench::Circumstances& here) {
  const fs::path folder = asked.output;
  const Json json = json_of(results, here);
  const auto told = [&](const fs::path& file) {
    if (!asked.json) print("{}\n", file.string());
  };
  for (const bench::Table& table : tables_of(results)) {
    const fs::path csv = folder / (table.name + ".csv");
    write_result(csv, table.csv(), {"bench", {}, {{"what", asked.what}, {"quick", asked.options.quick}}});
    told(csv);
  }
  say(context.quiet, "Who wins where");
  for (const bench::SummaryLine& line : summary_of(results))
    say(context.quiet,
        fmt::format("  {}: tribotrack {}; others {}: {}", line.measured, line.ours, line.peer, line.who));
  write_file(folder / "bench.html", page_of(results, here));
  told(folder / "bench.html");
  write_file(folder / "bench.json", text_of(json));
  told(folder / "bench.json");
  if (asked.json) print_text(text_of(json));
}

void run_bench(const BenchCall& asked, const Context& context) {
  create_folder(asked.output);
  require_writable({{fs::path(asked.output) / "bench.json"}, {fs::path(asked.output) / "bench.html"}});
  const bench::Circumstances here = bench::circumstances_here();
  bench::BenchResults results;
  const auto wanted = [&](const char* what) { return asked.what == "all" || asked.what == what; };
  const auto measured = [&](const char* name, const auto& measure) {
    bench::BenchOptions options = asked.options;
    options.threads = threads_to_use(context);
    options.program = fs::read_symlink("/proc/self/exe");
    Progress progress(name, context);
    options.progress = [&](int done, int total) { progress.update(done, total); };
    return measure(options);
  };
  if (wanted("model")) {
    if (const std::string missing = bench::missing_library(); !missing.empty())
      say(context.quiet,
          fmt::format("bench model: this build was made without {}; its solvers are not compared", missing));
    results.comparisons.push_back(measured(
        "bench model", [](const bench::BenchOptions& options) { return bench::bench_model(options); }));
    results.extremes = measured("bench model, extremes", bench::bench_extremes);
    results.omissions = measured("bench model, omissions", bench::bench_omissions);
  }
  if (wanted("vision")) results.comparisons.push_back(measured("bench vision", bench::bench_vision));
  if (wanted("fit")) results.comparisons.push_back(measured("bench fit", bench::bench_fit));
  if (wanted("fit") || wanted("coverage")) results.coverage = measured("bench coverage", bench::coverage);
  if (wanted("fit") || wanted("laboratory"))
    results.laboratory = measured("bench laboratory", bench::laboratory);
  write_results(asked, context, results, here);
}

/// For --help.
std::string peers_of_this_build() {
  const std::string missing = bench::missing_library();
  return missing.empty() ? "" : fmt::format("\nThis build was made without {}.", missing);
}

}  // namespace

void add_bench(CLI::App& app, Context& context) {
  auto options = std::make_shared<BenchCall>();
  CLI::App& command = *app.add_subcommand(
      "bench",
      "Measure error against run time, ours and others', the stiff and extreme cases, what "
      "omissions save, and how often intervals hold");
  command
      .add_option(
          "WHAT", options->what,
          "model: integrators, the table of extremes, what omissions save (a minute); vision: trackers on "
          "rendered recordings, beside the physical limit, and whole commands (half an hour); fit: ours "
          "beside descents with differences, coverage and laboratory (half an hour, on all cores); coverage: "
          "how often the intervals of simulated campaigns of ten designs hold; laboratory: what a fit says "
          "where platform and friction are not the model; all")
      ->check(one_of({"model", "vision", "fit", "coverage", "laboratory", "all"}))
      ->required();
  add_option(command, "-o,--output", options->output, "DIR",
             "Folder for bench_model.csv, bench_model_extremes.csv, bench_model_plan.csv, bench_vision.csv, "
             "bench_fit.csv, bench_fit_coverage.csv, bench_fit_laboratory.csv, bench.html (all of it on one "
             "page, who wins where on "
             "top, with figures of error against run time) and bench.json (CPU, compiler flags, how the "
             "references were made, solvers this build lacks)")
      ->required();
  command
      .add_option("--campaigns", options->options.campaigns,
                  "coverage: simulated campaigns of each design and noise level (default 200): 2000 tell a "
                  "coverage to 1 %; laboratory: a twentieth, of each fault")
      ->check(whole_number(1, 1'000'000));
  command.add_flag("--quick", options->options.quick,
                   "Few and short cases, seconds in all: a check that it works, not a measurement");
  command.add_flag("--json", options->json, "Print bench.json instead of the names of the files");
  add_common(
      command, context,
      "  tribotrack bench model -o bench\n\nThe summary goes to stderr, the names of the files written to "
      "stdout; "
      "bench.html shows all\nof it. Where another method is more accurate or faster, the summary says PEER "
      "WINS. "
      "One thread is used,\nand all for the simulated campaigns. `bench model` includes SUNDIALS and "
      "Boost.odeint "
      "where the\nprogram was built with them (CMake option TRIBOTRACK_PEERS), else it names what is "
      "missing." +
          peers_of_this_build());
  command.callback([options, &context] { run_bench(*options, context); });
}

namespace {

Paper compute(const Context& context) {
  Progress progress("paper", context, "claims");
  return {paper_figures(context),
          paper_claims(context, [&progress](int done, int total) { progress.update(done, total); })};
}

void run_paper(const fs::path& folder, bool json, const Context& context) {
  create_folder(folder);
  const fs::path page = folder / "paper.html", claims = folder / "claims.csv";
  require_writable({{page}, {claims}});

  const Paper paper = compute(context);
  MetaFile meta;
  meta.command = "paper";
  for (const EmbeddedScenario& scenario : paper_scenarios())
    meta.configuration["scenarios"][std::string(scenario.name)] = hash_of_text(scenario.toml);
  write_result(claims, claims_csv(paper), meta);
  write_result(page, page_of(paper), meta);
  say(context.quiet, fmt::format("{}: {} figures, {} claims: {}", page.string(), paper.figures.size(),
                                 paper.claims.size(), verdicts_text(paper.claims)));
  if (!json) return;
  Json list = Json::array();
  for (const Claim& claim : paper.claims)
    list.push_back({{"claim", claim.name}, {"verdict", to_string(claim.verdict)}});
  print_text(text_of(Json{{"page", page.string()}, {"claims", list}}));
}

}  // namespace

void add_paper(CLI::App& app, Context& context) {
  auto output = std::make_shared<std::string>();
  CLI::App& command = *app.add_subcommand(
      "paper", "The source paper's figures and claims, computed again: one page with a verdict on each");
  add_option(command, "-o,--output", *output, "DIR",
             "Folder for paper.html (self-contained: figures 3 to 7 and the model's side of 9 to 11, "
             "beside each what the paper claims, what is found and the verdict) and claims.csv")
      ->required();
  auto json = std::make_shared<bool>(false);
  command.add_flag("--json", *json, "Print claims and verdicts as one JSON object");
  add_common(command, context, "  tribotrack paper -o paper");
  command.callback([output, json, &context] { run_paper(*output, *json, context); });
}

}  // namespace tribotrack::apps
