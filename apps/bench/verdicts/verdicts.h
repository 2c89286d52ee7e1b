// Who wins: a row of a benchmark against our own rows beside it.
#pragma once

#include <string>
#include <vector>

#include "apps/bench/fit/bench.h"
#include "apps/bench/model/bench.h"
#include "apps/bench/vision/bench.h"

namespace tribotrack::bench {

/// Faster than our fastest setting that is as accurate, every cycle integrated, or more accurate than any.
bool peer_wins(const ModelBenchRow& row);
/// Closer to the truth, however long either takes.
bool peer_wins(const VisionBenchRow& row);
/// On the same data no farther than kSameMinimum from the minimum in all of its campaigns, and there sooner
/// than any of ours. `rows`: all of them.
bool peer_wins(const FitBenchRow& row, const std::vector<FitBenchRow>& rows);

/// As close to the minimum as matters, in standard deviations.
inline constexpr double kSameMinimum = 1e-3;

/// Of ours the row that arrives soonest on these data; nullptr where none does.
const FitBenchRow* soonest_of_ours(const std::string& data, const std::vector<FitBenchRow>& rows);

// In words, "PEER WINS ..." where it does; empty for our own rows.
std::string verdict(const ModelBenchRow& row);
std::string verdict(const VisionBenchRow& row);
std::string verdict(const FitBenchRow& row, const std::vector<FitBenchRow>& rows);

}  // namespace tribotrack::bench
