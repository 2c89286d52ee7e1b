#include "apps/report/findings/methods_text.h"

#include <fmt/format.h>

#include <algorithm>

#include "apps/page/text.h"

namespace tribotrack::apps {
namespace {

std::string list_of(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 < words.size() ? ", " : " and ") + words[i];
  return text;
}

std::size_t tracked_runs(const ReportData& data) {
  return static_cast<std::size_t>(std::ranges::count_if(
      data.runs, [](const ReportRun& run) { return run.failure.empty() && run.frames_ok > 0; }));
}

bool marker_used(const ReportData& data) {
  return std::ranges::any_of(data.runs, [](const ReportRun& run) {
    return run.failure.empty() && run.frames_ok > 0 && !run.in_camera_frame;
  });
}

std::string version(const ReportData& data) {
  return data.program_version.empty() ? "tribotrack" : "tribotrack " + data.program_version;
}

}  // namespace

std::string methods_text(const ReportData& data) {
  std::string text;
  if (const std::size_t tracked = tracked_runs(data); tracked > 0)
    text += fmt::format(
        "The part's position in {} recording{} was found in every frame by matching of a template "
        "(normalised "
        "cross-correlation) with a standard deviation per point{}. ",
        tracked, tracked == 1 ? "" : "s",
        marker_used(data) ? ", relative to the platform, whose motion was measured in the same frames" : "");
  if (!data.fitted || data.parameters.empty()) return text + fmt::format("Computed with {}.", version(data));
  std::vector<std::string> names;
  for (const ReportParameter& p : data.parameters) names.push_back(plain_symbol(p.name));
  text += fmt::format(
      "{} {} estimated by weighted least squares from {} run{}, with the equation of motion of the part "
      "under pulsed dry "
      "friction solved for each run (Kilikevičius et al. 2021, eq. 5) and its exact derivatives; intervals "
      "are 95 %, by {}, "
      "and count {}. Computed with {}.",
      list_of(names), names.size() == 1 ? "was" : "were",
      std::ranges::count_if(data.runs, [](const ReportRun& run) { return run.failure.empty(); }),
      data.runs.size() == 1 ? "" : "s",
      std::ranges::any_of(data.parameters, [](const auto& p) { return !p.profile.value.empty(); })
          ? "profile likelihood where it differs from the covariance"
          : "the covariance",
      data.budget.empty() ? "the errors of the measurements" : "the sources of the uncertainty budget",
      version(data));
  return text;
}

std::vector<std::string> sources_to_cite(const ReportData& data) {
  return {
      "S. Kilikevičius, K. Liutkauskienė, A. Fedaravičius: Nonprehensile Manipulation of Parts on a "
      "Horizontal "
      "Circularly Oscillating Platform with Dynamic Dry Friction Control. 2021.",
      version(data) + ": friction parameters from high-speed video (see CITATION.cff in its sources)."};
}

}  // namespace tribotrack::apps
