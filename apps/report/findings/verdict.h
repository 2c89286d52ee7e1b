// The estimates and whether to trust them, in one paragraph.
#pragma once

#include <string>

#include "apps/report/data/data.h"

namespace tribotrack::apps {

enum class Trust { usable, with_care, do_not_use, no_fit };

struct Verdict {
  Trust trust = Trust::no_fit;
  std::string heading;    ///< "Can be used", "Use with care: ...", ...
  std::string paragraph;  ///< HTML
};

/// From convergence, identifiability, agreement, failed runs and warnings.
Verdict verdict_of(const ReportData& data);

/// Where chi-squared per degree of freedom lies with probability 0.99 under the model
/// (fit::expected_reduced_chi2), as "0.42 to 1.88", rounded to its width.
std::string expected_chi2_text(int dof);

}  // namespace tribotrack::apps
