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

enum class Numbers {
  as_drawn,  ///< to a tenth of a pixel: a third of the bytes
  left_out,  ///< they stand in the CSV
};

/// Keys are the names in figure.h; what has its default is left out. Axes must be settled.
Json json_of(const Figure& figure, Numbers numbers);

}  // namespace tribotrack::apps
