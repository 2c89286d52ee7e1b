#include "apps/campaign/shared_errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "apps/campaign/own_errors.h"
#include "apps/files/camera.h"

namespace tribotrack::apps {

using fit::FitParameter;
using model::Parameter;

namespace {

bool takes_part(const Run& run) {
  return run.takes_part();
}
bool driven(const Run& run) {
  return takes_part(run) && !run.given.free_slide;
}
bool scaled(const Run& run) {
  return takes_part(run) && run.track && run.track->mm_per_px && *run.track->mm_per_px > 0;
}
bool scaled_by_diameter(const Run& run) {
  return scaled(run) && run.track->scale_source == kScaledByDiameter;
}

/// By a length that each recording shows.
bool scaled_in_picture(const Run& run) {
  return scaled_by_diameter(run) || (scaled(run) && run.track->scale_source == kScaledByTag);
}

double scale_sd(const Run& run) {
  return run.track->mm_per_px_sd.value_or(0) / *run.track->mm_per_px;
}

/// Mean over the runs that are counted; 0 for none.
double mean_over(const std::vector<Run>& runs, bool (*counted)(const Run&),
                 const std::function<double(const Run&)>& of) {
  double sum = 0;
  int count = 0;
  for (const Run& run : runs)
    if (counted(run)) {
      sum += of(run);
      ++count;
    }
  return count > 0 ? sum / count : 0;
}

bool is_length(Parameter quantity) {
  return quantity == Parameter::amplitude || quantity == Parameter::amplitude_y;
}

bool one_scale(const std::vector<Run>& runs) {
  std::optional<double> first;
  for (const Run& run : runs) {
    if (!scaled(run)) continue;
    if (!first) first = *run.track->mm_per_px;
    if (*run.track->mm_per_px != *first) return false;
  }
  return true;
}

/// What the scales of all runs share, relative.
double common_scale_error(const Campaign& campaign, const std::vector<Run>& runs) {
  if (one_scale(runs)) return mean_over(runs, scaled, scale_sd);
  return mean_over(runs, scaled, [&](const Run& run) {
    return scaled_in_picture(run) ? std::min(length_error(campaign), scale_sd(run)) : scale_sd(run);
  });
}

/// Of the scale at the part's top over that of the platform, 1 - height/distance, relative.
double parallax_error(const Campaign& campaign) {
  const PartSection& part = campaign.part;
  const CameraSection& camera = campaign.camera;
  if (!part.height_sd_mm && !camera.working_distance_sd_mm) return 0;
  const double height = *part.height_mm;
  const double distance =
      camera.calibration ? read_calibration(*camera.calibration).distance_mm() : *camera.working_distance_mm;
  return std::hypot(part.height_sd_mm.value_or(0) / distance,
                    height * camera.working_distance_sd_mm.value_or(0) / (distance * distance)) /
         (1 - height / distance);
}

/// Of the camera's clock, relative.
double clock_error(const Campaign& campaign) {
  const CameraSection& camera = campaign.camera;
  return camera.frame_rate_sd_hz ? *camera.frame_rate_sd_hz / *camera.frame_rate_hz : 0;
}

double coder_attenuation(const Run& run) {
  return run.measurement && run.measurement->coded ? run.measurement->coded->attenuation : 0;
}
double coder_delay(const Run& run) {
  return run.measurement && run.measurement->coded ? run.measurement->coded->delay : 0;
}
double exposure_doubt(const Run& run) {
  return run.measurement && run.measurement->platform ? run.measurement->platform->exposure_doubt : 0;
}

bool counts_from_camera(const Run& run) {
  return run.measurement && run.measurement->gate && run.measurement->gate_reference == "camera";
}

class Errors {
 public:
  Errors(const Campaign& campaign, std::vector<Run>& runs, const std::map<Parameter, SharedQuantity>& found,
         SharedConditions& shared)
      : campaign_(campaign), runs_(runs), found_(found), shared_(shared) {}

