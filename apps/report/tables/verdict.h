// How the findings are quoted: the same words on the page and in text.
#pragma once

#include <string>
#include <vector>

#include "apps/report/data/data.h"

namespace tribotrack::apps {

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
