// The numbers behind a figure.
#pragma once

#include <string>

#include "apps/figures/figure.h"
#include "apps/text/json.h"

namespace tribotrack::apps {

/// One row a point: panel and series by their number from 1, the mark, the series' name, x, y, sd, y_high,
/// note. All digits; an empty cell for what is not there.
std::string csv_of(const Figure& figure);

// Figures as JSON, for the scripts that draw them.

const char* word_for(Mark mark);  ///< "points", "line", "band", "bars", "text"

/// Keys are the names in figure.h; what has its default is left out, numbers are good to a tenth of a
/// pixel. Axes must be settled.
Json json_of(const Figure& figure);

}  // namespace tribotrack::apps
