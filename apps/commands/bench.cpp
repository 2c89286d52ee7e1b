// tribotrack bench: error against run time, ours and others', the stiff and extreme cases, what omissions
// save, the claims of the source paper, and what work costs as it grows.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "apps/bench/page/page.h"
#include "apps/bench/peers/library_peers.h"
#include "apps/bench/tables/campaigns.h"
#include "apps/commands/command.h"
#include "apps/figures/printed.h"
#include "apps/files/meta_file.h"
#include "apps/files/parts/work_part.h"
#include "apps/json/json_place.h"
#include "apps/page/assets/embedded_assets.h"
#include "apps/program/errors.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/text/output_file.h"
#include "apps/usage/wrong_usage.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

struct BenchOptions {
  std::string what;
  std::string output;
  bool quick = false, full = false;
  std::optional<int> campaigns;
  std::vector<int> frames;
  std::vector<double> diameters;
  std::string keep;
  std::string figures, part;
  std::vector<std::string> join;
  bool json = false;
};

/// Carries out a benchmark with its progress on the terminal.
template <class Options, class Measure>
auto measured(const std::string& name, Options options, const Context& context, Measure measure) {
  Progress progress(name, context.quiet);
  options.progress = [&](int done, int total) { progress.update(done, total); };
  return measure(options);
}

class Bench {
 public:
  Bench(const BenchOptions& options, const Context& context)
      : options_(options),
        context_(context),
        part_(options.part.empty() ? WorkPart{} : work_part(options.part)),
        folder_(options.output),
        here_(bench::circumstances_here()) {
    create_folder(folder_);
    require_writable({{folder_ / "bench.json"}, {folder_ / "bench.html"}});
    if (options_.figures.empty()) return;
    create_folder(options_.figures);
    require_writable(printed_files({}, options_.figures).front());
  }

  void model() {
    bench::ModelBenchOptions options;
    options.quick = options_.quick;
    options.peers = bench::peers::all_peers();
    for (const std::string& library : here_.missing)
      say(context_.quiet,
          fmt::format("bench model: this build was made without {}; its solvers are not compared", library));
    bench::ClaimOptions claims;
    claims.quick = options_.quick;
    bench::ModelResults found;
    found.rows = measured("bench model", options, context_, bench::bench_model);
    found.extremes = measured("bench model, extremes", options, context_, bench::bench_model_extremes);
    found.omissions = measured("bench model, plan", options, context_, bench::bench_plan);
    found.batches = measured("bench model, many at once", options, context_, bench::bench_batch);
    found.claims = measured("bench model, claims", claims, context_, bench::paper_claims);
    const auto broken = std::ranges::count(found.extremes, false, &bench::ModelExtremeRow::held);
    counts_["model"] = {{"rows", found.rows.size()},
                        {"extremes", found.extremes.size()},
                        {"laws_broken", broken},
                        {"omissions", found.omissions.size()},
                        {"batches", found.batches.size()}};
    for (const auto& claim : found.claims) counts_["model"]["claims"][claim.name] = to_string(claim.verdict);
    if (broken > 0)
      say(context_.quiet, fmt::format("bench model: {} of the extreme cases break their law", broken));
    results_.model = std::move(found);
  }

  void vision() {
    bench::VisionBenchOptions options;
    options.quick = options_.quick;
    const auto grid = options_.quick ? bench::quick_limit_options() : bench::VisionLimitOptions();
    const auto recordings = options_.quick ? bench::quick_decoding_options() : bench::VisionDecodingOptions();
    bench::VisionResults found;
    found.rows = measured("bench vision", options, context_, bench::bench_vision);
    found.limits = measured("bench vision, limit", grid, context_, bench::bench_limit);
    found.decodings = measured("bench vision, recordings", recordings, context_, bench::bench_decoding);
    counts_["vision"] = {{"rows", found.rows.size()},
                         {"limit_rows", found.limits.size()},
                         {"decoding_rows", found.decodings.size()}};
    results_.vision = std::move(found);
  }

  void commands() {
    bench::WholeCommandOptions options;
    if (options_.quick) options = bench::quick_whole_command_options();
    options.program = fs::read_symlink("/proc/self/exe");
    if (!options_.frames.empty()) options.frames = options_.frames;
    if (!options_.diameters.empty()) options.diameters = options_.diameters;
    options.keep = options_.keep;
    results_.commands = measured("bench commands", options, context_, bench::bench_whole_commands);
    counts_["commands"] = {{"rows", results_.commands->size()}};
  }

  void fit() {
    bench::FitBenchOptions options;
    options.quick = options_.quick;
    bench::FitResults found;
    found.rows = measured("bench fit", options, context_, bench::bench_fit);
    bench::FilmingOptions filming;
    if (options_.quick) filming = bench::quick_filming_options();
    filming.threads = threads_to_use(context_);
    if (options_.campaigns) filming.campaigns = std::min(filming.campaigns, *options_.campaigns);
    found.filmed = measured("bench fit, filming", filming, context_, bench::filming);
    counts_["fit"]["rows"] = found.rows.size();
    results_.fit = std::move(found);
  }

