// alpha and v measured elsewhere, as a spreadsheet holds them: one line a measurement.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/text/input_file.h"

namespace tribotrack::apps {

/// One line, SI. An empty cell, and a column that is not there, has no value.
struct AlphaVLine {
  std::string place;  ///< "alpha_v.csv:7"
  std::string name;   ///< from the column `name`; empty where there is none
  double phi = 0, dtau = 0, alpha = 0, v = 0;
  std::optional<double> alpha_sd, v_sd;
  std::optional<double> phi_sd, dtau_sd;
  std::optional<double> amplitude, amplitude_sd, angular_frequency, angular_frequency_sd;
  std::optional<double> start_phase, start_phase_sd;
  std::optional<int> cycles;
};

struct AlphaVTable {
  Input input;
  std::vector<AlphaVLine> lines;
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
/// Throws InvalidInput with file, line and column.
AlphaVTable read_alpha_v_table(const std::filesystem::path& path);

}  // namespace tribotrack::apps
