#include "vision/audit/audit.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "vision/audit/frame_to_frame.h"

namespace tribotrack::vision {
namespace {

double time_step(const Track& track) {
  if (track.points.size() < 2) return 0;
  return (track.points.back().time_s - track.points.front().time_s) /
         static_cast<double>(track.points.size() - 1);
}

constexpr double kWorthSaying = 1.3;  ///< ratio

void audit_halves(const std::vector<AuditFrame>& frames, double time_step, Audit& out) {
  const auto found = halves_found(frames);
  if (!found) return;
  out.frames = static_cast<std::int64_t>(frames.size());
  out.halves_x = found->left_right;
  out.halves_y = found->top_bottom;
  out.white_factor = std::max(out.white_factor, supported(found->white));
  if (!(found->slow_frames > 0)) return;
  // That there is a slow part is certain; it is what white noise, widened, leaves of the total.
  const double slow = found->total.value - out.white_factor;
  if (slow <= 0) return;
  out.slow_sd = std::sqrt(slow * found->unit);
  out.slow_time = found->slow_frames * time_step;
}

/// The coordinate that is worse off counts for both.
void audit_coordinate(const std::vector<TrackStretch>& parts, Audit& out) {
  const auto found = high_frequency(parts);
  if (!found) return;
  out.high_frequency = std::max(out.high_frequency.value_or(0), std::sqrt(found->noise.value));
  out.white_factor = std::max(out.white_factor, supported(found->noise));
}

}  // namespace

Audit audit(const std::vector<AuditFrame>& frames, const Track& track) {
  Audit out;
  audit_coordinate(stretches(track, &TrackPoint::x, &TrackPoint::sigma_x), out);
  audit_coordinate(stretches(track, &TrackPoint::y, &TrackPoint::sigma_y), out);
  audit_halves(frames, time_step(track), out);
  return out;
}

void apply(const Audit& found, Track& track, TrackSummary& summary) {
  const double slow = found.slow_sd * found.slow_sd;
  for (TrackPoint& p : track.points) {
    if (p.status != TrackStatus::ok) continue;
    const double covariance = found.white_factor * p.rho_xy * p.sigma_x * p.sigma_y;
    p.sigma_x = std::sqrt(found.white_factor * p.sigma_x * p.sigma_x + slow);
    p.sigma_y = std::sqrt(found.white_factor * p.sigma_y * p.sigma_y + slow);
    p.rho_xy = covariance / (p.sigma_x * p.sigma_y);
  }
  for (SlowPart& part : summary.slow) part.sd *= std::sqrt(found.white_factor);
  if (slow > 0) summary.slow.push_back({"halves", found.slow_sd, found.slow_time});
  summary.audit = found;
  if (std::string warning = audit_warning(found); !warning.empty())
    summary.warnings.push_back(std::move(warning));
}

std::string audit_warning(const Audit& found) {
  std::vector<std::string> findings;
  const auto add = [&](const std::optional<double>& ratio, const char* what) {
    if (ratio && *ratio > kWorthSaying) findings.push_back(fmt::format(fmt::runtime(what), *ratio));
  };
  add(found.halves_x, "the left and the right half of the part disagree {:.2f} times as much");
  add(found.halves_y, "the top and the bottom half disagree {:.2f} times as much");
  add(found.high_frequency, "positions scatter from frame to frame {:.2f} times as much");
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
