#include "apps/report/data/groups.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tribotrack::apps {
namespace {

constexpr double full_turn = 2 * std::numbers::pi;

/// Values of the varied and of the shared angle, one per run.
struct Angles {
  std::vector<double> varied;
  std::vector<double> shared;
};

bool belongs_in_a_figure(const ReportRun& run) {
  return run.failure.empty() && run.kind != "free_slide" && std::isfinite(run.phi_rad) &&
         std::isfinite(run.dtau_rad) && std::isfinite(run.v_mm_s);
}

std::vector<double> phis(const std::vector<ReportRun>& runs, double tolerance) {
  std::vector<double> values;
  for (const ReportRun& run : runs) values.push_back(phi_in_one_turn(run.phi_rad, tolerance));
  return values;
}

std::vector<double> dtaus(const std::vector<ReportRun>& runs) {
  std::vector<double> values;
  for (const ReportRun& run : runs) values.push_back(run.dtau_rad);
  return values;
}

void sort_by(const std::vector<double>& angle, std::vector<std::size_t>& members) {
  std::stable_sort(members.begin(), members.end(),
                   [&](std::size_t a, std::size_t b) { return angle[a] < angle[b]; });
}

std::vector<ReportGroup> group(const Angles& angles, const std::vector<ReportRun>& runs, double tolerance) {
  std::vector<std::size_t> members;
  for (std::size_t i = 0; i < runs.size(); ++i)
    if (belongs_in_a_figure(runs[i])) members.push_back(i);
  sort_by(angles.shared, members);

  std::vector<ReportGroup> groups;
  for (const std::size_t i : members) {
    if (groups.empty() || angles.shared[i] - angles.shared[groups.back().runs.back()] > tolerance) {
      groups.emplace_back();
      groups.back().shared_rad = angles.shared[i];
    }
    groups.back().runs.push_back(i);
  }
  for (ReportGroup& g : groups) sort_by(angles.varied, g.runs);
  std::erase_if(groups, [&](const ReportGroup& g) {
    return angles.varied[g.runs.back()] - angles.varied[g.runs.front()] <= tolerance;
  });
  return groups;
}

std::vector<double> even_steps(double from, double to, int count) {
  std::vector<double> values;
  for (int i = 0; i < count; ++i) values.push_back(from + (to - from) * i / std::max(count - 1, 1));
  return values;
}

std::vector<double> padded_range(double first, double last, int count) {
  const double spare = 0.1 * (last - first);
  return even_steps(std::max(0.0, first - spare), std::min(full_turn, last + spare), count);
}

}  // namespace

double phi_in_one_turn(double phi_rad, double tolerance) {
  const double wrapped = phi_rad - full_turn * std::floor(phi_rad / full_turn);
  return wrapped > full_turn - tolerance ? wrapped - full_turn : wrapped;
}

std::vector<ReportGroup> group_over_phi(const std::vector<ReportRun>& runs, double tolerance) {
  return group({.varied = phis(runs, tolerance), .shared = dtaus(runs)}, runs, tolerance);
}

std::vector<ReportGroup> group_over_dtau(const std::vector<ReportRun>& runs, double tolerance) {
  return group({.varied = dtaus(runs), .shared = phis(runs, tolerance)}, runs, tolerance);
}

std::vector<double> curve_phis(const ReportGroup& group, const std::vector<ReportRun>& runs, int count) {
  if (group.runs.empty()) return {};
  const double first = phi_in_one_turn(runs[group.runs.front()].phi_rad);
  const double last = phi_in_one_turn(runs[group.runs.back()].phi_rad);
  if (last - first >= std::numbers::pi) return even_steps(0, full_turn, count);
  return padded_range(first, last, count);
}

std::vector<double> curve_dtaus(const ReportGroup& group, const std::vector<ReportRun>& runs, int count) {
  if (group.runs.empty()) return {};
  return padded_range(runs[group.runs.front()].dtau_rad, runs[group.runs.back()].dtau_rad, count);
}

}  // namespace tribotrack::apps
