#include "apps/bench/verdicts/verdicts.h"

#include <fmt/format.h>

namespace tribotrack::bench {
namespace {

bool arrives(const FitBenchRow& row) {
  return row.converged == row.campaigns && row.off_minimum <= kSameMinimum;
}

}  // namespace

bool peer_wins(const ModelBenchRow& row) {
  return !row.ours && row.finished && row.time_over_ours < 1;
}

bool peer_wins(const VisionBenchRow& row) {
  return !row.ours && row.rms_over_ours < 1;
}

const FitBenchRow* soonest_of_ours(const std::string& data, const std::vector<FitBenchRow>& rows) {
  const FitBenchRow* soonest = nullptr;
  for (const FitBenchRow& row : rows)
    if (row.ours && row.data == data && arrives(row) && (!soonest || row.time < soonest->time))
      soonest = &row;
  return soonest;
}

bool peer_wins(const FitBenchRow& row, const std::vector<FitBenchRow>& rows) {
  if (row.ours || !arrives(row)) return false;
  const FitBenchRow* own = soonest_of_ours(row.data, rows);
  return !own || row.time < own->time;
}

std::string verdict(const ModelBenchRow& row) {
  if (row.ours) return "";
  if (!row.finished) return "gave up";
  if (row.time_over_ours == 0) return "PEER WINS: more accurate than any of ours";
  return row.time_over_ours < 1 ? fmt::format("PEER WINS x{:.2f}", 1 / row.time_over_ours)
                                : fmt::format("ours faster x{:.1f}", row.time_over_ours);
}

std::string verdict(const VisionBenchRow& row) {
  if (row.ours) return "";
  const bool faster = row.time_over_ours < 1;
  if (peer_wins(row)) return faster ? "PEER WINS both" : "PEER WINS on error";
  return faster ? "peer faster" : "";
}

std::string verdict(const FitBenchRow& row, const std::vector<FitBenchRow>& rows) {
  if (row.ours) return "";
  if (!arrives(row)) return "does not arrive";
  const FitBenchRow* own = soonest_of_ours(row.data, rows);
  if (!own) return "PEER WINS: none of ours arrives";
  return row.time < own->time ? fmt::format("PEER WINS x{:.2f}", own->time / row.time)
                              : fmt::format("ours faster x{:.1f}", row.time / own->time);
}

}  // namespace tribotrack::bench
