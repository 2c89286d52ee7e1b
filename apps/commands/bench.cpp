// tribotrack bench: error against run time, ours and others', the stiff and extreme cases, what omissions
// save, and the claims of the source paper.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <optional>

#include "apps/bench/peers/library_peers.h"
#include "apps/bench/tables/tables.h"
#include "apps/commands/command.h"
#include "apps/files/meta_file.h"
#include "apps/program/progress.h"
#include "apps/text/output_file.h"
#include "apps/text/svg_plot.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

struct BenchOptions {
  std::string what;
  std::string output;
  bool quick = false;
  std::optional<int> campaigns;
  std::vector<int> frames;
  std::vector<double> diameters;
  std::string keep;
};

std::string cpu_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name"))
      if (const auto colon = line.find(": "); colon != std::string::npos) return line.substr(colon + 2);
  return "unknown";
}

Json load_average() {
  std::array<double, 3> load{};
  if (getloadavg(load.data(), 3) != 3) return {};
  return {load[0], load[1], load[2]};
}

/// What the figures depend on: machine, build and references.
Json circumstances() {
  Json json;
  json["program"] = "tribotrack " TRIBOTRACK_VERSION;
  json["cpu"] = cpu_name();
  json["compiler"] = TRIBOTRACK_COMPILER;
  json["compiler_flags"] = TRIBOTRACK_COMPILER_FLAGS;
  json["threads"] = 1;
  json["clock"] =
      "CPU time of the measuring thread, of whole commands of their process; medians of repetitions in which "
      "the methods take turns";
  json["load_average_before"] = load_average();
  json["reference"] = {{"model",
                        "Dormand-Prince 5(4) in extended precision (64-bit mantissa), segmented at the "
                        "friction switches, local "
                        "tolerance 1e-17 of the scene's scales (1e-15 with --quick); in the marginal scene, "
                        "where explicit methods "
                        "hang, tribotrack's own result at tolerance 1e-17. Each row names its reference"},
                       {"vision",
                        "truth of analytically rendered pictures; the bound is Cramer-Rao with everything "
                        "but the position known, "
                        "the 1/12 of rounding included"},
                       {"fit", "truth of simulated campaigns; 1 degree on alpha and 2 % on v per run"}};
  json["peers_missing"] = bench::peers::missing_libraries();
  json["peers"] =
      "own compact implementations of the paper's recipe, Dormand-Prince and Moreau-Jean, and Boost.odeint, "
      "compiled with the same flags (odeint a second time for AVX2 and FMA); SUNDIALS and OpenCV as "
      "installed, on one thread";
  return json;
}

class Bench {
 public:
  Bench(const BenchOptions& options, const Context& context)
      : options_(options), context_(context), folder_(options.output), json_(circumstances()) {
    create_folder(folder_);
    require_writable(folder_ / "bench.json");
  }

  void model() {
    bench::ModelBenchOptions options;
    options.quick = options_.quick;
    options.peers = bench::peers::all_peers();
    for (const std::string& library : bench::peers::missing_libraries())
      say(context_.quiet,
          fmt::format("bench model: this build was made without {}; its solvers are not compared", library));
    std::vector<bench::ModelBenchRow> rows;
    std::vector<bench::ModelExtremeRow> extremes;
    {
      Progress progress("bench model", context_.quiet);
      options.progress = [&](int done, int total) { progress.update(done, total); };
      rows = bench::bench_model(options);
    }
    {
      Progress progress("bench model, extremes", context_.quiet);
      options.progress = [&](int done, int total) { progress.update(done, total); };
      extremes = bench::bench_model_extremes(options);
    }
    std::vector<bench::PlanBenchRow> omissions;
    {
      Progress progress("bench model, plan", context_.quiet);
      options.progress = [&](int done, int total) { progress.update(done, total); };
      omissions = bench::bench_plan(options);
    }
    std::vector<bench::BatchBenchRow> batches;
    {
      Progress progress("bench model, many at once", context_.quiet);
      options.progress = [&](int done, int total) { progress.update(done, total); };
      batches = bench::bench_batch(options);
    }
    std::vector<bench::PaperClaim> claims;
    {
      Progress progress("bench model, claims", context_.quiet);
      bench::ClaimOptions claim_options;
      claim_options.quick = options_.quick;
      claim_options.progress = [&](int done, int total) { progress.update(done, total); };
      claims = bench::paper_claims(claim_options);
    }
    keep("bench_model", table_of(rows, bench::peers::missing_libraries()));
    keep("bench_model_extremes", table_of(extremes));
    keep("bench_model_plan", table_of(omissions));
    keep("bench_model_batch", table_of(batches));
    keep("bench_model_claims", table_of(claims));
    long broken = 0;
    for (const auto& row : extremes) broken += !row.held;
    results_["model"] = {{"rows", rows.size()},
                         {"extremes", extremes.size()},
                         {"laws_broken", broken},
                         {"omissions", omissions.size()},
                         {"batches", batches.size()}};
    for (const auto& claim : claims) results_["model"]["claims"][claim.name] = to_string(claim.verdict);
    if (broken > 0)
      say(context_.quiet, fmt::format("bench model: {} of the extreme cases break their law", broken));
  }

