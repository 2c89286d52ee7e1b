#include "apps/campaign/compared_runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/program/errors.h"
#include "apps/text/number_text.h"

namespace tribotrack::apps {

namespace {

bool same_recording(const Run& a, const Run& b) {
  if (!a.track || !b.track || a.given.free_slide != b.given.free_slide) return false;
  const fit::TrackTable &one = a.track->table, &other = b.track->table;
  return !one.position.empty() && one.frame == other.frame && one.time == other.time &&
         one.position == other.position;
}

/// Runs whose tracks are the same to the last bit as an earlier one's: each gets Run::repeats. Throws
/// InvalidInput where they are given with different phi or dtau, of which one is wrong.
void set_aside_repeated(std::vector<Run>& runs) {
  for (std::size_t i = 0; i < runs.size(); ++i)
    for (std::size_t k = 0; k < i && runs[i].takes_part(); ++k) {
      const CampaignRun &here = runs[i].given, &before = runs[k].given;
      if (!runs[k].takes_part() || !same_recording(runs[i], runs[k])) continue;
      if (here.phi != before.phi || here.dtau != before.dtau)
        throw InvalidInput(
            "{}: run \"{}\" is the recording of run \"{}\" once more, with another phi_rad or dtau_rad: take "
            "one of them out, or name the right recording",
            here.place, here.name, before.name);
      runs[i].repeats = before.name;
    }
}

}  // namespace

std::vector<std::string> repeated_text(const std::vector<Run>& runs) {
  std::vector<std::string> sentences;
  for (const Run& run : runs)
    if (!run.repeats.empty())
      sentences.push_back(
          fmt::format("run \"{}\" is the recording of run \"{}\" once more: it is counted once",
                      run.given.name, run.repeats));
  return sentences;
}

namespace {

/// Of the true length that the recordings' scales were measured by, the part's diameter or the side of a tag,
/// relative; 0: exact, or the scale was given.
double length_error(const Campaign& campaign) {
  if (campaign.camera.tag_mm) return campaign.camera.tag_mm_sd / *campaign.camera.tag_mm;
  const PartSection& part = campaign.part;
  return part.diameter_mm ? part.diameter_sd_mm / *part.diameter_mm : 0;
}

bool scaled_by(const Run& run, const char* source) {
  return run.takes_part() && run.track && run.track->mm_per_px && run.track->mm_per_px_sd &&
         run.track->scale_source == source;
}
bool scaled_by_diameter(const Run& run) {
  return scaled_by(run, kScaledByDiameter);
}
bool scaled_in_picture(const Run& run) {
  return scaled_by_diameter(run) || scaled_by(run, kScaledByTag);
}

/// What the rim's model leaves of a highlight: relative to the radius, the same in every recording.
double common_of_rim(const Run& run) {
  if (!scaled_by_diameter(run)) return 0;
  const Track& track = *run.track;
  return track.disc_radius_px > 0 ? track.disc_radius_common_sd_px / track.disc_radius_px : 0;
}

constexpr double kOtherSize = 0.05;     ///< of the diameter: parts of one kind do not differ by so much
constexpr double kSamePlatform = 0.03;  ///< of A, which the camera sees at its true scale

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// A part that is smaller than the others makes its recording's pixels, and with them the platform's
/// amplitude, too large by one and the same factor. A camera that was moved leaves the amplitude as it is.
void set_aside_other_parts(const Campaign& campaign, std::vector<Run>& runs) {
  std::vector<Run*> seen;
  std::vector<double> scales, amplitudes;
  for (Run& run : runs)
    if (scaled_by_diameter(run) && run.measurement && run.measurement->platform) {
      seen.push_back(&run);
      scales.push_back(*run.track->mm_per_px);
      amplitudes.push_back(run.measurement->platform->amplitude.value);
    }
  if (seen.size() < 3) return;
  const double usual = median_of(scales), amplitude = median_of(amplitudes);
  for (std::size_t k = 0; k < seen.size(); ++k) {
    const double ratio = scales[k] / usual;
    if (std::abs(ratio - 1) < kOtherSize || std::abs(amplitudes[k] / amplitude / ratio - 1) > kSamePlatform)
      continue;
    seen[k]->failure = fmt::format(
        "{}: run \"{}\": by the scale of the other recordings its part is {:.3g} mm across, not {:.3g} mm: "
        "is it another part? leave the run out, or give its mm_per_px",
        seen[k]->given.place, seen[k]->given.name, *campaign.part.diameter_mm / ratio,
        *campaign.part.diameter_mm);
  }
}

}  // namespace

void rescale(Track& track, const vision::Scale& scale) {
  const double factor = scale.mm_per_px / *track.mm_per_px;
  for (auto* lengths : {&track.table.position, &track.table.marker})
    for (Eigen::Vector2d& p : *lengths) p *= factor;
  for (Eigen::Matrix2d& c : track.table.covariance) c *= factor * factor;
  for (fit::SlowError& slow : track.table.slow) slow.sd *= factor;
  for (auto* lengths : {&track.table.marker_sigma, &track.x_mm, &track.y_mm})
    for (double& x : *lengths) x *= factor;
  track.table.radius *= factor;
  track.mm_per_px = scale.mm_per_px;
  track.mm_per_px_sd = scale.sd;
}

std::optional<SharedScale> share_scale(const Campaign& campaign, std::vector<Run>& runs) {
  set_aside_repeated(runs);
  set_aside_other_parts(campaign, runs);
  std::vector<vision::Scale> scales;
  double of_rim = 0;
  for (const Run& run : runs)
    if (scaled_in_picture(run)) {
      scales.push_back({*run.track->mm_per_px, *run.track->mm_per_px_sd, ""});
      of_rim = of_rim == 0 ? common_of_rim(run) : std::min(of_rim, common_of_rim(run));
    }
  if (scales.size() < 2) return std::nullopt;
  SharedScale shared;
  const double common = std::hypot(length_error(campaign), of_rim);
  shared.pooled = vision::pooled_scale(scales, common);
  if (!shared.pooled.one_scale) {
    shared.finding = fmt::format(
        "{} is not the same in all {} recordings (they scatter by {:.2g} %, chi2 {:.3g}): did the camera "
        "move? each keeps its own scale",
        campaign.camera.tag_mm ? "the tag's side" : "the part's diameter", shared.pooled.count,
        100 * shared.pooled.scatter / shared.pooled.scale.mm_per_px, shared.pooled.chi2);
    return shared;
  }
  shared.finding = fmt::format(
      "{} recordings share one scale, {} mm/px (chi2 {:.3g}{})", shared.pooled.count,
      quoted(shared.pooled.scale.mm_per_px, shared.pooled.scale.sd), shared.pooled.chi2,
      shared.pooled.scatter > 0 ? fmt::format("; they scatter by {:.2g} % beyond their own sds, as edges on "
                                              "differing backgrounds do: the sd of the mean includes it",
                                              100 * shared.pooled.scatter / shared.pooled.scale.mm_per_px)
                                : "");
  for (Run& run : runs) {
    if (!scaled_in_picture(run)) continue;
    rescale(*run.track, shared.pooled.scale);
    try {
      measure_again(campaign, run);
    } catch (const std::exception& error) {
      run.failure = failure_of(run.given, error);
    }
  }
  return shared;
}

void add_to(Json& fit, const std::optional<SharedScale>& shared) {
  if (!shared) return;
  fit["shared_scale"] = {{"used", shared->pooled.one_scale},
                         {"runs", shared->pooled.count},
                         {"mm_per_px", shared->pooled.scale.mm_per_px},
                         {"mm_per_px_sd", shared->pooled.scale.sd},
                         {"scatter_mm_per_px", shared->pooled.scatter},
                         {"chi2", shared->pooled.chi2},
                         {"finding", shared->finding}};
  if (!shared->pooled.one_scale) fit["warnings"].push_back(shared->finding);
}

namespace {

/// The farthest that the part gets from where it was first seen.
double way_of(const fit::TrackTable& track) {
  double way = 0;
  for (const auto& position : track.position) way = std::max(way, (position - track.position.front()).norm());
  return way;
}

}  // namespace

std::vector<std::string> suspicious_runs(const fit::Problem& problem, const fit::FitResult& result) {
  constexpr double kShare = 0.1;
  std::vector<std::string> sentences;
  if (result.usable()) return sentences;
  for (const fit::RunResult& fitted : result.runs) {
    const auto run = std::ranges::find(problem.trajectory_runs, fitted.name, &fit::TrajectoryRun::name);
    if (run == problem.trajectory_runs.end() || !run->free_slide ||
        fitted.rms_m < kShare * way_of(run->track))
      continue;
    sentences.push_back(
        fmt::format("run \"{}\" is given as kind = \"free_slide\", but its points lie {:.2g} mm off the "
                    "slide: is it the recording of a driven run, or do `frames` hold more than the slide?",
                    fitted.name, 1e3 * fitted.rms_m));
  }
  return sentences;
}

}  // namespace tribotrack::apps
