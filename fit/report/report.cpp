#include <fmt/format.h>
#include <cmath>

#include "fit/fit_result.h"
#include "fit/prediction.h"
#include "fit/residuals/end_point.h"
#include "fit/residuals/unknowns.h"
#include "fit/rounding.h"
#include "fit/tools/parameter_text.h"
#include "fit/tools/parameters.h"

namespace tribotrack::fit {
namespace {

using internal::chance_text;
using internal::display_factor;
using internal::number;

std::string interval(const Interval& interval, double factor, double sd) {
  if (std::isnan(interval.low)) return "-";
  const double low = interval.low * factor, high = interval.high * factor;
  return fmt::format("[{}, {}]", rounded_end(low, low, high, sd * factor),
                     rounded_end(high, low, high, sd * factor));
}

std::string pieces(const std::vector<Interval>& pieces, double factor, double sd) {
  std::string text;
  for (const Interval& piece : pieces) text += (text.empty() ? "" : " or ") + interval(piece, factor, sd);
  return text;
}

const char* identifiability_text(Verdict verdict) {
  constexpr const char* kTexts[] = {"identifiable: the data determine every parameter",
                                    "weak: usable, but read the following",
                                    "NOT IDENTIFIABLE: do not use these numbers"};
  return kTexts[static_cast<std::size_t>(verdict)];
}

std::string goodness(const FitResult& fit) {
  std::string text =
      fmt::format("    {}, {} of {} descents ended in this minimum",
                  fit.converged ? "converged" : "NOT CONVERGED", fit.starts_at_best, fit.starts);
  text += fit.starts_screened > 0 ? fmt::format(" ({} starts screened)\n", fit.starts_screened) : "\n";
  text += fmt::format("    chi2 {:.5g} at {} degrees of freedom", fit.chi2, fit.dof);
  text += ", " + chance_text(fit.p_value);
  return text + "\n    " + fit.covariance_meaning + "\n";
}

/// The list of explanations, each with the parameters under it.
std::string explanation_table(const FitResult& fit) {
  constexpr std::size_t kMostShown = 6;
  std::string text = fmt::format("    {:<18} {:>10} {:>4} {:>9}  {:<22}", "with ... free", "chi2 falls",
                                 "dof", "p left", "size");
  for (const auto& p : fit.parameters) text += fmt::format(" {:>16}", to_string(p.parameter));
  text += "\n";
  for (std::size_t i = 0; i < std::min(fit.explanations.size(), kMostShown); ++i) {
    const Explanation& e = fit.explanations[i];
    text += fmt::format("    {:<18} {:>10.4g} {:>4} {:>9.2g}  {:<22}",
                        e.run.empty() ? e.name : e.name + " " + e.run, e.chi2_fall, e.dof, e.p_after,
                        quoted(e.size, e.size_sd) + " " + e.unit);
    for (const auto& p : fit.parameters) {
      const auto under = e.parameters.find(p.parameter);
      const double factor = display_factor(p.parameter);
      text += fmt::format(" {:>16}", under == e.parameters.end() ? "-"
                                                                 : quoted(under->second.estimate * factor,
                                                                          under->second.sd * factor));
    }
    text += e.refitted ? (e.explains ? "  explains\n" : "\n") : "  first order\n";
  }
  return text;
}

std::string parameter_table(const FitResult& fit) {
  const bool bootstrap = fit.bootstrap.refits > 0;
  std::string text =
      fmt::format("    {:<24} {:>12} {:>10}  {:<24} {:<24} {}{}\n", "", "estimate", "sd", "95 % interval",
                  "covariance", "profile", bootstrap ? "               95 % bootstrap" : "");
  for (const auto& p : fit.parameters) {
    const double factor = display_factor(p.parameter);
    const std::string percent = p.estimate != 0 && internal::facts(p.parameter).is_relative()
                                    ? fmt::format(" ({:.2g} %)", 100 * p.sd / std::abs(p.estimate))
                                    : "";
    text += fmt::format(
        "    {:<24} {:>12} {:>10}  {:<24} {:<24} {}{}{}\n", to_string(p.parameter),
        std::isfinite(p.sd) ? rounded_to_sd(p.estimate * factor, p.sd * factor) : "not determined",
        std::isfinite(p.sd) ? rounded_to_sd(p.sd * factor, p.sd * factor) : "-",
        pieces(p.ci95_pieces, factor, p.sd), interval(p.covariance_ci95, factor, p.sd),
        interval(p.profile_ci95, factor, p.sd), percent,
        bootstrap ? "  " + interval(p.bootstrap_ci95, factor, p.sd) : "");
  }
  if (bootstrap)
    text += fmt::format("    bootstrap: {} refits to simulated data, seed {}\n", fit.bootstrap.refits,
                        fit.bootstrap.seed);
  return text;
}

std::string budget_table(const FitResult& fit) {
  std::string text = fmt::format("    {:<38} {:<24}", "source (sd it gives to)", "sd of the source");
  for (const auto& p : fit.parameters) text += fmt::format(" {:>12}", to_string(p.parameter));
  text += "  from\n";
  for (const BudgetEntry& entry : fit.budget) {
    if (!entry.counted) continue;
    text += fmt::format("    {:<38} {:<24}", entry.source,
                        entry.quantity.empty() ? "" : number(entry.sd, 2) + " " + entry.quantity + " (SI)");
    for (std::size_t i = 0; i < fit.parameters.size(); ++i)
      text += fmt::format(" {:>12.2g}", entry.contribution(static_cast<Eigen::Index>(i)) *
                                            display_factor(fit.parameters[i].parameter));
    text += "  " + entry.from + "\n";
  }
  text += fmt::format("    {:<38} {:<24}", "all", "");
  for (const auto& p : fit.parameters) text += fmt::format(" {:>12.2g}", p.sd * display_factor(p.parameter));
  return text + "\n";
}

std::string correlations_above(const FitResult& fit, double least) {
  std::string text;
  for (Eigen::Index i = 0; i < fit.correlation.rows(); ++i)
    for (Eigen::Index j = i + 1; j < fit.correlation.cols(); ++j)
      if (std::abs(fit.correlation(i, j)) > least)
        text += fmt::format(
            "    C({}, {}) = {:+.3f}\n", to_string(fit.parameters[static_cast<std::size_t>(i)].parameter),
            to_string(fit.parameters[static_cast<std::size_t>(j)].parameter), fit.correlation(i, j));
  return text;
}

std::string run_line(const RunResult& run) {
  std::string text = "    " + run.name + ":";
  for (const auto& r : run.residuals)
    text +=
        fmt::format("  {} {:.5g} / {:.5g} ({:+.1f})", r.observable, r.measured, r.modelled, r.standardised);
  if (run.points > 0) text += fmt::format("  {} points, rms {:.3g} mm", run.points, 1e3 * run.rms_m);
  return text + "\n";
}

}  // namespace

double FitResult::value(FitParameter parameter) const {
  for (const auto& estimate : parameters)
    if (estimate.parameter == parameter) return estimate.estimate;
  throw DataError(std::string(to_string(parameter)) + " was not fitted.");
}

Eigen::VectorXd FitResult::sd_from(const std::string& place) const {
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(parameters.size()));
  for (const BudgetEntry& entry : budget)
    if (entry.counted && entry.from == place) squares += entry.contribution.cwiseAbs2();
  return squares.cwiseSqrt();
}

