#include "apps/report/page/page.h"

#include <iterator>
#include <utility>

#include "apps/page/page.h"
#include "apps/report/figures/figures.h"
#include "apps/report/findings/quoted.h"
#include "apps/report/page/check.h"
#include "apps/report/page/first.h"
#include "apps/report/page/parameters/next.h"
#include "apps/report/page/results.h"
#include "apps/report/page/runs.h"
#include "apps/report/page/sections.h"

namespace tribotrack::apps {

std::string page_of(const ReportData& data) {
  Page page{.name = data.title, .title = data.title, .subtitle = subtitle_of(data)};
  page.figures = campaign_figures(data);
  std::vector<std::vector<Figure>> of_runs;
  for (std::size_t i = 0; i < data.runs.size(); ++i) of_runs.push_back(run_figures(data, i));

  const std::vector<Figure>& figures = page.figures;
  page.first = first_screen(data, figures);
  const std::string shown = first_figure(figures);
  for (PageSection section :
       {dependence_section(data, figures, shown), parameter_section(data, figures),
        check_section(data, figures), budget_section(data, figures), next_section(data),
        slide_section(data, figures, shown), run_section(data), citing_section(data), picture_section(data),
        detail_section(data, of_runs), audit_section(data), plan_section(data), provenance_section(data)})
    if (!section.html.empty()) page.sections.push_back(std::move(section));
  for (std::vector<Figure>& more : of_runs) std::ranges::move(more, std::back_inserter(page.figures));
  return html_of(std::move(page));
}

}  // namespace tribotrack::apps