  void amplitudes(bool one_amplitude) {
    const SharedQuantity x = of(Parameter::amplitude), y = of(Parameter::amplitude_y);
    if (one_amplitude) {
      add(FitParameter::amplitude, x.shared_sd, x.from, x.given_with_sd);
    } else {  // independent errors of both: of their mean and of their ratio, which do not go together
      const double both = std::hypot(x.shared_sd, y.shared_sd);
      const std::string& from = x.shared_sd > 0 ? x.from : y.from;
      add(FitParameter::amplitude, both / 2, from, x.given_with_sd || y.given_with_sd);
      add(FitParameter::amplitude_ratio, both, from);
    }
    const auto if_from_track = [](double (*of_run)(const Run&)) {
      return [of_run](const Run& run) { return run.amplitude_from_track ? of_run(run) : 0; };
    };
    add(FitParameter::amplitude, mean_over(runs_, driven, if_from_track(coder_attenuation)), fit::kFromCoder);
    add(FitParameter::amplitude, mean_over(runs_, driven, if_from_track(exposure_doubt)),
        "exposure, not known");
    exact_if(x.exact, "amplitude_mm");
    exact_if(y.exact || (one_amplitude && x.shared_sd > 0), "amplitude_y_mm");
  }

  void frequency_and_phase_shift() {
    const SharedQuantity w = of(Parameter::angular_frequency), epsilon = of(Parameter::phase_shift);
    add(FitParameter::angular_frequency, w.shared_sd, w.from, w.given_with_sd);
    add(FitParameter::phase_shift, epsilon.shared_sd, epsilon.from);
    exact_if(w.exact, "angular_frequency_rad_s");
    exact_if(any_driven() && (epsilon.exact || !found_.contains(Parameter::phase_shift)), "phase_shift_rad");
  }

  /// All that is measured, w included, in seconds that are too long by a share: then g, the one quantity that
  /// is known in true seconds, is off by twice that. With w given in true seconds the displacement is read
  /// too late by that share.
  void clock() {
    const bool own_clock = !any_driven() || of(Parameter::angular_frequency).measured;
    const double error = clock_error(campaign_);
    const char* from = "frame_rate_hz_sd, campaign";
    if (own_clock)
      add(FitParameter::gravity, 2 * error, from);
    else
      add(FitParameter::scale, error, from);
    exact_if(campaign_.camera.frame_rate_hz && error == 0, "frame_rate_hz");
  }

  void gravity_and_tilt() {
    const PlatformSection& p = campaign_.platform;
    add(FitParameter::gravity, p.gravity_sd.value_or(0) / p.gravity, "gravity_m_s2_sd, campaign", true);
    add(FitParameter::tilt_x, p.tilt_x_sd.value_or(0), "tilt_x_rad_sd, campaign", true);
    add(FitParameter::tilt_y, p.tilt_y_sd.value_or(0), "tilt_y_rad_sd, campaign", true);
    exact_if(!p.gravity_sd, "gravity_m_s2");
    exact_if(!p.tilt_x_sd && !fitted(FitParameter::tilt_x), "tilt_x_rad");
    exact_if(!p.tilt_y_sd && !fitted(FitParameter::tilt_y), "tilt_y_rad");
  }

  /// One instrument measures the slopes of all inclines.
  void slope() {
    const auto inclined = [](const Run& run) { return takes_part(run) && run.given.slope.has_value(); };
    const double sd =
        mean_over(runs_, inclined, [](const Run& run) { return run.given.slope_sd.value_or(0); });
    add(FitParameter::slope, sd, "slope_rad_sd, campaign", true);
    exact_if(sd == 0 && std::any_of(runs_.begin(), runs_.end(), inclined), "slope_rad");
  }

  void scale() {
    const bool by_diameter = std::any_of(runs_.begin(), runs_.end(), scaled_by_diameter);
    const double all = mean_over(runs_, scaled, scale_sd);
    if (by_diameter) {
      const double diameter = std::min(length_error(campaign_), all);
      add(FitParameter::scale, diameter, "diameter_mm_sd, campaign", true);
      add(FitParameter::scale, std::sqrt(all * all - diameter * diameter), "part's radius in the pictures",
          true);
      exact_if(diameter == 0, "diameter_mm");
    } else {
      const CameraSection& camera = campaign_.camera;
      add(FitParameter::scale, all,
          camera.calibration ? "calibration"
          : camera.tag_mm    ? "the tag's size, and its sides in the pictures"
                             : "mm_per_px_sd, campaign",
          true);
      exact_if(camera.tag_mm && camera.tag_mm_sd == 0, "tag_mm");
      exact_if(all == 0 && std::any_of(runs_.begin(), runs_.end(), scaled), "mm_per_px");
    }
    const double parallax = parallax_error(campaign_);
    const char* from = "height and working distance, campaign";
    if (!by_diameter) add(FitParameter::scale, parallax, from);
    if (of(Parameter::amplitude).measured) add(FitParameter::amplitude, parallax, from);
  }

