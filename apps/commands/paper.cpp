// tribotrack paper: the source paper's figures and claims, computed again.
#include <fmt/format.h>

#include <memory>

#include "apps/commands/command.h"
#include "apps/figures/figure_csv.h"
#include "apps/files/run_folder.h"
#include "apps/page/assets/embedded_assets.h"
#include "apps/paper/paper.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/text/input_file.h"
#include "apps/text/output_file.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

constexpr const char* kFigures[] = {"figure3", "figure4", "figure5",  "figure6",
                                    "figure7", "figure9", "figure10", "figure11"};

/// The scenarios by their hashes.
MetaFile meta_of_paper() {
  MetaFile meta;
  meta.command = "paper";
  for (const EmbeddedScenario& scenario : paper_scenarios())
    meta.configuration["scenarios"][std::string(scenario.name)] = hash_of_text(scenario.toml);
  return meta;
}

Paper compute(const Context& context) {
  Progress progress("paper", context.quiet, "claims");
  return {paper_figures(context),
          paper_claims(context, [&progress](int done, int total) { progress.update(done, total); })};
}

void run_paper(const fs::path& folder, bool json, const Context& context) {
  create_folder(folder);
  const fs::path page = folder / "paper.html", claims = folder / "claims.csv";
  std::vector<Output> outputs = {{page}, {claims}};
  for (const char* figure : kFigures) outputs.push_back({folder / fmt::format("{}.csv", figure)});
  require_writable(outputs);

  const Paper paper = compute(context);
  const MetaFile meta = meta_of_paper();
  for (const Figure& figure : paper.figures)
    write_result(folder / (figure.id + ".csv"), csv_of(figure), meta);
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
  command
      .add_option("-o,--output", *output,
                  "Folder for paper.html (self-contained: figures 3 to 7 and the model's side of 9 to 11, "
                  "beside each what the paper claims, what is found and the verdict), claims.csv and the "
                  "figures' numbers, figure3.csv to figure11.csv")
      ->type_name("DIR")
      ->required();
  auto json = std::make_shared<bool>(false);
  command.add_flag("--json", *json, "Print claims and verdicts as one JSON object");
  add_common(command, context, "  tribotrack paper -o paper");
  command.callback([output, json, &context] { run_paper(*output, *json, context); });
}

}  // namespace tribotrack::apps
