#include "apps/report/report.h"

#include "apps/report/data/from_files.h"
#include "apps/report/page/page.h"

namespace tribotrack::apps {

std::string report_page(const ReportInput& input) {
  return page_of(data_from_results(input));
}

std::string report_page_of(const RunFolder& folder) {
  return page_of(data_from_files(folder));
}

}  // namespace tribotrack::apps
