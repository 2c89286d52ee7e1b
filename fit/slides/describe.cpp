#include "fit/slides/describe.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fit/rounding.h"
#include "fit/tools/parameter_text.h"
#include "fit/tools/thresholds.h"

namespace tribotrack::fit::internal {
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
        "Spin was not seen: fitted without; a rim speed of half the slide's would make mu1 {} % larger.",
        number(100 * slide.change_by_half_spin, 2));
  return fmt::format("It spins at {} rad/s, rim speed over slide speed {}, bearing on {} of its radius.",
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
      "Slide '{}': neighbouring points err alike, by {} mm for {} s, more than the track tells (a lossy "
      "coder, "
      "the lens, a camera that was not still, a deceleration that is not constant): its errors were taken "
      "from "
      "the residuals.",
      slide.run, number(1e3 * slide.shown_slow->sd, 2), number(slide.shown_slow->time, 2));
}

/// Empty where the slide knows its mu1.
std::string loose_text(const SlideResult& slide) {
  if (slide.mu1.sd < kLoose * slide.mu1.value) return "";
  return fmt::format(
      "Slide '{}' hardly determines mu1 ({}): does the part slide in the frames used ({} to {})?", slide.run,
      pm(slide.mu1), slide.first_frame, slide.last_frame);
}

/// The sentence about slides whose spin was not seen; empty where there are none.
std::string unseen_spins(const FitResult& result) {
  std::string names;
  std::size_t count = 0;
  double change = 0;
  for (const SlideResult& slide : result.slides)
    if (!slide.spin_seen && slide.slope == 0) {
      names += fmt::format("{}'{}'", names.empty() ? "" : ", ", slide.run);
      change = std::max(change, slide.change_by_half_spin);
      ++count;
    }
  if (count == 0) return "";
  return fmt::format(
      "Spin was not seen in {}: {} fitted without. If the rim moved half as fast as the part slides, "
      "mu1 would be {} % larger.",
      names, count == 1 ? "it was" : "they were", number(100 * change, 2));
}

void describe_scatter(const BetweenSlides& between, FitResult& result) {
  result.between_slides = between.sd;
  result.between_slides_p_value = between.p_value;
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
        fmt::format("mu1 = {}, chi2 {} at {} degrees of freedom (p = {}). {}", pm(slide.mu1),
                    number(slide.chi2, 3), slide.dof, number(slide.p_value, 2), spin_text(slide));
    if (!slide.spin_seen && slide.slope == 0 && slide.p_value < kSurprise)
      slide.sentence.append(" Its deceleration is not constant; that of a spinning part is not.");
    for (const std::string& finding : {blows_text(slide), slow_text(slide), loose_text(slide)}) {
      if (finding.empty()) continue;
      result.warnings.push_back(finding);
      slide.sentence.append(1, ' ').append(finding);
    }
  }
  if (result.slides.size() == 1 && result.runs.size() == 1)
    result.systematics.push_back(
        "One slide cannot show how mu1 scatters from slide to slide: the interval is that of this slide.");
  if (const std::string unseen = unseen_spins(result); !unseen.empty()) result.systematics.push_back(unseen);
  if (between) describe_scatter(*between, result);
}

}  // namespace tribotrack::fit::internal
