#include "fit/tools/parameter_text.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "fit/rounding.h"
#include "fit/tools/error_text.h"
#include "fit/tools/thresholds.h"
#include "fit/variances/reweighted_fit.h"
#include "fit/variances/robust.h"

namespace tribotrack::fit::internal {

std::string number(double value, int significant) {
  return fmt::format("{:.{}g}", value, significant);
}

std::string chance_text(double p_value) {
  return p_value > 0 ? "p = " + number(p_value, 2) : "p < 1e-300";
}

std::string change_text(FitParameter parameter, double change, double value) {
  const std::string direction = change < 0 ? " down " : " up ";
  const double size = std::abs(change);
  if (is_relative(parameter) && value != 0)
    return to_string(parameter) + direction + number(100 * size / std::abs(value), 2) + " %";
  const std::string text = to_string(parameter) + direction + number(size * display_factor(parameter), 2);
  const bool angle = parameter == FitParameter::lag || parameter == FitParameter::tilt_x ||
                     parameter == FitParameter::tilt_y || parameter == FitParameter::slope;
  return angle ? text + " (" + number(size * 180 / std::numbers::pi, 2) + " deg)" : text;
}

}  // namespace tribotrack::fit::internal

namespace tribotrack::fit {
namespace {

/// Of the number rounded to two digits: 0.0996 counts as 0.10.
int exponent_of(double value) {
  const std::string text = fmt::format("{:.1e}", value);
  return std::atoi(text.c_str() + text.find('e') + 1);
}

}  // namespace

std::string rounded_to_sd(double value, double sd) {
  if (!std::isfinite(value) || !std::isfinite(sd) || !(sd > 0)) return fmt::format("{:.4g}", value);
  const int exponent = exponent_of(sd);
  if (exponent >= -8 && exponent < 5) return fmt::format("{:.{}f}", value, std::max(1 - exponent, 0));
  // Very small or large: a power of ten keeps the zeros out.
  const int digits = value == 0 ? 0 : std::max(exponent_of(std::abs(value)) - exponent + 1, 0);
  return fmt::format("{:.{}e}", value, digits);
}

std::string quoted(double value, double sd) {
  if (!std::isfinite(value) || !std::isfinite(sd) || sd < 0) return "not determined";
  if (sd == 0) return fmt::format("{:.4g}", value);
  const std::string text = rounded_to_sd(value, sd), error = rounded_to_sd(sd, sd);
  std::string digits;
  if (const auto power = error.find('e'); power != std::string::npos) {
    // Both with the value's power of ten: the error's digits are those of its last two places.
    const std::string two = fmt::format("{:.0f}", sd / std::pow(10.0, exponent_of(sd) - 1));
    const auto end = text.find('e');
    return fmt::format("{}({}){}", text.substr(0, end), two,
                       end == std::string::npos ? "" : text.substr(end));
  }
  // In units of the value's last place: "0.0029" becomes "29", "1.2" becomes "12".
  for (const char c : error)
    if (c != '.' && (c != '0' || !digits.empty())) digits += c;
  return fmt::format("{}({})", text, digits);
}

std::string rounded_end(double end, double low, double high, double sd) {
  if (!std::isfinite(end)) return "open";
  const double half_width = 0.5 * (high - low);
  const bool wide = std::isfinite(half_width) && half_width > 0, known = std::isfinite(sd) && sd > 0;
  return rounded_to_sd(end, !wide ? sd : known ? std::min(sd, half_width) : half_width);
}

}  // namespace tribotrack::fit

