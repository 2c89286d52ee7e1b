#include <fmt/format.h>

#include <algorithm>

#include "apps/bench/figures/figures.h"
#include "apps/page/text.h"

namespace tribotrack::bench {

using namespace apps;

namespace {

constexpr double kNominal = 95;      // %
constexpr double kSpread = 0.7;      // of a design's place, taken by its parameters
constexpr double kPerDesign = 0.05;  // height over width
constexpr double kAxes = 0.12;

template <class Value>
std::size_t place_in(std::vector<Value>& values, const Value& value) {
  const auto found = std::ranges::find(values, value);
  if (found != values.end()) return static_cast<std::size_t>(found - values.begin());
  values.push_back(value);
  return values.size() - 1;
}

}  // namespace

Figure coverage_figure(const std::vector<CoverageRow>& rows) {
  std::vector<Design> designs;
  std::vector<NoiseLevel> levels;
  std::vector<std::string> parameters, named;
  double lowest = kNominal;
  for (const CoverageRow& row : rows) {
    place_in(designs, row.design);
    place_in(levels, row.level);
    place_in(parameters, row.parameter);
    if (row.usable > 0) lowest = std::min(lowest, 100 * row.share_ci95().low);
  }
  FigureAxis y{.low = -0.5, .high = static_cast<double>(designs.size()) - 0.5};
  for (std::size_t k = 0; k < designs.size(); ++k) {  // the first on top
    y.ticks.push_back(static_cast<double>(designs.size() - 1 - k));
    y.labels.emplace_back(to_string(designs[k]));
  }
  Figure figure{.id = "coverage", .title = "How many 95 % intervals hold the truth", .caption = {}};
  figure.columns = static_cast<int>(std::max<std::size_t>(1, levels.size()));
  for (std::size_t level = 0; level < levels.size(); ++level) {
    FigurePanel panel{
        .x = {.title = "intervals that hold the truth, %", .low = std::max(0.0, lowest - 1), .high = 101},
        .y = y,
        .title = fmt::format("{} noise", to_string(levels[level]))};
    panel.y.shown = level == 0;
    panel.series.push_back({.mark = Mark::line,
                            .name = "nominal 95 %",
                            .x = {kNominal, kNominal},
                            .y = {y.low, y.high},
                            .colour = kInk,
                            .in_legend = level == 0,
                            .dashed = true});
    for (std::size_t p = 0; p < parameters.size(); ++p) {
      Series share{.name = plain_symbol(parameters[p]), .colour = static_cast<int>(p)};
      Series range{.mark = Mark::line, .name = share.name, .colour = share.colour};
      const double offset =
          kSpread * (0.5 - (static_cast<double>(p) + 0.5) / static_cast<double>(parameters.size()));
      for (const CoverageRow& row : rows) {
        if (row.level != levels[level] || row.parameter != parameters[p] || row.usable == 0) continue;
        const double place = y.ticks[place_in(designs, row.design)] + offset;
        share.x.push_back(100 * row.share());
        share.y.push_back(place);
        share.notes.push_back(
            fmt::format("{}, {}: {} of {}", to_string(row.design), share.name, row.covered, row.usable));
        for (const double end : {100 * row.share_ci95().low, 100 * row.share_ci95().high, kNone}) {
          range.x.push_back(end);
          range.y.push_back(place);
        }
      }
      if (share.x.empty()) continue;
      share.in_legend = std::ranges::find(named, share.name) == named.end();
      if (share.in_legend) named.push_back(share.name);
      panel.series.push_back(std::move(range));
      panel.series.push_back(std::move(share));
    }
    figure.panels.push_back(std::move(panel));
  }
  figure.height = kAxes + kPerDesign * static_cast<double>(designs.size());
  figure.caption =
      "Lines are the 95 % ranges (Clopper and Pearson) of what so many simulated campaigns can tell; of them "
      "one in "
      "twenty misses the nominal share even if the intervals are right. Counted are campaigns whose fit "
      "calls itself usable.";
  figure.alternative =
      "For each design of campaigns and parameter the share of intervals that hold the truth, with its "
      "binomial range";
  return figure;
}

}  // namespace tribotrack::bench
