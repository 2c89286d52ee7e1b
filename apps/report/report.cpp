#include "apps/report/report.h"

#include "apps/report/data/from_files.h"
#include "apps/report/figures/figures.h"
#include "apps/report/page/page.h"
#include "apps/report/tables/tables.h"

namespace tribotrack::apps {
namespace {

Report report_of(const ReportData& data) {
  return {page_of(data),     runs_csv(data),         parameters_csv(data),
          report_text(data), campaign_figures(data), data.missing};
}

}  // namespace

Report report_of(const ReportInput& input) {
  return report_of(data_from_results(input));
}

Report report_of(const RunFolder& folder) {
  return report_of(data_from_files(folder));
}

}  // namespace tribotrack::apps
