#include "apps/report/page/methods.h"

#include "apps/page/text.h"
#include "apps/report/findings/methods_text.h"

namespace tribotrack::apps {

std::string methods_html(const ReportData& data) {
  std::string html = "<p>" + sentence_html(methods_text(data)) + "</p>\n<h3>To cite</h3>\n<ul>";
  for (const std::string& source : sources_to_cite(data)) html += "<li>" + escape_html(source) + "</li>";
  return html + "</ul>\n";
}

}  // namespace tribotrack::apps
