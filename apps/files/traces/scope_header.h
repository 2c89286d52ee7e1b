// The lines above the numbers of an oscilloscope's file.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/text/csv_table.h"

namespace tribotrack::apps {

struct ScopeHeader {
  std::string layout;
  std::vector<std::string> names;         ///< "CH1", ...
  std::vector<std::size_t> columns;       ///< of the channels
  std::vector<double> volt;               ///< V to one of each channel's unit
  std::optional<std::size_t> time;        ///< its column; empty: values alone
  double second = 1;                      ///< s to one of the time's unit
  std::optional<double> start, interval;  ///< s, as the settings have them
  bool at_first_numbers = false;          ///< the table stands at the first line of numbers already
};

/// Goes past the header, to the first line of numbers. Throws InvalidInput where the layout is not known.
ScopeHeader read_scope_header(CsvTable& table);

}  // namespace tribotrack::apps
