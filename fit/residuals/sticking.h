// Runs in which nothing moves.
#pragma once

#include <optional>
#include <string>

#include "fit/problem.h"

namespace tribotrack::fit::internal {

/// Where no driven run moved beyond its error (chi^2 of the displacement with 99.9 %): the bound on mu that
/// follows and the remedy, as a sentence. nullopt where something moved, or where nothing was driven.
std::optional<std::string> stuck_throughout(const Problem& problem);

}  // namespace tribotrack::fit::internal
