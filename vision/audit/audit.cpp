#include "vision/audit/audit.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <boost/math/special_functions/binomial.hpp>
#include <cmath>

#include "vision/kernels/dense.h"

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

/// One sentence where a ratio exceeds 1.3, else empty.
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
    set_covariance(p, found.white_factor * covariance_of(p) + slow * Eigen::Matrix2d::Identity());
  }
  for (SlowPart& part : summary.slow) part.sd *= std::sqrt(found.white_factor);
  if (slow > 0) summary.slow.push_back({"halves", found.slow_sd, found.slow_time});
  summary.audit = found;
  if (std::string warning = audit_warning(found); !warning.empty())
    summary.warnings.push_back(std::move(warning));
}

std::vector<TrackStretch> stretches(const Track& track, double TrackPoint::*position,
                                    double TrackPoint::*sigma) {
  std::vector<TrackStretch> out;
  bool open = false;
  for (const TrackPoint& p : track.points) {
    if (p.status != TrackStatus::ok || !(p.sigma_x > 0 && p.sigma_y > 0)) {
      open = false;
      continue;
    }
    if (!open) out.emplace_back();
    open = true;
    out.back().position.push_back(p.*position);
    out.back().sigma.push_back(p.*sigma);
  }
  return out;
}

namespace {

constexpr std::size_t kLeastDifferences = 24;  ///< a ratio of standard deviations to 20 %
constexpr int kHighestOrder = 6;
/// Standard deviations by which orders must differ: fewer, and white noise is often taken for a motion; more,
/// and a motion passes for noise.
constexpr double kCertain = 3;

double choose(int n, int k) {
  return boost::math::binomial_coefficient<double>(static_cast<unsigned>(n), static_cast<unsigned>(k));
}

/// Appends the p-th differences over what their standard deviation would be.
void add_differences(const TrackStretch& s, int p, std::vector<double>& out) {
  const auto order = static_cast<std::size_t>(p);
  for (std::size_t k = 0; k + order < s.position.size(); ++k) {
    double difference = 0, variance = 0;
    for (std::size_t i = 0; i <= order; ++i) {
      const double c = choose(p, static_cast<int>(i)) * (i % 2 == 0 ? 1 : -1);
      difference += c * s.position[k + i];
      variance += c * c * s.sigma[k + i] * s.sigma[k + i];
    }
    out.push_back(difference / std::sqrt(variance));
  }
}

struct OfOrder {
  double square = 0;
  double count = 0;
};

OfOrder of_order(const std::vector<TrackStretch>& stretches, int p) {
  std::vector<double> differences;
  for (const TrackStretch& s : stretches) add_differences(s, p, differences);
  const double limit = outlier_size(differences);
  OfOrder out;
  for (const double z : differences) {
    if (std::abs(z) > limit) continue;
    out.square += z * z;
    ++out.count;
  }
  if (out.count > 0) out.square /= out.count;
  return out;
}

/// Covariance of two orders' estimates from n differences, relative.
double covariance(int p, int q, double n) {
  return 2 / n * choose(2 * (p + q), p + q) / (choose(2 * p, p) * choose(2 * q, q));
}

}  // namespace

std::optional<HighFrequency> high_frequency(const std::vector<TrackStretch>& stretches) {
  OfOrder low = of_order(stretches, 2);
  for (int p = 2; p <= kHighestOrder; p += 2) {
    const OfOrder next = of_order(stretches, p + 2);
    if (next.count < kLeastDifferences) return std::nullopt;
    const double n = next.count;
    const double scatter =
        std::sqrt(covariance(p, p, n) + covariance(p + 2, p + 2, n) - 2 * covariance(p, p + 2, n));
    if (low.square <= next.square * (1 + kCertain * scatter))
      return HighFrequency{{low.square, low.square * std::sqrt(covariance(p, p, n))}, p};
    low = next;
  }
  return std::nullopt;
}

}  // namespace tribotrack::vision