  void phase_reference() {
    add(FitParameter::phase_reference, mean_over(runs_, driven, coder_delay), fit::kFromCoder);
    std::size_t by_sensor = 0, all = 0;
    for (const Run& run : runs_)
      if (driven(run)) {
        ++all;
        by_sensor += !counts_from_camera(run);
      }
    const auto sd = campaign_.camera.xi_axis_sd_rad;
    exact_if(by_sensor > 0 && !sd, "xi_axis_rad");
    if (!sd || all == 0) return;
    if (by_sensor == all)
      add(FitParameter::phase_reference, *sd, "xi_axis_rad_sd, campaign");
    else if (by_sensor == 0)
      shared_.warnings.push_back(
          "xi_axis_rad_sd is not used: phi was measured in the camera's own phase in every run, a turned "
          "camera cancels");
    else
      for (Run& run : runs_)
        if (driven(run) && !counts_from_camera(run)) add_error(run.own, Parameter::phi, *sd * *sd);
  }

  void gates() {
    bool phi = false, dtau = false;
    for (const Run& run : runs_) {
      if (!driven(run) || (run.measurement && run.measurement->gate)) continue;
      phi = phi || !run.given.phi_sd;
      dtau = dtau || !run.given.dtau_sd;
    }
    exact_if(phi, "phi_rad");
    exact_if(dtau, "dtau_rad");
  }

 private:
  SharedQuantity of(Parameter parameter) const {
    const auto place = found_.find(parameter);
    return place == found_.end() ? SharedQuantity{} : place->second;
  }
  bool any_driven() const { return std::any_of(runs_.begin(), runs_.end(), driven); }
  bool fitted(FitParameter parameter) const {
    const auto& free = campaign_.fit.parameters;
    return std::find(free.begin(), free.end(), parameter) != free.end();
  }
  void add(FitParameter quantity, double sd, const std::string& from, bool known_beforehand = false) {
    if (sd > 0) shared_.errors.push_back({quantity, sd, from, known_beforehand});
  }
  void exact_if(bool exact, const char* key) {
    if (exact) shared_.taken_as_exact.emplace_back(key);
  }

  const Campaign& campaign_;
  std::vector<Run>& runs_;
  const std::map<Parameter, SharedQuantity>& found_;
  SharedConditions& shared_;
};

}  // namespace

double length_error(const Campaign& campaign) {
  if (campaign.camera.tag_mm) return campaign.camera.tag_mm_sd / *campaign.camera.tag_mm;
  const PartSection& part = campaign.part;
  return part.diameter_mm ? part.diameter_sd_mm / *part.diameter_mm : 0;
}

double own_sd(const Campaign& campaign, const std::vector<Run>& runs, const Run& run, Parameter quantity,
              const fit::Estimate& seen) {
  if (!is_length(quantity)) return seen.sd;
  const double common = std::hypot(coder_attenuation(run), exposure_doubt(run)) * seen.value;
  double variance = std::max(0.0, seen.sd * seen.sd - common * common);
  if (scaled_in_picture(run) && !one_scale(runs)) {
    const double all = scale_sd(run), shared = std::min(length_error(campaign), all);
    variance += (all * all - shared * shared) * seen.value * seen.value;
  }
  return std::sqrt(variance);
}

double common_error(const Campaign& campaign, const std::vector<Run>& runs, Parameter quantity) {
  if (quantity == Parameter::angular_frequency) return clock_error(campaign);
  if (!is_length(quantity)) return 0;
  const double seen =
      std::hypot(mean_over(runs, driven, coder_attenuation), mean_over(runs, driven, exposure_doubt));
  return std::hypot(seen, common_scale_error(campaign, runs), parallax_error(campaign));
}

void add_errors(const Campaign& campaign, std::vector<Run>& runs,
                const std::map<Parameter, SharedQuantity>& found, bool one_amplitude,
                SharedConditions& shared) {
  Errors errors(campaign, runs, found, shared);
  errors.amplitudes(one_amplitude);
  errors.frequency_and_phase_shift();
  errors.clock();
  errors.gravity_and_tilt();
  errors.slope();
  errors.scale();
  errors.phase_reference();
  errors.gates();
}

}  // namespace tribotrack::apps