  void vision() {
    bench::VisionBenchOptions options;
    options.quick = options_.quick;
    std::vector<bench::VisionBenchRow> rows;
    {
      Progress progress("bench vision", context_.quiet);
      options.progress = [&](int done, int total) { progress.update(done, total); };
      rows = bench::bench_vision(options);
    }
    bench::VisionLimitOptions grid;
    if (options_.quick) grid = bench::quick_limit_options();
    std::vector<bench::VisionLimitRow> limits;
    {
      Progress progress("bench vision, limit", context_.quiet);
      grid.progress = [&](int done, int total) { progress.update(done, total); };
      limits = bench::bench_limit(grid);
    }
    bench::VisionDecodingOptions recordings;
    if (options_.quick) recordings = bench::quick_decoding_options();
    std::vector<bench::VisionDecodingRow> decodings;
    {
      Progress progress("bench vision, recordings", context_.quiet);
      recordings.progress = [&](int done, int total) { progress.update(done, total); };
      decodings = bench::bench_decoding(recordings);
    }
    keep("bench_vision", table_of(rows));
    keep("bench_vision_limit", table_of(limits));
    keep("bench_vision_decoding", table_of(decodings));
    results_["vision"] = {
        {"rows", rows.size()}, {"limit_rows", limits.size()}, {"decoding_rows", decodings.size()}};
  }

  void commands() {
    bench::WholeCommandOptions options;
    if (options_.quick) options = bench::quick_whole_command_options();
    options.program = fs::read_symlink("/proc/self/exe");
    if (!options_.frames.empty()) options.frames = options_.frames;
    if (!options_.diameters.empty()) options.diameters = options_.diameters;
    options.keep = options_.keep;
    Progress progress("bench commands", context_.quiet);
    options.progress = [&](int done, int total) { progress.update(done, total); };
    const auto rows = bench::bench_whole_commands(options);
    keep("bench_commands", table_of(rows));
    results_["commands"] = {{"rows", rows.size()}};
  }

  void fit() {
    bench::FitBenchOptions options;
    options.quick = options_.quick;
    Progress progress("bench fit", context_.quiet);
    options.progress = [&](int done, int total) { progress.update(done, total); };
    const auto rows = bench::bench_fit(options);
    keep("bench_fit", table_of(rows));
    bench::CoverageOptions campaigns;
    if (options_.quick) campaigns.campaigns = 2;
    if (options_.campaigns) campaigns.campaigns = *options_.campaigns;
    campaigns.of_trajectories = std::min(campaigns.campaigns, options_.quick ? 1 : campaigns.of_trajectories);
    campaigns.threads = threads_to_use(context_);
    Progress counting("bench fit, coverage", context_.quiet);
    campaigns.progress = [&](int done, int total) { counting.update(done, total); };
    const auto covered = bench::coverage(campaigns);
    keep("bench_fit_coverage", table_of(covered));
    results_["fit"] = {{"rows", rows.size()},
                       {"coverage", {{"campaigns", campaigns.campaigns}, {"seed", campaigns.seed}}}};
  }

  /// Files and tables once everything is measured: an interrupted bench leaves nothing half done.
  void finish() {
    for (const auto& [name, table] : tables_) {
      const fs::path csv = folder_ / (name + ".csv");
      write_file(csv, table.csv);
      write_meta(csv);
      fmt::print("{}\n", csv.string());
      if (!table.plot.panels.empty()) {
        const fs::path svg = folder_ / (name + ".svg");
        write_file(svg, svg_of(table.plot));
        write_meta(svg);
        fmt::print("{}\n", svg.string());
      }
      say(context_.quiet, table.text);
    }
    json_["load_average_after"] = load_average();
    json_["results"] = results_;
    write_file(folder_ / "bench.json", text_of(json_));
    fmt::print("{}\n", (folder_ / "bench.json").string());
  }