bool FitResult::coder_exceeds_interval() const {
  constexpr double kHalfWidth = 1.96;  // of a 95 % interval, in sd
  const Eigen::VectorXd by_coder = sd_from(kFromCoder);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const double coder = by_coder(static_cast<Eigen::Index>(i)), all = parameters[i].sd;
    if (std::isfinite(all) && coder * coder > kHalfWidth * kHalfWidth * (all * all - coder * coder))
      return true;
  }
  return false;
}

std::string FitResult::verdict_text() const {
  std::string text = verdict == Use::use    ? "These values can be used"
                     : verdict == Use::care ? "Use with care"
                                            : "Do not use these values";
  for (std::size_t i = 0; i < verdict_reasons.size(); ++i)
    text += (i == 0 ? ": " : "; ") + verdict_reasons[i];
  return text + ".";
}

std::string FitResult::brief_report() const {
  std::string text;
  for (const auto& p : parameters) {
    const double factor = display_factor(p.parameter);
    text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", to_string(p.parameter),
                        quoted(p.estimate * factor, p.sd * factor));
  }
  text += fmt::format("; chi2 {} at {} dof", number(chi2), dof);
  if (!converged) text += "; NOT CONVERGED";
  if (identifiability.verdict == Verdict::not_identifiable) text += "; NOT IDENTIFIABLE";
  if (identifiability.verdict == Verdict::weak) text += "; weakly identified";
  return text;
}

