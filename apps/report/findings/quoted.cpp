#include "apps/report/findings/quoted.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "apps/page/text.h"

namespace tribotrack::apps {

std::string quoted_interval(const ReportParameter& parameter) {
  if (parameter.pieces.empty()) return interval_text(parameter.ci95.low, parameter.ci95.high, parameter.sd);
  std::string text;
  for (const ReportInterval& piece : parameter.pieces)
    text += (text.empty() ? "" : " or ") + interval_text(piece.low, piece.high, parameter.sd);
  return text;
}

std::string subtitle_of(const ReportData& data) {
  std::vector<std::string> facts;
  if (!data.part.empty()) facts.push_back("part " + data.part);
  if (!data.runs.empty()) {
    const auto filmed =
        std::ranges::count_if(data.runs, [](const ReportRun& run) { return !run.video.empty(); });
    facts.push_back(fmt::format("{} run{}{}", data.runs.size(), data.runs.size() == 1 ? "" : "s",
                                filmed > 0 && static_cast<std::size_t>(filmed) < data.runs.size()
                                    ? fmt::format(", {} of them filmed", filmed)
                                    : ""));
  }
  if (!data.filmed.empty()) facts.push_back("filmed " + data.filmed);
  facts.push_back(data.program_version.empty() ? "tribotrack" : "tribotrack " + data.program_version);
  return fmt::format("{}", fmt::join(facts, " · "));
}

}  // namespace tribotrack::apps
