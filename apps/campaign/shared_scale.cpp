#include "apps/campaign/shared_scale.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tribotrack::apps {

namespace {

bool scaled_by_diameter(const AnalysedRun& run) {
  if (!run.failure.empty() || !run.track || !run.track->mm_per_px || !run.track->mm_per_px_sd) return false;
  const auto scale = run.track->meta.find("scale");
  return scale != run.track->meta.end() && scale->is_object() &&
         scale->value("source", "") == "part's diameter";
}

/// What the rim's model leaves of a highlight: relative to the radius, the same in every recording.
double common_of_rim(const AnalysedRun& run) {
  const auto summary = run.track->meta.find("summary");
  if (summary == run.track->meta.end() || !summary->is_object()) return 0;
  const Json disc = summary->value("disc_px", Json());
  const double radius = disc.is_array() && disc.size() == 3 ? disc[2].get<double>() : 0;
  return radius > 0 ? summary->value("disc_radius_common_sd_px", 0.0) / radius : 0;
}

}  // namespace

void rescale(TrackFile& track, const vision::Scale& scale) {
  const double factor = scale.mm_per_px / *track.mm_per_px;
  for (auto* lengths : {&track.table.position, &track.table.marker})
    for (Eigen::Vector2d& p : *lengths) p *= factor;
  for (Eigen::Matrix2d& c : track.table.covariance) c *= factor * factor;
  for (auto* lengths : {&track.table.marker_sigma, &track.x_mm, &track.y_mm})
    for (double& x : *lengths) x *= factor;
  track.mm_per_px = scale.mm_per_px;
  track.mm_per_px_sd = scale.sd;
}

std::optional<SharedScale> share_scale(const Campaign& campaign, std::vector<AnalysedRun>& runs) {
  std::vector<vision::Scale> scales;
  double of_rim = 0;
  for (const AnalysedRun& run : runs)
    if (scaled_by_diameter(run)) {
      scales.push_back({*run.track->mm_per_px, *run.track->mm_per_px_sd, ""});
      of_rim = of_rim == 0 ? common_of_rim(run) : std::min(of_rim, common_of_rim(run));
    }
  if (scales.size() < 2) return std::nullopt;
  SharedScale shared;
  const double common =
      std::hypot(campaign.diameter_mm ? campaign.diameter_sd_mm / *campaign.diameter_mm : 0, of_rim);
  shared.pooled = vision::pooled_scale(scales, common);
  shared.used = shared.pooled.one_scale;
  if (!shared.used) {
    shared.finding = fmt::format(
        "the part's diameter is not the same in all {} recordings (they scatter by {:.2g} %, chi2 {:.3g}): "
        "did "
        "the camera move? each keeps the scale of its own",
        shared.pooled.count, 100 * shared.pooled.scatter / shared.pooled.scale.mm_per_px, shared.pooled.chi2);
    return shared;
  }
  shared.finding = fmt::format(
      "{} recordings share one scale, {:.6g} +- {:.2g} mm/px (chi2 {:.3g}{})", shared.pooled.count,
      shared.pooled.scale.mm_per_px, shared.pooled.scale.sd, shared.pooled.chi2,
      shared.pooled.scatter > 0
          ? fmt::format("; beyond their own sds they scatter by {:.2g} %, as rims on differing "
                        "ground do: the mean's sd holds it",
                        100 * shared.pooled.scatter / shared.pooled.scale.mm_per_px)
          : "");
  for (AnalysedRun& run : runs) {
    if (!scaled_by_diameter(run)) continue;
    TrackFile track = std::move(*run.track);
    rescale(track, shared.pooled.scale);
    run = analyse(campaign, *run.run, std::move(track));
  }
  return shared;
}

void add_to(Json& fit, const std::optional<SharedScale>& shared) {
  if (!shared) return;
  fit["shared_scale"] = {{"used", shared->used},
                         {"runs", shared->pooled.count},
                         {"mm_per_px", shared->pooled.scale.mm_per_px},
                         {"mm_per_px_sd", shared->pooled.scale.sd},
                         {"scatter_mm_per_px", shared->pooled.scatter},
                         {"chi2", shared->pooled.chi2},
                         {"finding", shared->finding}};
  if (!shared->used) fit["warnings"].push_back(shared->finding);
}

}  // namespace tribotrack::apps