std::string FitResult::full_report() const {
  const auto lines = [](const std::vector<std::string>& sentences) {
    std::string text;
    for (const auto& sentence : sentences) text += "    " + sentence + "\n";
    return text;
  };
  std::string text = "[[Verdict]]\n    " + verdict_text() + "\n[[Fit]]\n" + goodness(*this);
  text += "[[Parameters]]\n" + parameter_table(*this);
  if (const std::string correlations = correlations_above(*this, 0.1); !correlations.empty())
    text += "[[Correlations above 0.1]]\n" + correlations;

  text += fmt::format("[[Identifiability]]\n    {}\n", identifiability_text(identifiability.verdict));
  text += lines(identifiability.weak_directions);
  if (next_experiment) text += "    " + next_experiment->sentence + "\n";
  for (const auto& other : other_next_experiments) text += "    " + other.sentence + "\n";

  if (!budget.empty()) text += "[[Uncertainty budget]]\n" + budget_table(*this) + lines(systematics);
  if (!improve_first.empty()) text += "    " + improve_first + "\n";
  if (!explanations.empty()) text += "[[What would explain the residuals]]\n" + explanation_table(*this);
  text += lines(left_out);

  if (!slides.empty()) text += "[[Slides]]\n";
  for (const auto& slide : slides) text += "    " + slide.run + ": " + slide.sentence + "\n";
  text += "[[Runs]]\n";
  for (const auto& run : runs) text += run_line(run);
  if (!warnings.empty()) text += "[[Warnings]]\n";
  return text + lines(warnings);
}

Eigen::Vector2d modelled_displacement(const model::Scenario& scenario) {
  return internal::end_point(scenario, {}, model::IntegrationOptions{}.tolerance).position;
}

Displacement predicted_displacement(const model::Scenario& fitted, const FittedParameters& known,
                                    long max_steps) {
  Problem problem;
  problem.free = known.parameters;
  problem.summary_runs.emplace_back().scenario = fitted;
  const internal::Unknowns unknowns(problem);
  Eigen::VectorXd values(unknowns.common()), units(unknowns.common());
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const FitParameter parameter = unknowns.parameter(i);
    values(i) = parameter == FitParameter::mu1   ? fitted.friction.nominal
                : parameter == FitParameter::mu2 ? fitted.friction.reduced
                : parameter == FitParameter::lag ? fitted.friction.lag
                                                 : unknowns.as_given(parameter);
    // Those of the reference run, to which others keep their ratio.
    const bool in_proportion = parameter == FitParameter::amplitude ||
                               parameter == FitParameter::angular_frequency ||
                               parameter == FitParameter::amplitude_ratio;
    units(i) = in_proportion ? values(i) / known.estimates(i) : 1;
  }
  const internal::AppliedScenario applied = unknowns.apply(values, fitted, false, true);
  constexpr double kTolerance = 1e-8;  // of the path: a line in a figure
  const internal::EndPoint end = internal::end_point(fitted, applied.wanted, kTolerance, max_steps);
  Displacement displacement;
  displacement.vector = end.position;
  displacement.duration = fitted.end_time();
  displacement.cycles = static_cast<int>(fitted.cycles);
  if (!applied.wanted.empty()) {
    const Eigen::MatrixXd by_fitted = end.jacobian * applied.chain * units.asDiagonal();
    displacement.covariance = by_fitted * known.covariance * by_fitted.transpose();
  }
  derive_alpha_and_v(displacement);
  return displacement;
}

}  // namespace tribotrack::fit
