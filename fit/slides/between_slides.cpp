#include "fit/slides/between_slides.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "fit/pooling.h"
#include "fit/rounding.h"
#include "fit/tools/parameter_text.h"
#include "fit/tools/statistics.h"
#include "fit/tools/thresholds.h"
#include "fit/tools/track_errors.h"

namespace tribotrack::fit::internal {
BetweenSlides between_slides(const std::vector<Estimate>& slides) {
  BetweenSlides result;
  result.dof = static_cast<int>(slides.size()) - 1;
  const auto scattered_by = [&](double variance) {
    std::vector<Estimate> wider = slides;
    for (Estimate& slide : wider) slide.sd = std::sqrt(slide.sd * slide.sd + variance);
    return pool(wider);
  };
  const Pooled alike = scattered_by(0);
  result.chi2 = alike.chi2;
  result.p_value = alike.p_value;
  double far = 0;
  for (const Estimate& slide : slides) far += std::pow(slide.value - alike.mean.value, 2);
  const double variance =
      falls_to([&](double between) { return scattered_by(between).chi2; }, result.dof, far);
  const Pooled apart = scattered_by(variance);
  result.sd = std::sqrt(variance);
  result.mean = apart.mean.value;
  result.information = 1 / (apart.mean.sd * apart.mean.sd);
  return result;
}

namespace {

constexpr std::size_t kFewestResiduals = 16;
constexpr double kOfParabola = 3;  ///< unknowns along the slide
/// A normal variable exceeds it with probability kSurprise.
constexpr double kFar = 3.09;

/// Sum of e_k e_k+lag.
double product(const std::vector<double>& e, std::size_t lag) {
  double sum = 0;
  for (std::size_t k = 0; k + lag < e.size(); ++k) sum += e[k] * e[k + lag];
  return sum;
}

/// Share of the track's variance that its own slow errors have in common at so many seconds.
double told_correlation(const TrackTable& track, double apart) {
  const double variance = mean_variance(track);
  return variance > 0 ? slow_variance(track, apart) / variance : 0;
}

}  // namespace

std::optional<ShownErrors> shown_errors(const TrackTable& track, const SlideResiduals& residuals) {
  const std::vector<double>& e = residuals.value;
  const std::size_t n = e.size();
  if (n < kFewestResiduals) return std::nullopt;
  const double length = residuals.time.back() - residuals.time.front(),
               step = length / static_cast<double>(n - 1), square = product(e, 0);
  if (!(square > 0) || !(step > 0)) return std::nullopt;
  const double next = product(e, 1) / square;
  if (next - told_correlation(track, step) < kFar / std::sqrt(static_cast<double>(n))) return std::nullopt;

  double steps = 0;
  for (std::size_t k = 0; k + 1 < n; ++k) steps += std::pow(e[k + 1] - e[k], 2);
  const double all = square / static_cast<double>(n - 3);
  const double own = std::min(all, steps / (2 * static_cast<double>(n - 1)));
  // Of white noise, (e_k+1 - e_k)^2 / 2 has a mean with a relative variance of 3/n.
  const double told_own = mean_variance(track) * (1 - told_correlation(track, 0));
  if (own > told_own * (1 - kFar * std::sqrt(3 / static_cast<double>(n)))) return std::nullopt;
  std::size_t lag = 1;
  while (lag + 1 < n && product(e, lag) > next * square / std::numbers::e) ++lag;
  const double time = static_cast<double>(lag) * step;
  // So many independent values there are in a process of this correlation time.
  const double independent = std::max(length / (2 * time), 1.5 * kOfParabola);
  const double left = independent - kOfParabola;
  const double unsure = student_widening(left);
  const double slow = (all - own) * independent / left * unsure * unsure;
  return ShownErrors{std::sqrt(own), {std::sqrt(slow), time}};
}

void take_errors(const ShownErrors& shown, TrackTable& track) {
  const double variance = shown.own_sd * shown.own_sd + shown.slow.sd * shown.slow.sd;
  track.covariance.assign(track.time.size(), variance * Eigen::Matrix2d::Identity());
  track.slow = {shown.slow};
}

namespace {

constexpr double kLoose = 0.5;  ///< sd of mu1 over mu1

std::string pm(const Estimate& estimate, double unit = 1) {
  return quoted(estimate.value * unit, estimate.sd * unit);
}

std::string spin_text(const SlideResult& slide) {
  if (slide.slope != 0)
    return fmt::format("{} an incline of {} rad.", slide.slope > 0 ? "Down" : "Up",
                       number(std::abs(slide.slope), 4));
  if (!slide.spin_seen)
    return fmt::format(
        "Spin was not seen: fitted without; an edge speed of half the slide's would make mu1 {} % larger.",
        number(100 * slide.change_by_half_spin, 2));
  return fmt::format("It spins at {} rad/s, edge speed over slide speed {}, bearing on {} of its radius.",
                     pm(slide.spin), pm(slide.spin_ratio), pm(slide.bearing));
}

/// Empty where the slide was not struck.
std::string blows_text(const SlideResult& slide) {
  std::string list;
  for (const Blow& blow : slide.blows)
    list += fmt::format("{}frame {} ({} s, by {} mm/s, speed {} to {} mm/s)", list.empty() ? "" : ", ",
                        blow.frame, number(blow.time, 4), number(1e3 * blow.jump, 4),
                        number(1e3 * blow.speed_before, 4), number(1e3 * blow.speed_after, 4));
  if (list.empty()) return "";
  return fmt::format(
      "Slide '{}': its velocity jumps by more than friction can do, as by a blow or a collision, at {}. Its "
      "longest stretch without one, frames {} to {}, was used.",
      slide.run, list, slide.first_frame, slide.last_frame);
}

/// Empty where the residuals hang together as the track tells.
std::string slow_text(const SlideResult& slide) {
  if (!slide.shown_slow) return "";
  return fmt::format(
      "Slide '{}': neighbouring points err alike, by {} mm for {} s, more than the track tells (lossy "
      "compression, the lens, a camera that was not still, a deceleration that is not constant): its errors "
      "were "
      "taken from the residuals.",
      slide.run, number(1e3 * slide.shown_slow->sd, 2), number(slide.shown_slow->time, 2));
}

/// Empty where the slide knows its mu1.
std::string loose_text(const SlideResult& slide) {
  if (slide.mu1.sd < kLoose * slide.mu1.value) return "";
  return fmt::format(
      "Slide '{}' hardly determines mu1 ({}): does the part slide in the frames used ({} to {})?", slide.run,
      pm(slide.mu1), slide.first_frame, slide.last_frame);
}

void describe_scatter(const BetweenSlides& between, FitResult& result) {
  result.between_slides = {between.sd, between.p_value};
  result.covariance_meaning += fmt::format(
      " mu1 is the mean of {} slides of their own mu1 each, with an sd of {} between them (Paule and Mandel) "
      "and an interval by Student's t of {} degree{} of freedom (Hartung and Knapp).",
      between.dof + 1, number(between.sd, 2), between.dof, between.dof == 1 ? "" : "s");
  if (!(between.p_value < kDoubt)) return;
  const auto [low, high] =
      std::minmax_element(result.slides.begin(), result.slides.end(),
                          [](const auto& a, const auto& b) { return a.mu1.value < b.mu1.value; });
  result.warnings.push_back(fmt::format(
      "mu1 differs from slide to slide by more than chance: {} ('{}') to {} ('{}'), chi2 {} at {} degree{} "
      "of freedom (p = {}), sd between slides {} ({} %). The mean's interval counts it; look for spin, tilt, "
      "another part or another place.",
      number(low->mu1.value, 3), low->run, number(high->mu1.value, 3), high->run, number(between.chi2, 3),
      between.dof, between.dof == 1 ? "" : "s", number(between.p_value, 2), number(between.sd, 2),
      number(100 * between.sd / between.mean, 2)));
}

}  // namespace

void describe_slides(const BetweenSlides* between, FitResult& result) {
  for (SlideResult& slide : result.slides) {
    slide.sentence =
        fmt::format("mu1 = {}{}, chi2 {} at {} degrees of freedom (p = {}). {}", pm(slide.mu1),
                    slide.viscous ? fmt::format(" and {} 1/s by its speed", pm(*slide.viscous)) : "",
                    number(slide.chi2, 3), slide.dof, number(slide.p_value, 2), spin_text(slide));
    for (const std::string& finding : {blows_text(slide), slow_text(slide), loose_text(slide)}) {
      if (finding.empty()) continue;
      result.warnings.push_back(finding);
      slide.sentence.append(1, ' ').append(finding);
    }
  }
  if (result.slides.size() == 1 && result.runs.size() == 1)
    result.systematics.push_back(
        "One slide cannot show how mu1 scatters from slide to slide: the interval is that of this slide.");
  if (between) describe_scatter(*between, result);
}

}  // namespace tribotrack::fit::internal
