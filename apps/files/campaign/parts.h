// Several parts in one campaign: each has its own runs, fit and results.
#pragma once

#include <string>
#include <vector>

#include "apps/files/campaign/campaign.h"
#include "apps/text/strict_toml.h"

namespace tribotrack::apps {

/// [part], or [[part]] for several. One [[part]] is a [part]. Throws InvalidInput.
void read_part_or_parts(StrictTable& top, Campaign& campaign);

/// Refuses runs whose part is not known, or where it is not known where a part lies.
void check_parts(const Campaign& campaign);

}  // namespace tribotrack::apps
