// Oscilloscope CSV files as labs have them: what stands above the numbers, and the numbers.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/text/input_file.h"

namespace tribotrack::apps {

/// Channels of one trace. Sample n was taken at start_s + n * increment_s: printed time columns are rounded,
/// so they give the two numbers and nothing else.
struct ScopeFile {
  Input input;
  std::string layout = "time and channels";  ///< or without such columns "Rigol DS1000Z", ...
  double start_s = 0, increment_s = 0;
  std::vector<std::string> names;             ///< "CH1", ...
  std::vector<std::vector<double>> channels;  ///< V
};

/// Is this a table at all that may be a trace: a text file that ends in .csv, .txt, .tsv or .dat?
bool may_be_trace(const std::filesystem::path& path);

/// Layouts, as the instruments write them:
///   Rigol DS1000Z       `X,CH1,...,Start,Increment`, values under a line of units with both numbers
///   Rigol MSO5000       `CH1(V),t0 = ..., tInc = ...`, values alone; or `Time(s),CH1(V),...`
///   Rigol DS1102E       `Time,X(CH1),...`
///   Tektronix TDS       three columns with the settings, then time and value; one channel a file
///   Tektronix           lines of settings from `Model,...` on, then `TIME,CH1,...`
///   Keysight            `x-axis,1,2` over `second,Volt,Volt`
///   Siglent             lines of settings, or `Source,CH1`, then `Second,Volt`
///   PicoScope           `Time,Channel A,...` over `(ms),(V),(mV)`
///   Digilent            lines of `#`, then `Time (s),Channel 1 (V)`
///   any other           a time and channels, with units or not: `Time,CH1,CH2`, `t (ms);CH1 (mV)`
/// separated as apps/text/csv_table.h finds it; units of time and voltage are taken from either line, s and V
/// where none is named. Where times stand only in a column, increment = (last - first) /
/// (rows - 1), or the sampling interval that the settings give where the times agree; the times must be even
/// but for their rounding. Throws InvalidInput naming file and line.
ScopeFile read_scope_file(const std::filesystem::path& path);

/// The channels of a second file of the same trace behind those of the first. Throws InvalidInput unless both
/// have the same samples.
void add_channels(const ScopeFile& second, ScopeFile& first);

}  // namespace tribotrack::apps
