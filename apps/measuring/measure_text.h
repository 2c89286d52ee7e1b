// What commands find, as text for people: with units, rounded to the standard deviation.
#pragma once

#include <string>

#include "apps/files/traces/scope_file.h"
#include "apps/text/json.h"

namespace tribotrack::apps {

/// Of the object that `measure --json` or `probe --json` prints every quantity, a line each. `within` begins
/// their names.
std::string measurement_text(const Json& json, const std::string& within = "");

// What an oscilloscope's file holds, and what to write into [scope].

/// Layout, sampling and channels, each with what it looks like, and the lines of [scope] that say so: what
/// `probe trace.csv` prints.
std::string trace_text(const ScopeFile& trace);
Json trace_json(const ScopeFile& trace);

}  // namespace tribotrack::apps
