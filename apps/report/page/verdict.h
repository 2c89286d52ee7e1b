// What was found and whether to believe it, in one paragraph.
#pragma once

#include <string>

#include "apps/report/data/data.h"

namespace tribotrack::apps {

enum class Trust { usable, with_care, do_not_use, no_fit };

struct Verdict {
  Trust trust = Trust::no_fit;
  std::string heading;    ///< "Can be used", "Use with care", ...
  std::string paragraph;  ///< HTML
};

/// From convergence, identifiability, chi-square, failed runs and warnings. data.verdict, where given,
/// replaces the paragraph's wording but not the heading.
Verdict verdict_in_words(const ReportData& data);

/// The range chi-square per degree of freedom stays in 99 times out of 100 when the model is right and the
/// errors are honest. Wilson and Hilferty's approximation: the lower end is good to 0.02, the upper to 1 %,
/// at any dof. NaN for dof < 1.
ReportInterval expected_reduced_chi2(int dof);

/// The same as "0.42 to 1.88", with digits enough to see its width at any dof.
std::string expected_chi2_words(int dof);

}  // namespace tribotrack::apps
