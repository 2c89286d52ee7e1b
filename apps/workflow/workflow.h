// A campaign as jobs for Snakemake: one for each recording, then the fit, then the report. The engine
// schedules, resumes and talks to clusters; the program only says what depends on what.
#pragma once

#include <filesystem>
#include <string>

#include "apps/files/campaign/campaign.h"

namespace tribotrack::apps {

struct WorkflowOptions {
  std::string campaign;          ///< as the user names it
  std::filesystem::path output;  ///< the folder that `run` would fill
  int threads = 1;               ///< of each job
};

/// Writes into the output folder, which is made where it is missing:
///   Snakefile       the rules, the same for every campaign
///   workflow.json   this campaign's runs, their recordings and how they are tracked
///   slurm/          a profile of Snakemake for Slurm
/// Jobs work in the folder that this process works in, on paths as the campaign has them, so that their
/// results hold the bytes that `run` writes there. Throws InvalidInput, also while a `run` is writing into
/// the folder.
void write_workflow(const WorkflowOptions& options, const Campaign& campaign);

/// The commands that carry it out, for people.
std::string workflow_commands(const WorkflowOptions& options);

}  // namespace tribotrack::apps
