#include "apps/watch/goal.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/files/campaign/campaign.h"
#include "apps/program/errors.h"
#include "apps/text/angle.h"

namespace tribotrack::apps {

namespace {

fit::Goal goal_from(const std::string& text) {
  const auto refuse = [&](const std::string& why) {
    return UsageError(fmt::format("--until: \"{}\" {}; write mu1=1% or phase_lag_rad=0.01", text, why));
  };
  const auto equals = text.find('=');
  if (equals == std::string::npos) throw refuse("is no goal");
  const std::string name = text.substr(0, equals);
  const auto parameter = fit_parameter_named(name);
  if (!parameter) throw refuse("names nothing that can be fitted");
  std::string value = text.substr(equals + 1);
  const bool relative = value.ends_with('%');
  if (relative) value.pop_back();
  const auto number = name.ends_with("_rad") && !relative ? parse_angle(value) : parse_number(value);
  if (!number || !(*number > 0)) throw refuse("needs a width above 0");
  return {*parameter, *number * (relative ? 0.01 : si_per_campaign_unit(*parameter)), relative};
}

/// "1 %", or "0.01" in the campaign's unit.
std::string width_text(const fit::Goal& goal, double half_width) {
  return goal.relative ? fmt::format("{:.2g} %", 100 * half_width)
                       : fmt::format("{:.2g}", half_width / si_per_campaign_unit(goal.parameter));
}

}  // namespace

std::vector<fit::Goal> goals_from(const std::string& text) {
  std::vector<fit::Goal> goals;
  for (std::size_t begin = 0; begin <= text.size() && !text.empty();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    goals.push_back(goal_from(text.substr(begin, end - begin)));
    begin = end + 1;
  }
  return goals;
}

std::string progress_of(const std::vector<fit::Goal>& goals, const fit::FitResult& result) {
  std::string text;
  for (const fit::Goal& goal : goals) {
    const double ratio = ratio_to(goal, result);
    text += fmt::format("{}{} to {}: {}{}", text.empty() ? "" : "; ", fit::to_string(goal.parameter),
                        width_text(goal, goal.half_width), ratio <= 1 ? "reached, " : "",
                        std::isfinite(ratio) ? width_text(goal, ratio * goal.half_width) : "not determined");
  }
  return text;
}

void require_fitted(const std::vector<fit::Goal>& goals, const std::vector<fit::FitParameter>& fitted) {
  for (const fit::Goal& goal : goals)
    if (std::ranges::count(fitted, goal.parameter) == 0)
      throw UsageError(
          fmt::format("--until: {} is not fitted; add it to `parameters` in [fit], or take it out",
                      fit::to_string(goal.parameter)));
}

}  // namespace tribotrack::apps
