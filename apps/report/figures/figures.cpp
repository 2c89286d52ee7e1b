#include "apps/report/figures/figures.h"

#include <fmt/format.h>

#include <iterator>

#include "apps/figures/axes.h"
#include "apps/report/figures/dependence.h"
#include "apps/report/figures/parameters.h"
#include "apps/report/figures/residuals.h"
#include "apps/report/figures/run.h"
#include "apps/report/figures/slides.h"
#include "apps/report/figures/trajectories.h"

namespace tribotrack::apps {

std::vector<Figure> campaign_figures(const ReportData& data) {
  std::vector<Figure> figures;
  const auto add = [&](std::vector<Figure> more) { std::ranges::move(more, std::back_inserter(figures)); };
  add(dependence_figures(data));
  add(trajectory_figures(data));
  add(residual_figures(data));
  add(parameter_figures(data));
  add(slide_figures(data));
  for (Figure& figure : figures) settle_axes(figure);
  return figures;
}

std::vector<Figure> run_figures(const ReportData& data, std::size_t index) {
  std::vector<Figure> figures = figures_of_run(data, index);
  for (Figure& figure : figures) settle_axes(figure);
  return figures;
}

std::string run_label(const ReportData& data, std::size_t index) {
  return fmt::format("{} {}", index + 1, data.runs[index].name);
}

}  // namespace tribotrack::apps
