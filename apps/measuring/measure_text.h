// What commands find, as text for people: with units, rounded to the standard deviation.
#pragma once

#include <string>

#include "apps/text/json.h"

namespace tribotrack::apps {

/// Of the object that `measure --json` or `probe --json` prints every quantity, a line each. `within` begins
/// their names.
std::string measurement_text(const Json& json, const std::string& within = "");

}  // namespace tribotrack::apps
