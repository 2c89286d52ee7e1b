// Figures as JSON, for the scripts that draw them.
#pragma once

#include "apps/figures/figure.h"
#include "apps/text/json.h"

namespace tribotrack::apps {

const char* word_for(Mark mark);  ///< "points", "line", "band", "bars", "text"

enum class Numbers {
  as_drawn,  ///< to a tenth of a pixel: a third of the bytes
  left_out,  ///< they stand in the CSV
};

/// Keys are the names in figure.h; what has its default is left out. Axes must be settled.
Json json_of(const Figure& figure, Numbers numbers);

}  // namespace tribotrack::apps
