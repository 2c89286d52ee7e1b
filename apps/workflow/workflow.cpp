#include "apps/workflow/workflow.h"

#include <fmt/format.h>

#include <system_error>
#include <vector>

#include "apps/files/run_folder.h"
#include "apps/page/assets/embedded_assets.h"
#include "apps/program/errors.h"
#include "apps/recording/recording.h"
#include "apps/text/input_file.h"
#include "apps/text/json.h"
#include "apps/text/output_file.h"
#include "apps/text/strict_toml.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

/// This very program: another version would write other bytes.
std::string program() {
  std::error_code unknown;
  const fs::path path = fs::read_symlink("/proc/self/exe", unknown);
  return unknown ? "tribotrack" : path.string();
}

/// The folder paths are relative to, seen from the output folder: where that was given as a relative path,
/// the two may be moved together.
std::string folder_of_paths(const fs::path& output) {
  const fs::path here = fs::current_path();
  return (output.is_absolute() ? here : fs::relative(here, output)).string();
}

/// What a job depends on: a folder of pictures stands for those in it, whatever their number.
std::string dependence(const fs::path& recording) {
  return vision::is_number_pattern(recording) ? (recording.parent_path() / ".").string() : recording.string();
}

Json json_of(const Campaign& campaign, const CampaignRun& run) {
  Json json = {{"name", run.name}, {"inputs", Json::array()}};
  if (run.track) {
    json["inputs"].push_back(run.track->string());
    json["finished_track"] = true;
    return json;
  }
  json["inputs"].push_back(dependence(*run.video));
  if (run.scope) json["inputs"].push_back(run.scope->string());
  const Recording recording = recording_of(campaign, run);
  if (recording.camera.calibration) json["inputs"].push_back(recording.camera.calibration->string());
  json["settings"] = hash_of_text(TRIBOTRACK_VERSION + settings_of(recording).dump());
  return json;
}

Json json_of(const WorkflowOptions& options, const Campaign& campaign) {
  Json json = {{"program", program()},
               {"version", TRIBOTRACK_VERSION},
               {"folder", folder_of_paths(options.output)},
               {"campaign", options.campaign},
               {"output", options.output.string()},
               {"threads", options.threads}};
  // With these texts, word for word, the list of runs below is current.
  json["made_from"] = {{campaign.file.string(), read_text(campaign.file)}};
  for (const fs::path& table : campaign.data.tables) json["made_from"][table.string()] = read_text(table);
  json["runs"] = Json::array();
  for (const CampaignRun& run : campaign.runs)
    if (run.has_track()) json["runs"].push_back(json_of(campaign, run));
  return json;
}

}  // namespace

void write_workflow(const WorkflowOptions& options, const Campaign& campaign) {
  create_folder(options.output);
  if (const auto writer = writer_of(RunFolder{options.output}))
    throw InvalidInput("{}: a run is writing there: {}; wait until it has finished, or give another folder",
                       options.output.string(), *writer);
  const fs::path slurm = options.output / "slurm";
  create_folder(slurm / "logs");  // Slurm does not make it
  const std::vector<std::pair<fs::path, std::string>> files = {
      {options.output / "workflow.json", text_of(json_of(options, campaign))},
      {options.output / "Snakefile", std::string(embedded_assets().snakefile)},
      {slurm / "config.yaml", std::string(embedded_assets().slurm_profile)},
      {slurm / "slurm_status.sh", std::string(embedded_assets().slurm_status)}};
  std::vector<Output> outputs;
  for (const auto& [path, text] : files) outputs.push_back({path});
  require_writable(outputs, campaign.input_files());
  for (const auto& [path, text] : files) write_file(path, text);
  fs::permissions(slurm / "slurm_status.sh",
                  fs::perms::owner_exec | fs::perms::group_exec | fs::perms::others_exec,
                  fs::perm_options::add);
}

std::string workflow_commands(const WorkflowOptions& options) {
  const std::string snakefile = (options.output / "Snakefile").string();
  return fmt::format(
      "on this machine:  snakemake -s {0} -k --cores all\n"
      "on Slurm:         snakemake -s {0} --profile {1}\n"
      "without N recordings that cannot be used, when all others are tracked:\n"
      "                  the same with --config allow_missing=N\n",
      snakefile, (options.output / "slurm").string());
}

}  // namespace tribotrack::apps
