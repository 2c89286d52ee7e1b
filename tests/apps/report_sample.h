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
  run.kind = "displacement";
  run.phi_rad = phi;
  run.dtau_rad = dtau;
  run.modelled_alpha_rad = alpha_of(phi, dtau);
  run.modelled_v_mm_s = v_of(dtau);
  run.v_sd_mm_s = 0.02;
  run.alpha_sd_rad = run.v_sd_mm_s / run.modelled_v_mm_s;
  run.alpha_rad = alpha_of(phi + run.alpha_sd_rad * normal(random), dtau);
  run.v_mm_s = run.modelled_v_mm_s + run.v_sd_mm_s * normal(random);
  run.cycles = 20;
  run.frames_ok = 500;
  run.frames_lost = phi > 5 ? 3 : 0;
  run.frame_rate_hz = 250;
  run.time_base = "camera header";
  run.sigma_px = 0.0123;
  run.residuals = {{"dx_mm", 1.0, 1.01, 0.01, normal(random)}, {"dy_mm", 1.0, 1.01, 0.01, normal(random)}};
  run.influence = {0.1 * normal(random), 0.1 * normal(random), 0.1 * normal(random)};
  run.plan = {{"rotation of the part", false, "the part turns by 0.1° in 500 frames", 0.002},
              {"marker", true, "the platform moves by 7 px", no_value}};

  run.frame_width_px = 240;
  run.frame_height_px = 150;
  run.first_frame = kPng;
  for (int i = 0; i <= 500; ++i) {
    const double time = i / 250.0, turn = 62.8 * time;
    const double radius_mm = 0.22;
    double x = run.v_mm_s * time * std::cos(run.alpha_rad) + radius_mm * (std::cos(turn) - 1);
    double y = run.v_mm_s * time * std::sin(run.alpha_rad) + radius_mm * std::sin(turn);
    if (phi > 5 && i >= 200 && i < 203) x = y = no_value;
    run.x_mm.push_back(x);
    run.y_mm.push_back(y);
    run.time_s.push_back(time);
    run.sigma_all_px.push_back(std::isnan(x) ? no_value : 0.0123);
    run.ncc.push_back(std::isnan(x) ? no_value : 0.99);
    run.model_x_mm.push_back(run.modelled_v_mm_s * time * std::cos(run.modelled_alpha_rad));
    run.model_y_mm.push_back(run.modelled_v_mm_s * time * std::sin(run.modelled_alpha_rad));
    if (i % 25 == 0 && !std::isnan(x)) {
      run.cycle_x_mm.push_back(x);
      run.cycle_y_mm.push_back(y);
    }
    run.x_px.push_back(110 + x / 0.12);
    run.y_px.push_back(80 - y / 0.12);
  }
  return run;
}

