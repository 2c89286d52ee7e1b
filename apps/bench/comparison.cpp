#include "apps/bench/comparison.h"

#include <fmt/format.h>

#include <algorithm>

#include "apps/bench/timing.h"

namespace tribotrack::bench {

namespace {

const ComparedRow* set_against(const ComparedRow& peer, const std::vector<ComparedRow>& rows) {
  const ComparedRow *fastest = nullptr, *closest = nullptr;
  for (const ComparedRow& row : rows) {
    if (row.whose != Whose::ours || row.scene != peer.scene || row.group != peer.group || !row.arrived)
      continue;
    if (!closest || row.error < closest->error) closest = &row;
    if (row.error <= peer.error * (1 + kSameError) && (!fastest || row.time < fastest->time)) fastest = &row;
  }
  return fastest ? fastest : closest;
}

bool more_accurate(const ComparedRow& peer) {
  return peer.error_over_ours < 1 - kSameError;
}

/// One method over the scenes of a group: in each its fastest row that reaches the target.
struct InGroup {
  std::string method;
  std::vector<double> errors = {}, times = {};
  double error() const { return median(errors); }
  double time() const { return median(times); }
};

std::vector<InGroup> methods_in(const Comparison& comparison, const std::string& group, Whose whose) {
  std::vector<InGroup> methods;
  std::vector<std::string> seen;
  for (const ComparedRow& row : comparison.rows) {
    if (row.group != group || row.whose != whose) continue;
    const std::string key = row.scene + "\n" + row.method;
    if (std::ranges::find(seen, key) != seen.end()) continue;
    seen.push_back(key);
    const ComparedRow* best = nullptr;
    for (const ComparedRow& other : comparison.rows)
      if (other.group == group && other.scene == row.scene && other.method == row.method && other.arrived &&
          (comparison.target == 0 || other.error <= comparison.target) && (!best || other.time < best->time))
        best = &other;
    if (!best) continue;
    auto method = std::ranges::find(methods, row.method, &InGroup::method);
    if (method == methods.end()) method = methods.insert(methods.end(), {row.method});
    method->errors.push_back(best->error);
    method->times.push_back(best->time);
  }
  return methods;
}

/// Who arrives in most scenes; among these the fastest, or without a target the most accurate.
const InGroup* best_of(const std::vector<InGroup>& methods, bool by_time) {
  const auto worse = [by_time](const InGroup& a, const InGroup& b) {
    if (a.times.size() != b.times.size()) return a.times.size() < b.times.size();
    return by_time ? a.time() > b.time() : a.error() > b.error();
  };
  return methods.empty() ? nullptr : &*std::ranges::max_element(methods, worse);
}

std::string times_text(double ratio) {
  return fmt::format("x{:.2f}", ratio < 1 ? 1 / ratio : ratio);
}

std::string who_wins(const InGroup* own, const InGroup* peer, bool by_time) {
  if (!own && !peer) return "nobody arrives";
  if (!peer) return "tribotrack alone arrives";
  if (!own) return "PEER WINS: it alone arrives";
  const double time = peer->time() / own->time(), error = peer->error() / own->error();
  const std::string faster = (time < 1 ? "PEER WINS on time " : "tribotrack faster ") + times_text(time);
  if (by_time) return faster;
  return (error < 1 ? "PEER WINS on error " : "tribotrack closer ") + times_text(error) + ", " + faster;
}

}  // namespace

void set_against_ours(Comparison& comparison) {
  for (ComparedRow& row : comparison.rows)
    if (const ComparedRow* own =
            row.whose == Whose::peer && row.arrived ? set_against(row, comparison.rows) : nullptr) {
      row.error_over_ours = row.error / own->error;
      row.time_over_ours = row.time / own->time;
    }
}

bool peer_wins(const ComparedRow& row) {
  return more_accurate(row) || row.time_over_ours < 1;
}

std::string verdict(const ComparedRow& row) {
  if (row.whose != Whose::peer) return "";
  if (!row.arrived) return "does not arrive";
  if (more_accurate(row))
    return fmt::format("PEER WINS on error: x{:.2g} of our least, time x{:.2g}", row.error_over_ours,
                       row.time_over_ours);
  if (row.time_over_ours < 1)
    return fmt::format("PEER WINS on time x{:.2f}, error x{:.2g}", 1 / row.time_over_ours,
                       row.error_over_ours);
  return row.time_over_ours >= 1 ? fmt::format("ours faster x{:.1f}", row.time_over_ours)
                                 : "ours did not arrive";
}

std::string time_text(double seconds) {
  if (seconds < 1e-3) return fmt::format("{:.3g} us", 1e6 * seconds);
  return seconds < 1 ? fmt::format("{:.3g} ms", 1e3 * seconds) : fmt::format("{:.3g} s", seconds);
}

std::vector<SummaryLine> summary_of(const Comparison& comparison) {
  std::vector<SummaryLine> lines;
  std::vector<std::string> groups;
  for (const ComparedRow& row : comparison.rows)
    if (std::ranges::find(groups, row.group) == groups.end()) groups.push_back(row.group);
  const bool by_time = comparison.target > 0;
  for (const std::string& group : groups) {
    const auto ours = methods_in(comparison, group, Whose::ours),
               peers = methods_in(comparison, group, Whose::peer);
    const InGroup *own = best_of(ours, by_time), *peer = best_of(peers, by_time);
    const auto told = [&](const InGroup* method) {
      return method ? fmt::format("{}, {:.3g} {} ({})", time_text(method->time()), method->error(),
                                  comparison.unit, method->method)
                    : "-";
    };
    const auto of_group = [&](const ComparedRow& row) {
      return row.group == group && row.whose == Whose::peer;
    };
    const auto wins = std::ranges::count_if(
        comparison.rows, [&](const ComparedRow& row) { return of_group(row) && peer_wins(row); });
    lines.push_back({fmt::format("{}, {}: {}, {}", comparison.name, group, comparison.time, comparison.error),
                     told(own), told(peer),
                     fmt::format("{}; rows of others that win: {} of {}", who_wins(own, peer, by_time), wins,
                                 std::ranges::count_if(comparison.rows, of_group))});
  }
  return lines;
}

}  // namespace tribotrack::bench
