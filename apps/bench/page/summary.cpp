#include "apps/bench/page/summary.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "apps/bench/tables/columns.h"
#include "apps/bench/timing/paired_timing.h"
#include "apps/bench/verdicts/verdicts.h"

namespace tribotrack::bench {
namespace {

constexpr const char* kDash = "–";

std::string time_text(double seconds) {
  if (seconds < 1e-3) return fmt::format("{:.3g} µs", 1e6 * seconds);
  return seconds < 1 ? fmt::format("{:.3g} ms", 1e3 * seconds) : fmt::format("{:.3g} s", seconds);
}

/// The rows in groups of one key, in their order.
template <class Row, class Key>
auto grouped(const std::vector<Row>& rows, Key key) {
  std::vector<std::pair<std::decay_t<std::invoke_result_t<Key, const Row&>>, std::vector<Row>>> groups;
  for (const Row& row : rows) {
    const auto name = std::invoke(key, row);
    if (groups.empty() || groups.back().first != name) groups.push_back({name, {}});
    groups.back().second.push_back(row);
  }
  return groups;
}

template <class Row, class Value>
double median_of(const std::vector<Row>& rows, Value value) {
  std::vector<double> values;
  values.reserve(rows.size());
  for (const Row& row : rows) values.push_back(std::invoke(value, row));
  return median(values);
}

/// The fastest that reaches the error that is compared, every cycle integrated; nullptr where none does.
const ModelBenchRow* fastest(const std::vector<ModelBenchRow>& rows, bool ours) {
  const ModelBenchRow* best = nullptr;
  for (const ModelBenchRow& row : rows)
    if (row.ours == ours && !row.leaves_out && row.finished && row.error <= kComparedError &&
        (!best || row.time < best->time))
      best = &row;
  return best;
}

std::string faster_text(double ours, double peer) {
  return peer < ours ? fmt::format("PEER WINS x{:.2f}", ours / peer)
                     : fmt::format("tribotrack faster x{:.2f}", peer / ours);
}

void add_model(const ModelResults& model, std::vector<SummaryLine>& lines) {
  for (const auto& [scene, rows] : grouped(model.rows, &ModelBenchRow::scene)) {
    const ModelBenchRow *own = fastest(rows, true), *peer = fastest(rows, false);
    const auto settings = std::ranges::count(rows, false, &ModelBenchRow::ours);
    const auto wins = std::ranges::count_if(rows, [](const ModelBenchRow& row) { return peer_wins(row); });
    SummaryLine line{fmt::format("model, {}: end point to {:g} nm", scene, 1e9 * kComparedError), kDash,
                     kDash, ""};
    if (own) line.ours = time_text(own->time);
    if (peer) line.peer = fmt::format("{} ({})", time_text(peer->time), peer->method);
    line.who = own && peer ? faster_text(own->time, peer->time)
               : own       ? "tribotrack alone arrives"
                           : "PEER WINS";
    if (!own && !peer) line.who = "nobody arrives";
    line.who += fmt::format("; of all settings of others {} of {} win", wins, settings);
    lines.push_back(line);
  }
  const auto held = std::ranges::count(model.extremes, true, &ModelExtremeRow::held);
  lines.push_back({"stiff and extreme cases: laws that hold",
                   fmt::format("{} of {}", held, model.extremes.size()), kDash,
                   held == static_cast<long>(model.extremes.size()) ? "all held" : "BROKEN: see the table"});
  if (!model.batches.empty()) {
    const BatchBenchRow& whole = model.batches.back();
    lines.push_back({fmt::format("model, {} scenarios at once, two threads", whole.scenarios),
                     time_text(whole.million), kDash, "no other method was run"});
  }
}

/// Of the peers the one with the least median error over the bound.
void add_tracking(const std::vector<VisionBenchRow>& all, std::vector<SummaryLine>& lines) {
  const auto over_bound = [](const VisionBenchRow& row) { return row.rms / row.bound; };
  for (const auto& [scene, rows] : grouped(all, &VisionBenchRow::scene)) {
    std::string own, best;
    double least = std::numeric_limits<double>::infinity(), own_error = 0;
    std::vector<std::string> seen;
    for (const VisionBenchRow& row : rows) {
      if (std::ranges::find(seen, row.method) != seen.end()) continue;
      seen.push_back(row.method);
      std::vector<VisionBenchRow> of_method;
      std::ranges::copy_if(rows, std::back_inserter(of_method),
                           [&](const VisionBenchRow& other) { return other.method == row.method; });
      const double error = median_of(of_method, over_bound);
      const std::string text =
          fmt::format("x{:.2f}, {} a frame", error, time_text(median_of(of_method, &VisionBenchRow::time)));
      if (row.ours && own.empty()) {
        own = text;
        own_error = error;
      } else if (!row.ours && error < least) {
        best = fmt::format("{} ({})", text, row.method);
        least = error;
      }
    }
    const auto peers = std::ranges::count(rows, false, &VisionBenchRow::ours);
    const auto closer = std::ranges::count_if(rows, [](const VisionBenchRow& row) { return peer_wins(row); });
    const auto faster = std::ranges::count_if(
        rows, [](const VisionBenchRow& row) { return !row.ours && row.time_over_ours < 1; });
    lines.push_back(
        {fmt::format("tracking, {}: rms error over the limit", scene), own, best.empty() ? kDash : best,
         fmt::format("{}; peers closer in {} of {}, faster in {}",
                     least < own_error ? fmt::format("PEER WINS x{:.2f}", own_error / least)
                                       : fmt::format("tribotrack closer x{:.2f}", least / own_error),
                     closer, peers, faster)});
  }
}

void add_limits(const std::vector<VisionLimitRow>& rows, std::vector<SummaryLine>& lines) {
  if (rows.empty()) return;
  std::vector<double> over_bound, standardised, halves;
  for (const VisionLimitRow& row : rows) {
    over_bound.push_back(row.rms / row.bound);
    standardised.push_back(row.standardised);
    if (const auto ratio = row.audit.halves()) halves.push_back(*ratio);
  }
  const auto span = [](const std::vector<double>& values) {
    return fmt::format("{:.3f}, from {:.3f} to {:.3f}", median(values), std::ranges::min(values),
                       std::ranges::max(values));
  };
  lines.push_back({fmt::format("tracking, {} recordings: rms error over the limit", rows.size()),
                   span(over_bound), "1 is the limit", kDash});
  lines.push_back(
      {"tracking: true errors over their standard deviations", span(standardised), "1 is right", kDash});
  if (!halves.empty())
    lines.push_back({"audit: halves of the disc, seen over predicted", span(halves), "1 is right", kDash});
}

void add_commands(const std::vector<WholeCommandRow>& all, std::vector<SummaryLine>& lines) {
  std::vector<WholeCommandRow> rows;
  std::ranges::copy_if(all, std::back_inserter(rows),
                       [](const WholeCommandRow& row) { return !row.layers_off; });
  if (rows.empty()) return;
  const auto faster =
      std::ranges::count_if(rows, [](const WholeCommandRow& r) { return r.matching < r.cpu; });
  const auto closer =
      std::ranges::count_if(rows, [](const WholeCommandRow& r) { return r.matching_rms < r.rms; });
  lines.push_back({fmt::format("whole commands, {} recordings: median CPU time and rms error", rows.size()),
                   fmt::format("{}, {:.4f} px", time_text(median_of(rows, &WholeCommandRow::cpu)),
                               median_of(rows, &WholeCommandRow::rms)),
                   fmt::format("{}, {:.4f} px (windowed cv::matchTemplate)",
                               time_text(median_of(rows, &WholeCommandRow::matching)),
                               median_of(rows, &WholeCommandRow::matching_rms)),
                   fmt::format("{} faster in {}, closer in {} of {}",
                               faster + closer > 0 ? "PEER WINS:" : "peer", faster, closer, rows.size())});
}

void add_fit(const FitResults& fit, std::vector<SummaryLine>& lines) {
  for (const auto& [data, rows] : grouped(fit.rows, &FitBenchRow::data)) {
    const FitBenchRow *own = soonest_of_ours(data, rows), *peer = nullptr;
    for (const FitBenchRow& row : rows)
      if (!row.ours && row.converged == row.campaigns && row.off_minimum <= kSameMinimum &&
          (!peer || row.time < peer->time))
        peer = &row;
    SummaryLine line{fmt::format("fit to {}: time to the minimum", data), kDash, kDash, "nobody arrives"};
    if (own) line.ours = fmt::format("{} ({})", time_text(own->time), own->method);
    if (peer) line.peer = fmt::format("{} ({})", time_text(peer->time), peer->method);
    if (own && peer) line.who = faster_text(own->time, peer->time);
    if (own && !peer) line.who = "tribotrack alone arrives";
    if (!own && peer) line.who = "PEER WINS";
    lines.push_back(line);
  }
}

void add_coverage(const std::vector<CoverageRow>& rows, std::vector<SummaryLine>& lines) {
  long covered = 0, usable = 0, off = 0;
  for (const CoverageRow& row : rows) {
    covered += row.covered;
    usable += row.usable;
    off += row.usable > 0 && (row.share_ci95().high < 0.95 || row.share_ci95().low > 0.95);
  }
  if (usable > 0)
    lines.push_back({"95 % intervals that hold the truth",
                     fmt::format("{:.1f} % of {}", 100 * double(covered) / double(usable), usable),
                     "95 % is right",
                     fmt::format("of {} kinds {} lie beyond chance (1 in 20 would)", rows.size(), off)});
}

}  // namespace

std::vector<SummaryLine> summary_of(const BenchResults& results) {
  std::vector<SummaryLine> lines;
  if (results.model) add_model(*results.model, lines);
  if (results.vision) {
    add_tracking(results.vision->rows, lines);
    add_limits(results.vision->limits, lines);
  }
  if (results.commands) add_commands(*results.commands, lines);
  if (results.fit) add_fit(*results.fit, lines);
  if (results.coverage) add_coverage(results.coverage->rows, lines);
  return lines;
}

std::string summary_table(const std::vector<SummaryLine>& lines) {
  const Columns<SummaryLine> columns{
      {"", &SummaryLine::measured, "what was measured", "<"},
      {"", &SummaryLine::ours, "tribotrack", "<"},
      {"", &SummaryLine::peer, "the best of others", "<"},
      {"", &SummaryLine::who, "who wins where", "<"},
  };
  return columns.html("bench_summary", lines);
}

}  // namespace tribotrack::bench
