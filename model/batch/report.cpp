#include <cstdio>

#include "model/batch.h"

namespace tribotrack::model {

const char* to_string(BatchStatus status) {
  switch (status) {
    case BatchStatus::done:
      return "done";
    case BatchStatus::invalid:
      return "invalid";
    case BatchStatus::no_steady_motion:
      return "no steady motion";
    case BatchStatus::too_long:
      return "too long";
    case BatchStatus::failed:
      break;
  }
  return "failed";
}

const char* to_string(ScalarReason reason) {
  switch (reason) {
    case ScalarReason::not_asked:
      return "lanes not asked for";
    case ScalarReason::drive:
      return "drive not circular";
    case ScalarReason::constant_friction:
      return "constant friction";
    case ScalarReason::start:
      return "starts on a steady motion";
    case ScalarReason::marginal:
      return "starts or stops near the threshold of friction";
    case ScalarReason::many_steps:
      return "creeps for long";
    case ScalarReason::weak_friction:
      return "friction so weak that cycles hardly contract";
    case ScalarReason::no_convergence:
      break;
  }
  return "Newton's method does not settle";
}

std::string BatchSummary::brief_report() const {
  char text[200];
  const double all = solutions > 0 ? 100.0 / static_cast<double>(solutions) : 0;
  const double used =
      lane_slots > 0 ? 100 * static_cast<double>(lane_steps) / static_cast<double>(lane_slots) : 0;
  std::snprintf(text, sizeof text,
                "%zu solutions, %.1f %% in lanes (which were %.0f %% full), %zu not solved", solutions,
                all * static_cast<double>(in_lanes), used, not_solved);
  return text;
}

std::string BatchSummary::full_report() const {
  std::string text = brief_report();
  for (std::size_t k = 0; k < kScalarReasons; ++k) {
    if (by_scalar[k] == 0) continue;
    char line[120];
    std::snprintf(line, sizeof line, "\n  one at a time: %zu (%s)", by_scalar[k],
                  to_string(static_cast<ScalarReason>(k)));
    text += line;
  }
  return text;
}

}  // namespace tribotrack::model
