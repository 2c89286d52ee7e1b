#include "apps/pipeline/part_by_part.h"

#include <fmt/format.h>

#include "apps/program/streams.h"
#include "apps/text/output_file.h"

namespace tribotrack::apps {

namespace {

constexpr const char* kStopped =
    "stopped: finished recordings are kept, and the same command goes on from there";

void carry_out(CampaignRunner& runner) {
  runner.take_folder();
  const LastWords stopped(kStopped);
  runner.measure_runs();
  runner.share_scale();
  runner.refuse_if_none_is_left();
  runner.share_conditions();
  runner.fit_all();
  runner.report();
  runner.write_log();
}

/// At the end those go again that are still empty.
struct MadeFolders {
  std::vector<std::filesystem::path> folders;
  ~MadeFolders() {
    std::error_code in_use;
    for (auto folder = folders.rbegin(); folder != folders.rend(); ++folder)
      std::filesystem::remove(*folder, in_use);
  }
};

std::string csv_rows(const std::string& part, const Json& fit) {
  std::string rows;
  for (const auto& [name, p] : fit.at("parameters").items())
    rows += fmt::format("{},{},{},{},{},{}\n", part, name, p.at("estimate").dump(), p.at("sd").dump(),
                        p.at("ci95").at(0).dump(), p.at("ci95").at(1).dump());
  return rows;
}

}  // namespace

void run_campaign(const Campaign& campaign, const RunnerOptions& options, bool plan_only, Context& context) {
  CampaignRunner runner(options, campaign, context);
  if (plan_only) return runner.print_plan();
  carry_out(runner);
  runner.print_result();
}

void run_part_by_part(const Campaign& campaign, const RunnerOptions& options, bool plan_only,
                      Context& context) {
  const std::filesystem::path root = options.output;
  const std::filesystem::path table = root / "parts.csv";
  MadeFolders made;
  if (!plan_only) {
    made.folders = create_folder(root);
    require_writable({{table}}, campaign.input_files());
  }
  Json fits = Json::object();
  std::string rows = "part,parameter,estimate,sd,ci95_low,ci95_high\n";
  for (const Campaign& part : campaigns_by_part(campaign)) {
    const std::string& name = part.part.name;
    RunnerOptions here = options;
    here.output = (root / name).string();
    CampaignRunner runner(here, part, context);
    if (!options.json) print("{}part {}\n", fits.empty() ? "" : "\n", name);
    if (plan_only) {
      runner.print_plan();
      fits[name] = nullptr;
      continue;
    }
    try {
      carry_out(runner);
    } catch (const InvalidInput& error) {
      complain(fmt::format("part {}: {}", name, error.what()));
      context.exit_code = kQualityGate;
      continue;
    }
    if (options.json)
      runner.say_what_happened();
    else
      runner.print_result();
    fits[name] = runner.fit().json;
    rows += csv_rows(name, runner.fit().json);
  }
  if (plan_only) return;
  if (fits.empty())
    throw InvalidInput(
        fmt::format("{}: none of its parts can be fitted; each is named above", options.campaign));
  write_file(table, rows);
  if (options.json) return print_text(text_of({{"parts", fits}}));
  print("\nparts  {}\n", table.string());
}

}  // namespace tribotrack::apps
