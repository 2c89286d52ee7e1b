#include "apps/report/tables/tables.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <vector>

#include "apps/page/text.h"

namespace tribotrack::apps {

std::string quoted_interval(const fit::ParameterEstimate& parameter) {
  if (parameter.ci95_pieces.size() < 2)
    return interval_text(parameter.ci95.low, parameter.ci95.high, parameter.sd);
  std::string text;
  for (const fit::Interval& piece : parameter.ci95_pieces)
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

namespace {

std::size_t failed_runs(const ReportData& data) {
  return static_cast<std::size_t>(std::count_if(data.runs.begin(), data.runs.end(),
                                                [](const ReportRun& run) { return !run.failure.empty(); }));
}

std::string runs_used(const ReportData& data) {
  const std::size_t failed = failed_runs(data);
  const std::size_t used = data.runs.size() - failed;
  std::string text = fmt::format("{} run{}", used, used == 1 ? "" : "s");
  if (failed > 0)
    text += fmt::format(" ({} more failed and {} left out)", failed, failed == 1 ? "is" : "are");
  return text;
}

std::string list_of(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 < words.size() ? ", " : " and ") + words[i];
  return text;
}

/// What chi^2 says, whatever was added later.
std::string agreement_text(const fit::FitResult& fit) {
  if (fit.dof < 1) return "";
  return fmt::format(
      "χ² per degree of freedom is {}; {} is expected if the model and the stated errors are right.",
      number(fit.chi2 / fit.dof, 3), expected_chi2_text(fit.dof, fit.noise_dof));
}

}  // namespace

std::string expected_chi2_text(int dof, double noise_dof) {
  const fit::Interval expected = fit::expected_reduced_chi2(dof, noise_dof);
  return interval_text(expected.low, expected.high, 0.3 * (expected.high - expected.low));
}

Verdict verdict_of(const ReportData& data) {
  const fit::FitResult& fit = data.fit;
  if (!data.fitted())
    return {.heading = "Measurements only",
            .paragraph = fmt::format("No parameters were fitted; the page shows what was measured in {}.",
                                     runs_used(data))};
  const std::string reasons = fmt::format("{}", fmt::join(fit.verdict_reasons, "; "));
  const std::size_t failed = failed_runs(data);
  Verdict verdict;
  if (fit.verdict == fit::Use::do_not_use)
    verdict = {"bad", "Do not use these values", reasons + "."};
  else if (fit.verdict == fit::Use::care || failed > 0)
    verdict = {"care",
               "Use with care: " + reasons + (reasons.empty() || failed == 0 ? "" : "; ") +
                   (failed == 0   ? ""
                    : failed == 1 ? "one run failed"
                                  : fmt::format("{} runs failed", failed)),
               ""};
  else
    verdict = {"good", "Can be used", ""};
  if (!verdict.paragraph.empty() && sentence_html(verdict.paragraph)[0] == verdict.paragraph[0])  // no symbol
    verdict.paragraph[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(verdict.paragraph[0])));
  if (fit.converged)
    verdict.paragraph += fmt::format("{}The fit to {} converged. {}", verdict.paragraph.empty() ? "" : " ",
                                     runs_used(data), agreement_text(fit));
  if (fit.scatter > 0)
    verdict.paragraph += fmt::format(
        " Scatter of up to {} mm per axis beyond the measurement errors was added; the intervals include it.",
        number(1e3 * fit.scatter, 2));
  if (!data.warnings.empty())
    verdict.paragraph +=
        fmt::format(" Read the {} below first.",
                    data.warnings.size() == 1 ? "warning" : fmt::format("{} warnings", data.warnings.size()));
  return verdict;
}