  void coverage() {
    bench::CoverageOptions campaigns;
    if (options_.quick) campaigns.campaigns = 2;
    if (options_.campaigns) campaigns.campaigns = *options_.campaigns;
    campaigns.of_trajectories = std::min(campaigns.campaigns, options_.quick ? 1 : campaigns.of_trajectories);
    campaigns.part = part_.number;
    campaigns.parts = part_.of;
    campaigns.threads = threads_to_use(context_);
    cover({measured("bench coverage", campaigns, context_, bench::judged_campaigns),
           {},
           campaigns.campaigns,
           campaigns.seed});
  }

  /// The whole from its parts.
  void joined_coverage() {
    std::vector<fs::path> parts;
    for (const std::string& folder : options_.join) parts.push_back(fs::path(folder) / kCampaigns);
    require_writable({{folder_ / kCampaigns}}, parts);
    const JoinedTable joined = joined_tables(parts, "bench coverage");
    try {
      const JsonPlace configuration = JsonPlace{joined.meta, ""}.at("configuration");
      cover({bench::read_campaigns(parts.front(), joined.text),
             {},
             configuration.at("campaigns").integer(),
             static_cast<std::uint64_t>(configuration.at("seed").whole())});
    } catch (const WrongContent& wrong) {
      throw InvalidInput(fmt::format("{}.meta.json: {}", parts.front().string(), wrong.what()));
    }
  }

  void scale() {
    bench::ScaleOptions options;
    if (options_.quick) options = bench::quick_scale_options();
    if (options_.full) options = bench::full_scale_options();
    options.program = fs::read_symlink("/proc/self/exe");
    options.folder = options_.keep;
    results_.scale = measured("bench scale", options, context_, bench::bench_scale);
    counts_["scale"] = {{"rows", results_.scale->size()}};
    for (const bench::ScaleExponent& found : bench::exponents(*results_.scale))
      counts_["scale"]["exponents"][found.series][found.cost] = {{"exponent", found.exponent},
                                                                 {"sd", found.sd}};
  }

  /// Files and tables once everything is measured: an interrupted bench leaves nothing half done.
  void finish() {
    here_.load_after = bench::load_average();
    const auto tables = tables_of(results_, here_.missing);
    for (const bench::BenchTable& table : tables) {
      const fs::path csv = folder_ / (table.name + ".csv");
      write(csv, table.csv);
      write_meta(csv);
      say(context_.quiet, table.text);
    }
    if (results_.coverage) write_campaigns(*results_.coverage);
    write(folder_ / "bench.html", page_of(results_, tables, here_));
    Json json = json_of(here_);
    json["results"] = counts_;
    write(folder_ / "bench.json", text_of(json));
    if (options_.json) print_text(text_of(json));
    if (!options_.figures.empty()) print(bench::figures_of(tables));
  }

 private:
  static constexpr const char* kCampaigns = "bench_fit_campaigns.csv";

  void cover(bench::CoverageResults found) {
    found.rows = bench::coverage_of(found.judged);
    counts_["fit"]["coverage"] = {{"campaigns", found.campaigns}, {"seed", found.seed}};
    results_.coverage = std::move(found);
  }
  void write_campaigns(const bench::CoverageResults& found) const {
    const fs::path csv = folder_ / kCampaigns;
    write(csv, csv_of(found.judged));
    MetaFile meta;
    meta.command = "bench";
    meta.configuration = {{"what", "coverage"}, {"campaigns", found.campaigns}, {"seed", found.seed}};
    if (part_.of > 1) meta.configuration["part"] = json_of(part_, found.judged.size());
    meta.write_beside(csv);
  }
  void write(const fs::path& file, const std::string& text) const {
    write_file(file, text);
    if (!options_.json) apps::print("{}\n", file.string());
  }
  void write_meta(const fs::path& result) const {
    MetaFile meta;
    meta.command = "bench";
    meta.configuration = {{"what", options_.what}, {"quick", options_.quick}};
    meta.more["reference"] = json_of(here_).at("reference");
    meta.write_beside(result);
  }
  void print(const std::vector<Figure>& figures) const {
    print_figures(figures, options_.figures, embedded_assets().figures_py);
    say(context_.quiet, fmt::format("{}: {} figures written", options_.figures, figures.size()));
  }

  const BenchOptions& options_;
  const Context& context_;
  WorkPart part_;
  fs::path folder_;
  bench::Circumstances here_;
  bench::BenchResults results_;
  Json counts_ = Json::object();
};

