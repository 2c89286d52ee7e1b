// Oscilloscope CSV files as labs have them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "apps/text/input_file.h"

namespace tribotrack::apps {

/// Channels of one trace. Sample n was taken at start_s + n * increment_s: printed time columns are rounded,
/// so they give the two numbers and nothing else.
struct ScopeFile {
  Input input;
  std::string layout;  ///< "Rigol DS1000Z", "Rigol DS1102E", "Rigol MSO5000"
  double start_s = 0, increment_s = 0;
  std::vector<std::string> names;             ///< "CH1", ...
  std::vector<std::vector<double>> channels;  ///< V
};

/// Reads the layouts of Rigol's DS1000Z (`X,CH1,...,Start,Increment`), DS1102E (`Time,X(CH1),...`) and
/// MSO5000 (`Time(s),CH1(V),...`, or values alone under `CH1(V),t0 = ..., tInc = ...`), with commas, or with
/// semicolons and decimal commas. Where only a time column says the times, increment = (last - first) /
/// (rows - 1). Throws InvalidInput naming file and line.
ScopeFile read_scope_file(const std::filesystem::path& path);

}  // namespace tribotrack::apps