std::vector<std::string> assumptions(const ReportData& data) {
  const fit::FitResult& fit = data.fit;
  std::vector<std::string> lines;
  const auto keys = [](const std::vector<std::string>& names) {
    std::vector<std::string> symbols;
    for (const std::string& name : names) symbols.push_back(parameter_text(name).symbol);
    return list_of(symbols);
  };
  lines.push_back(
      !fit.quoted_under.empty() ? "The campaign and the paper’s friction law as described, but for " +
                                      list_of(fit.quoted_under) + "."
      : !fit.mu_of_speed.empty()
          ? "Friction that depends on speed as well (warning): μ₁, and μ₂ during the pulse, beside that."
          : "The paper’s friction law: μ₁, and μ₂ during the pulse.");
  if (!data.exact.empty()) lines.push_back("Taken as exact: " + keys(data.exact) + ".");
  // What is said is what a parameter's uncertainty feels: a tenth of it or more.
  std::vector<std::string> defaults;
  for (const fit::BudgetEntry& entry : fit.budget) {
    bool felt = false;
    for (std::size_t i = 0; i < fit.parameters.size(); ++i)
      felt = felt || std::abs(entry.contribution(static_cast<Eigen::Index>(i))) > 0.1 * fit.parameters[i].sd;
    if (entry.counted && felt && entry.from.ends_with("default sd")) defaults.push_back(entry.source);
  }
  if (!defaults.empty())
    lines.push_back("With a default uncertainty, because none was given: " + list_of(defaults) + ".");
  return lines;
}

namespace {

bool is_tracked(const ReportRun& run) {
  return run.failure.empty() && run.frames_ok() > 0;
}

std::size_t tracked_runs(const ReportData& data) {
  return static_cast<std::size_t>(std::ranges::count_if(data.runs, is_tracked));
}

bool marker_used(const ReportData& data) {
  return std::ranges::any_of(
      data.runs, [](const ReportRun& run) { return is_tracked(run) && !run.track.in_camera_frame; });
}

std::string version(const ReportData& data) {
  return data.program_version.empty() ? "tribotrack" : "tribotrack " + data.program_version;
}

}  // namespace

std::string methods_text(const ReportData& data) {
  std::string text;
  if (const std::size_t tracked = tracked_runs(data); tracked > 0)
    text += fmt::format(
        "The part's position in {} recording{} was found in every frame by matching of a template "
        "(normalised cross-correlation) with a standard deviation per point{}. ",
        tracked, tracked == 1 ? "" : "s",
        marker_used(data) ? ", relative to the platform, whose motion was measured in the same frames" : "");
  if (!data.fitted()) return text + fmt::format("Computed with {}.", version(data));
  std::vector<std::string> names;
  for (const fit::ParameterEstimate& p : data.fit.parameters)
    names.push_back(parameter_text(p.parameter).symbol);
  text += fmt::format(
      "{} {} estimated by weighted least squares from {} run{}, with the equation of motion of the part "
      "under pulsed dry friction solved for each run (Kilikevičius et al. 2021, eq. 5) and its exact "
      "derivatives; intervals are 95 %, by {}, and count {}. Computed with {}.",
      list_of(names), names.size() == 1 ? "was" : "were",
      std::ranges::count_if(data.runs, [](const ReportRun& run) { return run.failure.empty(); }),
      data.runs.size() == 1 ? "" : "s",
      std::ranges::any_of(data.fit.parameters, [](const auto& p) { return !p.profile.empty(); })
          ? "profile likelihood where it differs from the covariance"
          : "the covariance",
      data.fit.budget.empty() ? "the errors of the measurements" : "the sources of the uncertainty budget",
      version(data));
  return text;
}

std::vector<std::string> sources_to_cite(const ReportData& data) {
  return {
      "S. Kilikevičius, K. Liutkauskienė, A. Fedaravičius: Nonprehensile Manipulation of Parts on a "
      "Horizontal Circularly Oscillating Platform with Dynamic Dry Friction Control. 2021.",
      version(data) + ": friction parameters from high-speed video (see CITATION.cff in its sources)."};
}

}  // namespace tribotrack::apps
