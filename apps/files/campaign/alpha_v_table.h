// alpha and v measured elsewhere, as a spreadsheet holds them: one line a measurement.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "apps/files/campaign/campaign.h"
#include "apps/text/input_file.h"

namespace tribotrack::apps {

struct AlphaVTable {
  Input input;
  std::vector<CampaignRun> runs;   ///< of each line; an sd that its line does not have is empty
  std::vector<std::string> notes;  ///< sentences: columns that are not used, lines left out
};

/// Columns by name (apps/text/csv_table.h), in any order and case, a unit in each name:
///   phi, dtau, alpha       rad or deg; a cell may also be "pi/3" or "60deg"
///   v                      mm/s, m/s, cm/s, um/s
///   amplitude              mm, m, um            where the lines differ in it, as the next ones
///   angular_frequency, w, omega, frequency, f    rad/s or Hz (taken as 2 pi f)
///   start_phase            rad or deg
///   cycles, name           without a unit
/// and the sd of each that has a unit (0 of a condition: exact). phi, dtau, alpha and v must be there. Cells
/// separated by `,`, `;` or tabs, decimal commas with the last two. The runs.csv of `run` is such a table:
/// its failed runs and free slides are left out, and where a run has no alpha its dx_mm and dy_mm give it.
/// `otherwise`: start and cycles of lines that do not say. Throws InvalidInput with file, line and column.
AlphaVTable read_alpha_v_table(const std::filesystem::path& path, const FitSection& otherwise);

}  // namespace tribotrack::apps
