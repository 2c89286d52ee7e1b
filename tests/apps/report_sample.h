// A campaign as a researcher would have it, made up from closed forms: eight phi at one dtau, six dtau at phi
// = 0, one run measured elsewhere, one that failed, one free slide; with pictures.
#pragma once

#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "apps/report/data/curves.h"
#include "apps/report/data/data.h"

namespace tribotrack::apps::sample {

inline constexpr double pi = std::numbers::pi;

/// Two pixels, black and white.
inline const std::vector<unsigned char> kPng = {
    137, 80, 78, 71, 13, 10, 26,  10, 0,   0,   0, 13, 73, 72, 68, 82, 0,  0,  0,   2,   0,  0,  0,
    1,   8,  0,  0,  0,  0,  209, 73, 32,  86,  0, 0,  0,  11, 73, 68, 65, 84, 120, 218, 99, 96, 248,
    15,  0,  1,  2,  1,  0,  209, 26, 203, 143, 0, 0,  0,  0,  73, 69, 78, 68, 174, 66,  96, 130};

inline double alpha_of(double phi, double dtau) {
  const double alpha = phi + 5.4 - 0.35 * dtau;
  return alpha - 2 * pi * std::floor(alpha / (2 * pi));
}
inline double v_of(double dtau) {
  return 4.2 * std::sin(dtau / 3);
}

inline std::string video_name(double phi, double dtau) {
  return "phi" + std::to_string(std::lround(phi * 180 / pi)) + "_dtau" +
         std::to_string(std::lround(dtau * 180 / pi)) + ".cine";
}

inline ReportRun displacement_run(double phi, double dtau, std::mt19937& random) {
  std::normal_distribution<double> normal;
  ReportRun run;
  run.video = video_name(phi, dtau);
  run.name = run.video.substr(0, run.video.size() - 5);
  run.phi_rad = phi;
  run.dtau_rad = dtau;
  const double alpha = alpha_of(phi, dtau), v = v_of(dtau), v_sd = 0.02, alpha_sd = v_sd / v;
  run.measured["alpha_rad"] = {alpha_of(phi + alpha_sd * normal(random), dtau), alpha_sd};
  run.measured["v_mm_s"] = {v + v_sd * normal(random), v_sd};
  run.cycles = 20;
  run.sigma_px = 0.0123;
  run.fitted.residuals = {{"dx_mm", 1.0, 1.01, 0.01, normal(random)},
                          {"dy_mm", 1.0, 1.01, 0.01, normal(random)},
                          {"alpha_rad", run.value("alpha_rad").value, alpha, alpha_sd, no_value},
                          {"v_mm_s", run.value("v_mm_s").value, v, v_sd, no_value}};
  run.fitted.influence = {0.1 * normal(random), 0.1 * normal(random), 0.1 * normal(random)};

  Track& track = run.track;
  track.lost = phi > 5 ? 3 : 0;
  track.frames = 500 + track.lost;
  track.frame_rate_hz = 250;
  track.time_base = "camera header";
  track.plan = {{"rotation of the part", false, "the part turns by 0.1° in 500 frames", 0.002},
                {"marker", true, "the platform moves by 7 px", {}}};
  track.width_px = 240;
  track.height_px = 150;
  run.first_frame = kPng;
  for (int i = 0; i <= 500; ++i) {
    const double time = i / 250.0, turn = 62.8 * time;
    const double radius_mm = 0.22, way = run.value("v_mm_s").value * time;
    double x = way * std::cos(run.value("alpha_rad").value) + radius_mm * (std::cos(turn) - 1);
    double y = way * std::sin(run.value("alpha_rad").value) + radius_mm * std::sin(turn);
    if (phi > 5 && i >= 200 && i < 203) x = y = no_value;
    track.x_mm.push_back(x);
    track.y_mm.push_back(y);
    track.time_s.push_back(time);
    track.sigma_px.push_back(std::isnan(x) ? no_value : 0.0123);
    track.ncc.push_back(std::isnan(x) ? no_value : 0.99);
    run.model_x_mm.push_back(v * time * std::cos(alpha));
    run.model_y_mm.push_back(v * time * std::sin(alpha));
    if (i % 25 == 0 && !std::isnan(x)) {
      run.cycle_x_mm.push_back(x);
      run.cycle_y_mm.push_back(y);
    }
    track.x_px.push_back(110 + x / 0.12);
    track.y_px.push_back(80 - y / 0.12);
  }
  return run;
}

inline ReportRun slide(std::mt19937& random) {
  std::normal_distribution<double> normal;
  ReportRun slide;
  slide.name = "struck disc";
  slide.video = "free_slide.mp4";
  slide.free_slide = true;
  slide.track.frames = 122;
  slide.track.edge = 22;
  slide.track.frame_rate_hz = 240;
  slide.track.time_base = "campaign";
  slide.sigma_px = 0.031;
  slide.notes = {"Measured in the camera's frame: no marker."};
  slide.fitted.nuisance["initial_speed_mm_s"] = 612;
  for (int i = 0; i < 100; ++i) {
    const double time = i / 240.0;
    slide.fitted.slide.time.push_back(time);
    slide.fitted.slide.modelled.push_back(0.612 * time - 0.5 * 0.981 * time * time);
    slide.fitted.slide.measured.push_back(slide.fitted.slide.modelled.back() + 3e-5 * normal(random));
  }
  return slide;
}

inline fit::ParameterEstimate parameter(fit::FitParameter which, double estimate, double sd,
                                        fit::Interval covariance, fit::Interval profile) {
  fit::ParameterEstimate p{.parameter = which,
                           .estimate = estimate,
                           .sd = sd,
                           .ci95 = covariance,
                           .ci95_pieces = {},
                           .covariance_ci95 = covariance,
                           .profile_ci95 = profile,
                           .profile = {},
                           .profile_level = 3.84,
                           .bootstrap_ci95 = {no_value, no_value}};
  for (const double z : {-1.96, -1.0, 0.0, 1.0, 1.96}) p.profile.push_back({estimate + z * sd, z * z});
  return p;
}

/// A source of the budget and what it gives to the three parameters.
inline fit::BudgetEntry source(const std::string& name, const std::string& quantity, double sd,
                               const std::string& from, bool counted, const Eigen::Vector3d& contribution) {
  return {name, quantity, sd, from, counted, contribution, {}};
}

/// `seed` only moves the made-up noise.
inline ReportData campaign(unsigned seed = 1) {
  std::mt19937 random(seed);
  ReportData data;
  data.title = "Silver-coated disc, 6 mm, on polished duralumin";
  data.warnings = {
      "Run 15 (phi90_dtau90) failed and is not part of the fit.",
      "Commanded φ was used without a gate in the picture: a camera turned by b against the phase sensor "
      "shows up as b in the lag."};
  fit::FitResult& fit = data.fit;
  fit.converged = true;
  fit.parameters = {
      parameter(fit::FitParameter::mu1, 0.100123, 0.00031, {0.09952, 0.10073}, {0.09949, 0.10079}),
      parameter(fit::FitParameter::mu2, 0.01262, 0.00042, {0.01182, 0.01347}, {0.01175, 0.01352}),
      parameter(fit::FitParameter::lag, 0.2991, 0.0046, {0.2901, 0.3081}, {0.2899, 0.3084})};
  fit.budget = {source("tracking noise", "", no_value, "the runs' own sds", true, {0.00029, 0.0004, 0.0044}),
                source("scale", "mm_per_px", 1e-5, "campaign", true, {0.0001, 0.0001, 0.001}),
                source("gravity", "gravity_m_s2", 0.0981, "taken as exact", false, {0.001, 0.0001, 0})};
  fit.improve_first = "Improve first: tracking noise (88 % of the variance of mu1): film more runs.";
  data.conditions = {{.quantity = "amplitude_mm",
                      .given = 0.281,
                      .measured = 0.279965,
                      .sd = 1.9e-5,
                      .difference_in_sd = -54.7,
                      .used = 0.281,
                      .from = "campaign, taken as exact"},
                     {.quantity = "phase_shift_rad",
                      .measured = 1.57081,
                      .sd = 2e-5,
                      .used = 1.57081,
                      .used_sd = 2e-5,
                      .from = "marker, 14 runs"},
                     {.quantity = "gravity_m_s2", .given = 9.81, .used = 9.81, .from = "campaign"}};
  fit.correlation.resize(3, 3);
  fit.correlation << 1, 0.42, -0.13, 0.42, 1, -0.71, -0.13, -0.71, 1;
  fit.chi2 = 26.4;
  fit.dof = 27;
  fit.p_value = no_value;
  fit.agreement = fit::Agreement::good;
  fit.verdict = fit::Use::use;
  fit.covariance_meaning = "The covariance is that of the measurement errors, not enlarged by the residuals.";
  fit.next_experiment = fit::NextExperiment{
      .phi = 0.75 * pi,
      .dtau = pi,
      .amplitude = 0.28e-3,
      .angular_frequency = 62.8,
      .aim = {},
      .predicted_sd = {},
      .predicted_ci95 = {},
      .sentence =
          "A run at φ = 3π/4 and Δτ = π would shrink the interval of μ2 most: from ± 0.00042 to ± 0.00025."};

  for (int k = 0; k < 8; ++k) data.runs.push_back(displacement_run(k * pi / 4, pi / 3, random));
  for (const int k : {1, 3, 4, 5, 6}) data.runs.push_back(displacement_run(0, k * pi / 6, random));
  ReportRun elsewhere;
  elsewhere.name = "from the notebook";
  elsewhere.phi_rad = 0;
  elsewhere.dtau_rad = 7 * pi / 6;
  elsewhere.measured["alpha_rad"] = {alpha_of(0.02, 7 * pi / 6), 0.02};
  elsewhere.measured["v_mm_s"] = {3.93, 0.04};
  elsewhere.fitted.residuals = {{"dx_mm", 1, 1, 0.01, 0.7},
                                {"dy_mm", 1, 1, 0.01, -2.4},
                                {"alpha_rad", 1, alpha_of(0, 7 * pi / 6), 0.02, no_value},
                                {"v_mm_s", 1, v_of(7 * pi / 6), 0.04, no_value}};
  data.runs.push_back(elsewhere);
  ReportRun failed;
  failed.name = "phi90_dtau90";
  failed.video = "phi90_dtau90.cine";
  failed.failure = "phi90_dtau90.cine ends after 212 of 500 images; record or copy it again.";
  data.runs.push_back(failed);
  data.runs.push_back(slide(random));

  for (const Over over : {Over::phi, Over::dtau}) {
    std::vector<ReportGroup>& groups = over == Over::phi ? data.over_phi : data.over_dtau;
    groups = groups_over(over, data.runs);
    for (ReportGroup& group : groups) {
      group.curve_x_rad = curve_angles(over, group, data.runs);
      for (const double x : group.curve_x_rad) {
        const double phi = over == Over::phi ? x : group.shared_rad,
                     dtau = over == Over::phi ? group.shared_rad : x;
        group.curve_alpha_rad.push_back(alpha_of(phi, dtau));
        group.curve_v_mm_s.push_back(v_of(dtau));
        group.curve_alpha_sd_rad.push_back(0.01);
        group.curve_v_sd_mm_s.push_back(0.02);
      }
    }
  }
  data.program_version = "0.1.0";
  data.inputs = {{"campaign.toml", "0123456789abcdef0123456789abcdef"},
                 {"phi0_dtau60.cine", "fedcba9876543210fedcba9876543210"}};
  data.configuration =
      "[platform]\namplitude_mm = 0.28\n\n[fit]\nparameters = [\"mu1\", \"mu2\", \"phase_lag_rad\"]\n";
  return data;
}

}  // namespace tribotrack::apps::sample
