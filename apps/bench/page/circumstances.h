// What the figures of a benchmark depend on: machine, build and references.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "apps/text/json.h"

namespace tribotrack::bench {

/// Of the last 1, 5 and 15 minutes; empty where the system does not tell.
using LoadAverage = std::optional<std::array<double, 3>>;
LoadAverage load_average();

struct Circumstances {
  std::string program, cpu, compiler, compiler_flags;
  std::string clock;  ///< what was timed, and how
  std::string model_reference, vision_reference, fit_reference;
  std::string peers;                 ///< where they come from
  std::vector<std::string> missing;  ///< libraries this build was made without
  LoadAverage load_before, load_after;
};

/// Of this process now; the load afterwards is still to come.
Circumstances circumstances_here();

/// Keys as in bench.json.
apps::Json json_of(const Circumstances& circumstances);

}  // namespace tribotrack::bench