inline ReportSlide slide(std::mt19937& random) {
  std::normal_distribution<double> normal;
  ReportSlide slide;
  slide.name = "struck disc";
  slide.sentence = "Initial speed 612 mm/s; this run alone gives μ1 = 0.1004 ± 0.0011.";
  for (int i = 0; i < 100; ++i) {
    const double time = i / 240.0;
    slide.time_s.push_back(time);
    slide.fitted_mm.push_back(612 * time - 0.5 * 981 * time * time);
    slide.position_mm.push_back(slide.fitted_mm.back() + 0.03 * normal(random));
    slide.sigma_mm.push_back(0.03);
  }
  return slide;
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
  data.converged = true;
  data.parameters = {
      {"mu1", 0.100123, 0.00031, {0.09952, 0.10073}, {}, {0.09952, 0.10073}, {0.09949, 0.10079}},
      {"mu2", 0.01262, 0.00042, {0.01182, 0.01347}, {}, {0.01182, 0.01347}, {0.01175, 0.01352}},
      {"phase_lag_rad", 0.2991, 0.0046, {0.2901, 0.3081}, {}, {0.2901, 0.3081}, {0.2899, 0.3084}}};
  for (ReportParameter& p : data.parameters) {
    p.profile.level = 3.84;
    for (const double z : {-1.96, -1.0, 0.0, 1.0, 1.96}) {
      p.profile.value.push_back(p.estimate + z * p.sd);
      p.profile.rise.push_back(z * z);
    }
  }
  data.budget = {{.source = "tracking noise",
                  .quantity = "",
                  .from = "the runs' own sds",
                  .contribution = {0.00029, 0.0004, 0.0044}},
                 {.source = "scale",
                  .quantity = "mm_per_px",
                  .from = "campaign",
                  .sd = 1e-5,
                  .contribution = {0.0001, 0.0001, 0.001}},
                 {.source = "gravity",
                  .quantity = "gravity_m_s2",
                  .from = "taken as exact",
                  .sd = 0.0981,
                  .counted = false,
                  .contribution = {0.001, 0.0001, 0}}};
  data.improve_first = "Improve first: tracking noise (88 % of the variance of mu1): film more runs.";
  data.given = {{"amplitude_mm", 0.28, "measured from the marker"},
                {"angular_frequency_rad_s", 62.8, "measured from the marker"},
                {"phase_shift_rad", pi / 2, "campaign"},
                {"gravity_m_s2", 9.81, "campaign"}};
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
                      .from = "marker, 14 runs"}};
  data.correlation = {{1, 0.42, -0.13}, {0.42, 1, -0.71}, {-0.13, -0.71, 1}};
  data.chi2 = 26.4;
  data.dof = 27;
  data.agreement = fit::Agreement::good;
  data.covariance_meaning =
      "The covariance is that of the measurement errors, not enlarged by the residuals.";
  data.next_experiment =
      "A run at φ = 3π/4 and Δτ = π would shrink the interval of μ2 most: from ± 0.00042 to ± 0.00025.";

  for (int k = 0; k < 8; ++k) data.runs.push_back(displacement_run(k * pi / 4, pi / 3, random));
  for (const int k : {1, 3, 4, 5, 6}) data.runs.push_back(displacement_run(0, k * pi / 6, random));
  ReportRun elsewhere;
  elsewhere.name = "from the notebook";
  elsewhere.kind = "displacement";
  elsewhere.phi_rad = 0;
  elsewhere.dtau_rad = 7 * pi / 6;
  elsewhere.alpha_rad = alpha_of(0.02, 7 * pi / 6);
  elsewhere.alpha_sd_rad = 0.02;
  elsewhere.v_mm_s = 3.93;
  elsewhere.v_sd_mm_s = 0.04;
  elsewhere.modelled_alpha_rad = alpha_of(0, 7 * pi / 6);
  elsewhere.modelled_v_mm_s = v_of(7 * pi / 6);
  elsewhere.residuals = {{"dx_mm", 1, 1, 0.01, 0.7}, {"dy_mm", 1, 1, 0.01, -2.4}};
  data.runs.push_back(elsewhere);
  ReportRun failed;
  failed.name = "phi90_dtau90";
  failed.video = "phi90_dtau90.cine";
  failed.failure = "phi90_dtau90.cine ends after 212 of 500 images; record or copy it again.";
  data.runs.push_back(failed);
  ReportRun struck;
  struck.name = "struck disc";
  struck.video = "free_slide.mp4";
  struck.kind = "free_slide";
  struck.frames_ok = 100;
  struck.frames_edge = 22;
  struck.frame_rate_hz = 240;
  struck.time_base = "campaign";
  struck.sigma_px = 0.031;
  struck.notes = {"Measured in the camera's frame: no marker."};
  data.runs.push_back(struck);
  data.slides.push_back(slide(random));

  data.over_phi = group_over_phi(data.runs);
  for (ReportGroup& group : data.over_phi) {
    group.curve_x_rad = curve_phis(group, data.runs);
    for (const double phi : group.curve_x_rad) {
      group.curve_alpha_rad.push_back(alpha_of(phi, group.shared_rad));
      group.curve_v_mm_s.push_back(v_of(group.shared_rad));
      group.curve_alpha_sd_rad.push_back(0.01);
      group.curve_v_sd_mm_s.push_back(0.02);
    }
  }
  data.over_dtau = group_over_dtau(data.runs);
  for (ReportGroup& group : data.over_dtau) {
    group.curve_x_rad = curve_dtaus(group, data.runs);
    for (const double dtau : group.curve_x_rad) {
      group.curve_alpha_rad.push_back(alpha_of(group.shared_rad, dtau));
      group.curve_v_mm_s.push_back(v_of(dtau));
      group.curve_alpha_sd_rad.push_back(0.01);
      group.curve_v_sd_mm_s.push_back(0.02);
    }
  }
  data.program_version = "0.1.0";
  data.inputs = {{"campaign.toml", "xxh3-128:0123456789abcdef0123456789abcdef"},
                 {"phi0_dtau60.cine", "xxh3-128:fedcba9876543210fedcba9876543210"}};
  data.configuration =
      "[platform]\namplitude_mm = 0.28\n\n[fit]\nparameters = [\"mu1\", \"mu2\", \"phase_lag_rad\"]\n";
  return data;
}

}  // namespace tribotrack::apps::sample
