// The numbers behind a figure.
#pragma once

#include <string>

#include "apps/figures/figure.h"

namespace tribotrack::apps {

/// One row a point: panel and series by their number from 1, the mark, the series' name, x, y, sd, y_high,
/// note. All digits; an empty cell for what is not there.
std::string csv_of(const Figure& figure);

}  // namespace tribotrack::apps