 private:
  void keep(const std::string& name, bench::BenchTable table) {
    tables_.emplace_back(name, std::move(table));
  }
  void write_meta(const fs::path& result) const {
    MetaFile meta;
    meta.command = "bench";
    meta.configuration = {{"what", options_.what}, {"quick", options_.quick}};
    meta.more["reference"] = json_.at("reference");
    meta.write_beside(result);
  }

  const BenchOptions& options_;
  const Context& context_;
  fs::path folder_;
  Json json_;
  Json results_ = Json::object();
  std::vector<std::pair<std::string, bench::BenchTable>> tables_;
};

void run_bench(const BenchOptions& options, const Context& context) {
  Bench measurements(options, context);
  const bool all = options.what == "all";
  if (all || options.what == "model") measurements.model();
  const bool vision = all || options.what == "vision";
  if (vision) measurements.vision();
  if (vision || options.what == "commands") measurements.commands();
  if (all || options.what == "fit") measurements.fit();
  measurements.finish();
}

/// For --help.
std::string peers_of_this_build() {
  std::string missing;
  for (const std::string& library : bench::peers::missing_libraries())
    missing += (missing.empty() ? "" : " and ") + library;
  return missing.empty() ? "" : "\nThis build was made without " + missing + ".";
}

}  // namespace

void add_bench(CLI::App& app, Context& context) {
  auto options = std::make_shared<BenchOptions>();
  CLI::App& command =
      *app.add_subcommand("bench",
                          "Measure error against run time, ours and others', the stiff and extreme cases, "
                          "what omissions save, and the source paper's claims");
  command
      .add_option(
          "WHAT", options->what,
          "model: integrators, the table of extremes, what the plan saves, many runs at once, the paper's "
          "claims (a minute); vision: sub-pixel methods on rendered scenes, the tracker against the "
          "physical limit, and against the decoding of recordings (a quarter of an hour), and all of "
          "`commands`; commands: `track` from the start of its process to its end, beside whole commands of "
          "others, with the share of each stage (an hour); fit: exact derivatives against differences, and "
          "how often the intervals of simulated campaigns of eleven designs hold (some minutes, on all "
          "cores); all")
      ->check(one_of({"model", "vision", "commands", "fit", "all"}))
      ->required();
  command
      .add_option(
          "-o,--output", options->output,
          "Folder for bench_model.csv, bench_model_extremes.csv, bench_model_plan.csv, "
          "bench_model_batch.csv, bench_model_claims.csv, bench_vision.csv, bench_vision_limit.csv, "
          "bench_vision_decoding.csv, bench_commands.csv, bench_fit.csv, bench_fit_coverage.csv, their "
          "plots (.svg) and bench.json (CPU, compiler flags, how the references were made, solvers this "
          "build lacks)")
      ->type_name("DIR")
      ->required();
  command
      .add_option(
          "--campaigns", options->campaigns,
          "fit: simulated campaigns of each design and noise level (default 200, of tracks at most 50): "
          "2000 tell a coverage to 1 %")
      ->check(CLI::Range(1, 1'000'000));
  CLI::Option* frames =
      command
          .add_option(
              "--frames", options->frames,
              "commands: lengths of the recordings (default 100,500,2000). Pictures are 1280 x 800, beyond "
              "5000 frames 640 x 400, of which 20000 take 5 GB uncompressed")
          ->delimiter(',')
          ->check(CLI::Range(24, 1'000'000))
          ->type_name("N,N,...");
  CLI::Option* diameters =
      command.add_option("--diameters", options->diameters, "commands: of the disc, px (default 60,120,300)")
          ->delimiter(',')
          ->check(CLI::Range(24, 300))
          ->type_name("D,D,...");
  command
      .add_option("--keep", options->keep,
                  "commands: keep the recordings in this folder, and use those that are there (default: "
                  "temporary ones, removed)")
      ->type_name("DIR");
  command
      .add_flag("--quick", options->quick,
                "Few and short cases, seconds in all: a check that it works, not a measurement")
      ->excludes(frames)
      ->excludes(diameters);
  add_common(
      command, context,
      "  tribotrack bench model -o bench\n\nTables go to stderr, the names of the files written to "
      "stdout. Where another\nmethod is more accurate or faster, the table marks it PEER WINS. One thread is "
      "used\nwhatever --threads is, but two for the measured sweep of a million and for a column of\nwhole "
      "commands, and all for the simulated campaigns of `bench fit`. `bench model` includes\n"
      "SUNDIALS and Boost.odeint where the program was built with them (CMake option\nTRIBOTRACK_PEERS), "
      "else it names what is missing." +
          peers_of_this_build());
  command.callback([options, &context] { run_bench(*options, context); });
}

}  // namespace tribotrack::apps
