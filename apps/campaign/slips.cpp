#include "apps/campaign/slips.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "apps/measuring/measure_run.h"

namespace tribotrack::apps {

using fit::SlipFound;
using fit::Source;

namespace {

bool is_driven(const Run& run) {
  return run.takes_part() && !run.given.free_slide;
}

/// A diameter, or mm/px; the other of them, a calibration or a tag checks it.
const char* scale_key(const Campaign& campaign) {
  return campaign.camera.calibration                               ? "calibration"
         : campaign.camera.tag_mm                                  ? "tag_mm"
         : campaign.part.diameter_mm && !campaign.camera.mm_per_px ? "diameter_mm"
                                                                   : "mm_per_px";
}

bool one_scale(const Campaign& campaign, const fit::Conditions& conditions) {
  return !campaign.camera.calibration && !campaign.camera.tag_mm &&
         conditions.find(Source::diameter) == nullptr;
}

}  // namespace

fit::Typed typed(const std::vector<Run>& runs, const fit::Conditions& conditions) {
  const auto alone = [&](Source source) {
    const fit::PooledQuantity* q = conditions.find(source);
    return q != nullptr && q->given && !q->measured;
  };
  const auto all_driven = [&](auto holds) {
    return std::ranges::all_of(runs, [&](const Run& run) { return !is_driven(run) || holds(run); });
  };
  fit::Typed typed;
  typed.amplitude = alone(Source::amplitude);
  typed.frequency = alone(Source::angular_frequency);
  typed.timing = all_driven([](const Run& run) { return !run.gate; });
  typed.directions = all_driven([](const Run& run) { return !run.track; });
  typed.lengths = std::ranges::any_of(runs, [](const Run& run) {
    return run.takes_part() && run.track && run.track->mm_per_px.value_or(0) > 0;
  });
  return typed;
}

namespace {

/// What was typed, what was meant.
std::string what_is_wrong(const Campaign& campaign, const Run& run, const SlipFound& slip) {
  using enum SlipFound::What;
  const double f = slip.factor;
  const auto number = [&](const std::string& key, double given) {
    const std::string likely = likely_slip(key, given, given * f);
    return fmt::format("{} = {:.4g} instead of {:.4g}{}", key, given * f, given,
                       likely.empty() ? "" : " (" + likely + ")");
  };
  const auto scaled = [&](const char* keys) {
    return fmt::format(
        "{} times {}", keys,
        f > 1 ? "180/pi: radians where degrees are meant" : "pi/180: degrees where radians are meant");
  };
  const std::string turn = fmt::format("{:+.0f} deg", f * 180 / std::numbers::pi);
  const char* shift = f == 0 ? "" : f == -1 ? " - dtau" : " - dtau/2";
  switch (slip.what) {
    case amplitude:
      return number("amplitude_mm",
                    1e3 * run.given.amplitude.value_or(campaign.platform.amplitude.value_or(0)));
    case frequency:
      return number("angular_frequency_rad_s",
                    run.given.angular_frequency.value_or(campaign.platform.angular_frequency.value_or(0)));
    case lengths: {
      const std::string key = scale_key(campaign);
      const double given = key == "diameter_mm" ? *campaign.part.diameter_mm
                           : key == "tag_mm"    ? *campaign.camera.tag_mm
                                                : run.track->mm_per_px.value_or(0);
      return number(key, given);
    }
    case phi:
      return scaled("phi");
    case dtau:
      return scaled("dtau");
    case timing:
      return scaled("phi and dtau");
    case alpha:
      return scaled("alpha");
    case angles:
      return scaled("phi, dtau and alpha");
    case alpha_mirrored:
      return "y counted downwards, or the platform turning the other way (-alpha, or -phase_shift_rad)";
    case phi_turned:
      return "phi counted from an axis that is turned: phi " + turn;
    case phi_edge:
      return fmt::format("phi counted to the {} of the pulse: phi{}", f < -0.5 ? "end" : "middle", shift);
    case phi_reversed:
      break;
  }
  return fmt::format("phi counted against the platform's sense: -phi{}", shift);
}

std::string values_of(const SlipFound& slip) {
  std::string text;
  for (const auto& [parameter, value] : slip.values)
    if (parameter != fit::FitParameter::scale)
      text += fmt::format(", {} {:.3g}", fit::to_string(parameter), value / si_per_campaign_unit(parameter));
  return text;
}

}  // namespace

std::vector<std::string> likely_slips(const Campaign& campaign, const std::vector<Run>& runs,
                                      const SharedConditions& shared, const std::vector<SlipFound>& found,
                                      const fit::FitResult& result) {
  std::vector<std::string> sentences;
  const bool absurd = fit::is_absurd(result), failing = fit::is_failing(result);
  const fit::Typed given = typed(runs, shared.pooled);
  const auto first = std::ranges::find_if(
      runs, [&](const Run& run) { return run.takes_part() && (run.track || !given.lengths); });
  if (first == runs.end()) return sentences;
  const char* verb = !absurd && !failing ? "the data fit better to"
                     : found.size() == 1 ? "a slip would explain it:"
                                         : "one of the slips would explain it:";
  for (const SlipFound& slip : found)
    sentences.push_back(fmt::format("{} {}; then chi2 {:.3g} at {} degrees of freedom (p = {:.2g}){}", verb,
                                    what_is_wrong(campaign, *first, slip), slip.chi2, slip.dof, slip.p_value,
                                    values_of(slip)));
  // Where A was seen at the same scale, it scales friction and leaves chi^2 as it is.
  const std::string key = scale_key(campaign);
  if (given.lengths && (absurd || (failing && given.amplitude)) && one_scale(campaign, shared.pooled))
    sentences.push_back(
        fmt::format("{}, and all lengths go by {} alone: give a second scale that checks it, {}",
                    absurd ? "such friction is hardly found between dry bodies" : "the fit fails", key,
                    key == "diameter_mm" ? "mm_per_px, a calibration or the side of a tag"
                                         : "diameter_mm or the side of a tag"));
  return sentences;
}

}  // namespace tribotrack::apps
