#include "apps/figures/figure_csv.h"

#include <fmt/format.h>

#include "apps/figures/figure_json.h"
#include "apps/text/csv_table.h"
#include "apps/text/number_text.h"

namespace tribotrack::apps {
namespace {

std::string at(const std::vector<double>& values, std::size_t i) {
  return i < values.size() ? exact(values[i]) : std::string();
}

}  // namespace

std::string csv_of(const Figure& figure) {
  std::string csv = "panel,series,mark,name,x,y,sd,y_high,note\n";
  for (std::size_t p = 0; p < figure.panels.size(); ++p)
    for (std::size_t s = 0; s < figure.panels[p].series.size(); ++s) {
      const Series& series = figure.panels[p].series[s];
      for (std::size_t i = 0; i < series.x.size(); ++i)
        csv += fmt::format("{},{},{},{},{},{},{},{},{}\n", p + 1, s + 1, word_for(series.mark),
                           csv_cell(series.name), at(series.x, i), at(series.y, i), at(series.sd, i),
                           at(series.y_high, i), i < series.notes.size() ? csv_cell(series.notes[i]) : "");
    }
  return csv;
}

}  // namespace tribotrack::apps
