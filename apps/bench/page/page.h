// All that one call of `tribotrack bench` measured, on one page.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "apps/bench/page/circumstances.h"
#include "apps/bench/tables/results.h"

namespace tribotrack::bench {

/// How to read the page: three sentences of plain text.
extern const std::array<const char*, 3> kReadingGuide;

/// A self-contained HTML page. `tables`: tables_of(results). Parts that were not run are named and left out.
std::string page_of(const BenchResults& results, const std::vector<BenchTable>& tables,
                    const Circumstances& circumstances);

/// The figures on it, with settled axes.
std::vector<apps::Figure> figures_of(const std::vector<BenchTable>& tables);

}  // namespace tribotrack::bench
