#include "fit/checks/agreement.h"

#include <cmath>

#include "fit/tools/statistics.h"
#include "fit/tools/thresholds.h"

namespace tribotrack::fit {

const char* to_string(Agreement agreement) {
  switch (agreement) {
    case Agreement::good:
      return "good";
    case Agreement::only_with_scatter:
      return "only with scatter";
    case Agreement::poor:
      return "poor";
    case Agreement::too_good:
      return "too good";
    case Agreement::unknown:
      break;
  }
  return "unknown";
}

Interval expected_reduced_chi2(int dof) {
  if (dof < 1) return {};
  return {internal::chi2_quantile(0.005, dof) / dof, internal::chi2_quantile(0.995, dof) / dof};
}

namespace internal {

Agreement agreement(const FitResult& result) {
  const bool surprised = result.p_value < kSurprise;
  if (surprised && result.scatter > 0) return Agreement::only_with_scatter;
  if (!std::isfinite(result.chi2) || result.dof < 1) return Agreement::unknown;
  if (surprised) return Agreement::poor;
  if (result.chi2 / result.dof < expected_reduced_chi2(result.dof).low) return Agreement::too_good;
  return Agreement::good;
}

}  // namespace internal
}  // namespace tribotrack::fit
