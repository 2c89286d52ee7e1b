#include "apps/report/report.h"

#include "apps/report/data/from_files.h"
#include "apps/report/page/page.h"

namespace tribotrack::apps {

std::string report_page(const ReportInput& input) {
  return page_of(data_from_results(input));
}

ReportOfFolder report_of(const RunFolder& folder) {
  const ReportData data = data_from_files(folder);
  return {page_of(data), data.missing};
}

}  // namespace tribotrack::apps
