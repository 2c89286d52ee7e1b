#include "apps/files/sweeps/sweep_axis.h"

#include <fmt/format.h>

#include <cmath>
#include <string_view>
#include <utility>

#include "apps/program/errors.h"
#include "apps/text/angle.h"

namespace tribotrack::apps {

namespace {

[[noreturn]] void refuse(const std::string& text) {
  throw UsageError(fmt::format(
      "--over {}: must read NAME=FROM:TO:COUNT, such as phi_rad=0:2pi:73, or NAME=VALUE,VALUE,...", text));
}

void refuse_degrees(const std::string& text, const std::string& name, double value) {
  if (!name.ends_with("_rad")) return;
  if (const std::string slip = angle_slip(value); !slip.empty())
    throw UsageError(fmt::format("--over {}: {} {}", text, name, slip));
}

std::vector<double> listed_values(const std::string& text, std::string_view list) {
  std::vector<double> values;
  while (true) {
    const auto comma = list.find(',');
    const auto value = parse_angle(list.substr(0, comma));
    if (!value) refuse(text);
    values.push_back(*value);
    if (comma == std::string_view::npos) return values;
    list.remove_prefix(comma + 1);
  }
}

}  // namespace

SweepAxis::SweepAxis(std::string name, std::vector<double> values)
    : name_(std::move(name)), text_(name_), count_(values.size()), listed_(std::move(values)) {
  if (listed_.empty()) throw UsageError(fmt::format("--over {}: has no values", name_));
  for (const double value : listed_) {
    if (!std::isfinite(value)) throw UsageError(fmt::format("--over {}: {} is no value", name_, value));
    refuse_degrees(text_, name_, value);
  }
}

SweepAxis::SweepAxis(const std::string& text) : text_(text) {
  const auto equals = text.find('=');
  if (equals == std::string::npos) refuse(text);
  name_ = text.substr(0, equals);
  const auto first = text.find(':', equals);
  if (first == std::string::npos && text.find(',', equals) != std::string::npos) {
    listed_ = listed_values(text, std::string_view(text).substr(equals + 1));
    count_ = listed_.size();
    for (const double value : listed_) refuse_degrees(text, name_, value);
    return;
  }
  const auto second = first == std::string::npos ? first : text.find(':', first + 1);
  if (second == std::string::npos) refuse(text);
  const auto from = parse_angle(text.substr(equals + 1, first - equals - 1));
  const auto to = parse_angle(text.substr(first + 1, second - first - 1));
  const auto count = parse_number(text.substr(second + 1));
  if (!from || !to || !count) refuse(text);
  if (*count < 1 || *count > kMostScenarios || *count != std::floor(*count))
    throw UsageError(
        fmt::format("--over {}: the count, its last number, must be a whole number, 1 to {:.0f}, not {}",
                    text, kMostScenarios, *count));
  for (const double end : {*from, *to}) refuse_degrees(text, name_, end);
  from_ = *from;
  to_ = *to;
  count_ = static_cast<std::size_t>(*count);
}

double SweepAxis::value(std::size_t k) const {
  if (!listed_.empty()) return listed_[k];
  if (count_ == 1) return from_;
  return from_ + (to_ - from_) * static_cast<double>(k) / static_cast<double>(count_ - 1);
}

void require_sweepable(const std::vector<SweepAxis>& axes) {
  if (axes.empty() || axes.size() > 2)
    throw UsageError(
        "sweep needs one or two --over NAME=FROM:TO:COUNT (or `over` in [sweep] of the scenario)");
  if (axes.size() == 1) return;
  if (axes[0].name() == axes[1].name())
    throw UsageError(
        fmt::format("--over names {} twice; give another parameter for the second axis", axes[0].name()));
  const auto is_mu2 = [](const SweepAxis& axis) {
    return axis.name() == "mu2" || axis.name() == "mu1_over_mu2";
  };
  if (is_mu2(axes[0]) && is_mu2(axes[1]))
    throw UsageError("--over names mu2 and mu1_over_mu2, which mean the same; give one of them");
  const double total = static_cast<double>(axes[0].count()) * static_cast<double>(axes[1].count());
  if (total > kMostScenarios)
    throw UsageError(fmt::format(
        "--over {} --over {}: {:.0f} scenarios, at most {:.0f} are solved at once; lower the counts",
        axes[0].text(), axes[1].text(), total, kMostScenarios));
}

std::vector<SweepAxis> sweep_axes(const std::vector<std::string>& texts) {
  std::vector<SweepAxis> axes;
  for (const auto& text : texts) axes.emplace_back(text);
  require_sweepable(axes);
  return axes;
}

Sweep::Sweep(ScenarioFile base, std::vector<SweepAxis> axes)
    : base_(std::move(base)), axes_(std::move(axes)) {
  base_.over.clear();  // copied with each scenario
  for (const SweepAxis& axis : axes_) count_ *= axis.count();
}

double Sweep::value(std::size_t index, std::size_t axis) const {
  const std::size_t inner = axes_.back().count();
  return axes_[axis].value(axis + 1 == axes_.size() ? index % inner : index / inner);
}

model::Scenario Sweep::scenario(std::size_t index) const {
  ScenarioFile file = base_;
  for (std::size_t axis = 0; axis < axes_.size(); ++axis)
    set_scenario_parameter(file, axes_[axis].name(), value(index, axis));
  file.settle();
  return file.scenario;
}

}  // namespace tribotrack::apps
