// The fit as text.
#include <cmath>
#include <cstdarg>
#include <cstdio>

#include "fit/estimate.h"
#include "fit/tools/parameter_text.h"

namespace tribotrack::fit {
namespace {

using internal::display_factor;
using internal::number;

[[gnu::format(printf, 1, 2)]] std::string format(const char* pattern, ...) {
  char text[512];
  va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(text, sizeof text, pattern, arguments);
  va_end(arguments);
  return text;
}

std::string interval(const Interval& interval, double factor) {
  if (std::isnan(interval.low)) return "-";
  return format("[%.5g, %.5g]", interval.low * factor, interval.high * factor);
}

const char* verdict_text(Verdict verdict) {
  switch (verdict) {
    case Verdict::identifiable:
      return "identifiable: the data pin every parameter";
    case Verdict::weak:
      return "weak: usable, but read the following";
    case Verdict::not_identifiable:
      return "NOT IDENTIFIABLE: do not use these numbers";
  }
  return "";
}

}  // namespace

double FitResult::value(FitParameter parameter) const {
  for (const auto& estimate : parameters)
    if (estimate.parameter == parameter) return estimate.estimate;
  throw DataError(std::string(to_string(parameter)) + " was not fitted.");
}

std::string FitResult::brief_report() const {
  std::string text;
  for (const auto& p : parameters) {
    const double factor = display_factor(p.parameter);
    text += (text.empty() ? "" : ", ") + std::string(to_string(p.parameter)) + " = " +
            number(p.estimate * factor, 5) + " +- " + number(p.sd * factor, 2);
  }
  text += "; chi2 " + number(chi2) + " at " + std::to_string(dof) + " dof";
  if (!converged) text += "; NOT CONVERGED";
  if (identifiability.verdict == Verdict::not_identifiable) text += "; NOT IDENTIFIABLE";
  if (identifiability.verdict == Verdict::weak) text += "; weakly identified";
  return text;
}

std::string FitResult::full_report() const {
  std::string text = "[[Fit]]\n";
  text += format("    %s, %d of %d descents ended in this minimum", converged ? "converged" : "NOT CONVERGED",
                 starts_at_best, starts);
  text += starts_screened > 0 ? format(" (%d starts screened)\n", starts_screened) : "\n";
  text += format("    chi2 %.5g at %d degrees of freedom", chi2, dof);
  if (scatter_from_replicates)
    text += format(", p = %.3g (with the sigmas alone: %.5g)", p_value, chi2_before_scatter);
  else if (scatter > 0)
    text += format(" (before the scatter was estimated: %.5g, p = %.2g)", chi2_before_scatter, p_value);
  if (!(scatter > 0)) text += format(", p = %.3g", p_value);
  text += "\n    " + covariance_meaning + "\n";

  text += "[[Parameters]]\n";
  text += format("    %-24s %12s %10s  %-24s %s\n", "", "estimate", "sd", "95 % covariance", "95 % profile");
  if (bootstrap > 0) text.insert(text.size() - 1, format("%14s 95 %% bootstrap", ""));
  for (const auto& p : parameters) {
    const double factor = display_factor(p.parameter);
    const std::string percent = p.estimate != 0 && internal::is_relative(p.parameter)
                                    ? format(" (%.2g %%)", 100 * p.sd / std::abs(p.estimate))
                                    : "";
    text += format("    %-24s %12.6g %10.2g  %-24s %s%s\n", to_string(p.parameter), p.estimate * factor,
                   p.sd * factor, interval(p.ci95, factor).c_str(), interval(p.profile_ci95, factor).c_str(),
                   percent.c_str());
    if (bootstrap > 0) text.insert(text.size() - 1, "  " + interval(p.bootstrap_ci95, factor));
  }
  if (bootstrap > 0)
    text += format("    bootstrap: %d refits to simulated data, seed %u\n", bootstrap, bootstrap_seed);
  std::string correlations;
  for (Eigen::Index i = 0; i < correlation.rows(); ++i)
    for (Eigen::Index j = i + 1; j < correlation.cols(); ++j)
      if (std::abs(correlation(i, j)) > 0.1)
        correlations +=
            format("    C(%s, %s) = %+.3f\n", to_string(parameters[static_cast<std::size_t>(i)].parameter),
                   to_string(parameters[static_cast<std::size_t>(j)].parameter), correlation(i, j));
  if (!correlations.empty()) text += "[[Correlations above 0.1]]\n" + correlations;

  text += "[[What the data can tell]]\n    " + std::string(verdict_text(identifiability.verdict)) + "\n";
  for (const auto& sentence : identifiability.weak_directions) text += "    " + sentence + "\n";
  for (const auto& sentence : systematics) text += "    If wrong: " + sentence + "\n";
  if (next_experiment) text += "    " + next_experiment->sentence + "\n";
  for (const auto& other : other_next_experiments) text += "    " + other.sentence + "\n";

  if (!models.empty()) text += "[[Models compared]]\n";
  for (const auto& model : models)
    text += format("    %-20s %2d unknowns, chi2 %-8.5g AIC %-8.5g BIC %-8.5g %s\n", model.name.c_str(),
                   model.parameters, model.chi2, model.aic, model.bic, model.sentence.c_str());
  for (const auto& sentence : left_out) text += "    " + sentence + "\n";

  text += "[[Runs]]\n";
  for (const auto& run : runs) {
    text += "    " + run.name + ":";
    for (const auto& r : run.residuals)
      text +=
          format("  %s %.5g / %.5g (%+.1f)", r.observable.c_str(), r.measured, r.modelled, r.standardised);
    if (run.points > 0) text += format("  %zu points, rms %.3g mm", run.points, 1e3 * run.rms_m);
    text += "\n";
  }
  if (!warnings.empty()) text += "[[Warnings]]\n";
  for (const auto& warning : warnings) text += "    " + warning + "\n";
  return text;
}

}  // namespace tribotrack::fit
