#include "apps/paper/paper.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "apps/paper/figures.h"
#include "apps/text/number_text.h"

namespace tribotrack::apps {
namespace {

/// A cell that may hold commas.
std::string quoted(const std::string& text) {
  return "\"" + text + "\"";
}

}  // namespace

Paper paper_of(const bench::ClaimOptions& options) {
  return {paper_figures(options.threads), bench::paper_claims(options)};
}

std::string claims_csv(const Paper& paper) {
  std::string csv = "figure,place,claim,verdict,quantity,conditions,value,unit,statement,finding\n";
  for (const bench::PaperClaim& claim : paper.claims)
    csv += fmt::format("{},{},{},{},{},{},{},{},{},{}\n", claim.figure, quoted(claim.place),
                       quoted(claim.name), to_string(claim.verdict), quoted(claim.deciding.quantity),
                       quoted(claim.deciding.conditions), exact(claim.deciding.value), claim.deciding.unit,
                       quoted(claim.statement), quoted(claim.finding));
  return csv;
}

std::string verdicts_text(const std::vector<bench::PaperClaim>& claims) {
  using bench::Verdict;
  std::vector<std::string> parts;
  for (const auto& [verdict, words] : {std::pair{Verdict::exact, "exact"},
                                       {Verdict::holds, "hold"},
                                       {Verdict::holds_in_part, "hold in part"},
                                       {Verdict::refuted, "refuted"}})
    parts.push_back(
        fmt::format("{} {}", std::ranges::count(claims, verdict, &bench::PaperClaim::verdict), words));
  return fmt::format("{}", fmt::join(parts, ", "));
}

}  // namespace tribotrack::apps
