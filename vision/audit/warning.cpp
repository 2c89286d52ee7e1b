// What the audit says to a person.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "vision/audit/audit.h"

namespace tribotrack::vision {
namespace {

constexpr double kWorthSaying = 1.3;

}  // namespace

std::string audit_warning(const Audit& found) {
  std::vector<std::string> findings;
  const auto add = [&](const std::optional<double>& ratio, const char* what) {
    if (ratio && *ratio > kWorthSaying) findings.push_back(fmt::format(fmt::runtime(what), *ratio));
  };
  add(found.halves_x, "the left and the right half of the part disagree {:.2f} times as much");
  add(found.halves_y, "the top and the bottom half disagree {:.2f} times as much");
  add(found.checkerboard, "alternate tiles of 8 x 8 pixels disagree {:.2f} times as much");
  add(found.high_frequency, "positions scatter from frame to frame {:.2f} times as much");
  add(found.pixel_phase, "errors, with those that follow the fraction of a pixel, are {:.2f} times as large");
  if (findings.empty()) return {};
  std::string text = fmt::format(
      "audit: {} as tracking's model of the pictures predicts: they hold something that it does not (coding, "
      "light, something over the part)",
      fmt::join(findings, "; "));
  if (found.white_factor > 1)
    text += fmt::format("; standard deviations are widened by {:.2f}", std::sqrt(found.white_factor));
  if (found.slow_sd > 0)
    text += fmt::format("; {:.4f} px that change over {:.2g} s are added", found.slow_sd, found.slow_time);
  return text;
}

}  // namespace tribotrack::vision
