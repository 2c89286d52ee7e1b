// The results of a campaign as tables: for other programs and as text to paste, which `run` leaves beside the
// page, and on the page itself.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "apps/page/page.h"
#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// One row a run, all digits: number, name, conditions, alpha and v measured and modelled with residuals in
/// sd, platform, frames, failure.
std::string runs_csv(const ReportData& data);

/// One row a parameter, all digits: estimate, sd, the 95 % intervals, then correlations with the others.
std::string parameters_csv(const ReportData& data);

/// One block to paste: verdict, values, goodness of fit, budget, warnings, methods.
std::string report_text(const ReportData& data);

// The report page's section on whether the model is right: HTML that reads the same without scripts and on
// paper.

/// Chi-squared, residuals, runs that contradict the others, the friction models
/// compared, and the analyses that were not needed. Each only where there is something to show.
PageSection check_section(const ReportData& data, const std::vector<Figure>& figures);

// The uncertainty budget as a table with a bar in every cell.

/// Sources down, parameters across: what each source gives to each parameter's standard deviation, the bar as
/// long as its share of it. Empty without a budget.
std::string budget_table(const fit::FitResult& fit);

// How the findings are quoted: the same words on the page and in text.

/// "0.09952 to 0.10073", or "... or ..." where the interval is in pieces.
std::string quoted_interval(const fit::ParameterEstimate& parameter);

/// "Part 6 × 0.8 mm; 14 runs; filmed 2021-03-04; tribotrack VERSION": what is known of it.
std::string subtitle_of(const ReportData& data);

// The estimates and whether to trust them, in one paragraph of plain text.

struct Verdict {
  const char* style = "none";  ///< of the page: good, care, bad; none: no fit
  std::string heading;         ///< "Can be used", "Use with care: ...", ...
  std::string paragraph;
};

/// The fit's own verdict and reasons, and failed runs.
Verdict verdict_of(const ReportData& data);

/// What the values rest on, a line each: friction law, what was taken as exact, defaults that are felt.
std::vector<std::string> assumptions(const ReportData& data);

/// Where chi-squared per degree of freedom lies with probability 0.99 under the model
/// (fit::expected_reduced_chi2), as "0.42 to 1.88", rounded to its width.
std::string expected_chi2_text(int dof, double noise_dof = std::numeric_limits<double>::infinity());

// The sentence of methods that a paper needs, and what to cite, as plain text.

/// What was done to how many runs, with the program's version; only what was done here.
std::string methods_text(const ReportData& data);

std::vector<std::string> sources_to_cite(const ReportData& data);

}  // namespace tribotrack::apps