void run_bench(const BenchOptions& options, const Context& context) {
  if (options.what != "coverage" && (!options.part.empty() || !options.join.empty()))
    throw UsageError(fmt::format("--part and --join are for `bench coverage`, not `bench {}`", options.what));
  Bench measurements(options, context);
  const bool all = options.what == "all";
  if (all || options.what == "model") measurements.model();
  const bool vision = all || options.what == "vision";
  if (vision) measurements.vision();
  if (vision || options.what == "commands") measurements.commands();
  const bool fit = all || options.what == "fit";
  if (fit) measurements.fit();
  if (!options.join.empty())
    measurements.joined_coverage();
  else if (fit || options.what == "coverage")
    measurements.coverage();
  if (options.what == "scale") measurements.scale();
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
          "cores); coverage: only how often intervals hold; scale: whole commands as recordings, frames, "
          "runs, points and scenarios grow, with the "
          "exponent of each cost (a quarter of an hour; not part of `all`); all")
      ->check(one_of({"model", "vision", "commands", "fit", "coverage", "scale", "all"}))
      ->required();
  command
      .add_option(
          "-o,--output", options->output,
          "Folder for bench_model.csv, bench_model_extremes.csv, bench_model_plan.csv, "
          "bench_model_batch.csv, bench_model_claims.csv, bench_vision.csv, bench_vision_limit.csv, "
          "bench_vision_audit.csv, bench_vision_decoding.csv, bench_commands.csv, bench_fit.csv, "
          "bench_fit_filming.csv, bench_fit_coverage.csv, bench_fit_campaigns.csv (what each simulated "
          "campaign's intervals hold), bench_scale.csv, bench_scale_exponents.csv, bench.html (all of it on "
          "one "
          "page, with figures of error against run "
          "time) and bench.json (CPU, compiler flags, how the references were made, solvers this build "
          "lacks)")
      ->type_name("DIR")
      ->required();
  command
      .add_option("--campaigns", options->campaigns,
                  "fit, coverage: simulated campaigns of each design and noise level (default 200, of tracks "
                  "at most 50): "
                  "2000 tell a coverage to 1 %")
      ->check(whole_number(1, 1'000'000));
  CLI::Option* part =
      command.add_option("--part", options->part,
                         "coverage: part K of N of the campaigns only, for a job of its own; see --join");
  part->type_name("K/N");
  command
      .add_option(
          "--join", options->join,
          "coverage: instead of simulating, join the parts, the folders that --part wrote: tables are "
          "byte for byte those of the whole")
      ->type_name("DIR...")
      ->excludes(part);
  CLI::Option* frames =
      command
          .add_option(
              "--frames", options->frames,
              "commands: lengths of the recordings (default 100,500,2000). Pictures are 1280 x 800, beyond "
              "5000 frames 640 x 400, of which 20000 take 5 GB uncompressed")
          ->delimiter(',')
          ->check(whole_number(24, 1'000'000))
          ->type_name("N,N,...");
  CLI::Option* diameters =
      command.add_option("--diameters", options->diameters, "commands: of the disc, px (default 60,120,300)")
          ->delimiter(',')
          ->check(whole_number(24, 300))
          ->type_name("D,D,...");
  command
      .add_option("--keep", options->keep,
                  "commands, scale: keep the recordings in this folder, and use those that are there "
                  "(default: temporary ones, removed)")
      ->type_name("DIR");
  command
      .add_option("--figures", options->figures,
                  "Folder for the page's figures as SVG and PDF, 84 and 174 mm wide, drawn by matplotlib "
                  "(Debian's python3-matplotlib), with their numbers as CSV and the script that drew them")
      ->type_name("DIR");
  CLI::Option* full = command.add_flag(
      "--full", options->full,
      "scale: to 1000 recordings, 1e6 frames and points, 3000 runs, 1e7 scenarios (half an hour, 20 GB)");
  command
      .add_flag("--quick", options->quick,
                "Few and short cases, seconds in all: a check that it works, not a measurement")
      ->excludes(frames)
      ->excludes(diameters)
      ->excludes(full);
  command.add_flag("--json", options->json, "Print bench.json instead of the names of the files");
  add_common(
      command, context,
      "  tribotrack bench model -o bench\n\nTables go to stderr, the names of the files written to "
      "stdout; bench.html shows all of\nit. Where another method is more accurate or faster, the table marks "
      "it PEER WINS. One thread is "
      "used\nwhatever --threads is, but two for the measured sweep of a million and for a column of\nwhole "
      "commands, and all for the simulated campaigns of `bench fit`. `bench model` includes\n"
      "SUNDIALS and Boost.odeint where the program was built with them (CMake option\nTRIBOTRACK_PEERS), "
      "else it names what is missing." +
          peers_of_this_build());
  command.callback([options, &context] { run_bench(*options, context); });
}

}  // namespace tribotrack::apps
