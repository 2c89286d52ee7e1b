// The key `NAME_sd` beside a given quantity `NAME`.
#pragma once

#include <optional>
#include <string>

#include "apps/text/strict_toml.h"

namespace tribotrack::apps {

/// Does a reader act on the sds that only a fit can count? Where it does not, their keys are unknown to it.
enum class WithSd { no, yes };

/// The sd in the unit of the quantity; an angle's may be a text as the angle itself. Fails where the quantity
/// itself is not given in this table, or the sd is not above 0: an exact value has none.
std::optional<double> read_sd(StrictTable& table, const std::string& quantity);

}  // namespace tribotrack::apps
