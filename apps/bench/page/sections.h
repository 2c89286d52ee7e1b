// The sections of the benchmarks' page, each only where its part was run.
#pragma once

#include <vector>

#include "apps/bench/page/circumstances.h"
#include "apps/bench/tables/results.h"
#include "apps/page/page.h"

namespace tribotrack::bench {

/// In the page's order, without the circumstances.
std::vector<apps::PageSection> sections_of(const BenchResults& results,
                                           const std::vector<BenchTable>& tables);

apps::PageSection section_of(const Circumstances& circumstances);

}  // namespace tribotrack::bench