namespace tribotrack::fit::internal {
namespace {

std::string scatter_text(const ExcessVariance& excess) {
  return excess.along == excess.across
             ? fmt::format("{} mm per axis", number(1e3 * excess.runs()))
             : fmt::format("{} mm along (v) and {} mm across their displacement (alpha)",
                           number(1e3 * excess.along), number(1e3 * excess.across));
}

double sd_of(const CorrelatedVariances& variances, ErrorPart part) {
  return std::sqrt(variances[static_cast<std::size_t>(part)]);
}

/// Rms about the mean of a run; a sine's two coefficients add up to one variance.
double rms_of(const CorrelatedErrors& errors) {
  return std::sqrt(errors.drift * errors.drift / 12 + errors.walk * errors.walk / 6 +
                   std::pow(std::hypot(errors.circle, errors.common_circle), 2) +
                   2 * std::pow(std::hypot(errors.overtones, errors.common_overtones), 2));
}

}  // namespace

void fill_excess_variance(const Residuals& residuals, bool allowed, FitResult& result) {
  const Problem& problem = residuals.unknowns().problem();
  const ExcessVariance& excess = residuals.excess_variance();
  result.scatter = excess.runs();
  result.scatter_along = excess.along;
  result.scatter_across = excess.across;
  for (const auto& run : excess.trajectories) result.scatter = std::max(result.scatter, run.between_points);
  if (!any(excess)) {
    result.covariance_meaning =
        result.loss == Loss::squares
            ? fmt::format(
                  "sd from the data's own sigma (absolute; not scaled by chi2), 95 % intervals with {}",
                  excess.correlated == CorrelatedVariances{} ? "1.96 sd." : "Student's t.")
            : std::string("95 % intervals with Student's t.") + robust_meaning(result.loss);
    if (result.p_value < kSurprise && !allowed)
      result.warnings.push_back(
          fmt::format("chi2 = {} at {} degrees of freedom ({}): the model or the "
                      "sigmas are wrong, and the sds too small.",
                      number(result.chi2, 4), result.dof, chance_text(result.p_value)));
    return;
  }
  const bool repeated = result.scatter_from_replicates;
  result.covariance_meaning = fmt::format(
      "sd from the data's own sigma and a scatter estimated from {}, added in quadrature; 95 % "
      "intervals with Student's t.{}",
      repeated ? "repeated runs" : "the residuals", robust_meaning(result.loss));
  if (repeated)
    result.warnings.push_back(
        fmt::format("Repeated runs scatter by {} more than their own sigma; with that the "
                    "fit agrees with all runs ({}).",
                    scatter_text(excess), chance_text(result.p_value)));
  else if (excess.runs() > 0 && result.p_value < kSurprise)
    result.warnings.push_back(fmt::format(
        "The runs scatter by {} more than their own sigma (chi2 {}, {}){}something in A, w, tilt "
        "or the model is wrong.",
        scatter_text(excess), number(result.chi2_before_scatter, 4), chance_text(result.p_value),
        result.replicate_dof >= 6 ? ", and by more than repeated runs do: " : ": real scatter, or "));
  for (std::size_t i = 0; i < excess.trajectories.size(); ++i)
    if (const auto& run = excess.trajectories[i]; run.between_points > 0)
      result.warnings.push_back(
          fmt::format("Run '{}': its points scatter by {} mm per axis more than their own sigma and are "
                      "correlated over {} points; the sd counts both.",
                      problem.trajectory_runs[i].name, number(1e3 * run.between_points),
                      number(run.correlation_time, 2)));
}

void fill_correlated_errors(const Residuals& residuals, FitResult& result) {
  const CorrelatedVariances& variances = residuals.excess_variance().correlated;
  CorrelatedErrors& errors = result.correlated_errors;
  errors.time = residuals.reference_time();
  const double own_drift = sd_of(variances, ErrorPart::drift),
               common_drift = sd_of(variances, ErrorPart::common_drift);
  errors.drift = std::hypot(own_drift, common_drift);
  errors.walk = sd_of(variances, ErrorPart::walk);
  errors.circle = sd_of(variances, ErrorPart::circle);
  errors.overtones = sd_of(variances, ErrorPart::overtones);
  errors.common_circle = sd_of(variances, ErrorPart::common_circle);
  errors.common_overtones = sd_of(variances, ErrorPart::common_overtones);
  if (!errors.any()) return;
  std::string parts;
  const auto add = [&](double size, const std::string& what) {
    if (size > 0) parts += fmt::format("{}{} um {}", parts.empty() ? "" : ", ", number(1e6 * size, 2), what);
  };
  const std::string over = " over " + number(errors.time, 2) + " s";
  add(own_drift, "of straight drift" + over);
  add(errors.walk, "of Brownian walk" + over);
  add(errors.circle, "at the platform's frequency");
  add(errors.overtones, "at its second and third multiple");
  add(errors.common_circle, "at the platform's frequency, the same in all runs");
  add(errors.common_overtones, "at its second and third multiple, the same in all runs");
  add(common_drift, "of straight drift" + over + " along and across the displacement, the same in all runs");
  if (result.p_value < kSurprise) {
    const double rms = rms_of(errors);
    result.scatter = std::max(result.scatter, rms);
    result.warnings.push_back(
        fmt::format("The tracks have correlated errors of {} mm rms per axis beyond their own sigma ({}): "
                    "low-frequency tracking errors, or something in A, w, tilt or the model is wrong.",
                    number(1e3 * rms), chance_text(result.p_value)));
  }
  result.covariance_meaning += fmt::format(
      " It counts correlated errors of the points of a track, independent between runs unless "
      "stated, of one size estimated from all tracks by restricted maximum likelihood (sd per axis: "
      "{}); the intervals count its uncertainty (Student's t by Satterthwaite).",
      parts);
}

}  // namespace tribotrack::fit::internal
