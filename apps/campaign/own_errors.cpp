#include "apps/campaign/own_errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fit/pooling.h"

namespace tribotrack::apps {

using model::Parameter;

namespace {

constexpr double kTurn = 2 * std::numbers::pi;

Eigen::Index place_of(fit::OwnErrors& own, Parameter parameter) {
  const auto found = std::find(own.parameters.begin(), own.parameters.end(), parameter);
  const Eigen::Index place = found - own.parameters.begin();
  if (found == own.parameters.end()) {
    own.parameters.push_back(parameter);
    own.covariance.conservativeResizeLike(Eigen::MatrixXd::Zero(place + 1, place + 1));
  }
  return place;
}

double square(double x) {
  return x * x;
}

/// The coder's share of a phase's variance is common to all runs and counted there.
double without_coder(double sd, const RunMeasurement& measured) {
  const double coder = measured.coded ? measured.coded->delay : 0;
  return std::max(0.0, sd * sd - coder * coder);
}

/// The same angle a whole number of turns away, nearest to another.
fit::Estimate turned_next_to(double place, double angle, double sd) {
  return {place + std::remainder(angle - place, kTurn), sd};
}

/// Phase at the first frame by the run's own w: independent of what the other runs show.
double start_variance(const RunMeasurement& measured, double start_time) {
  const fit::PlatformMotion& p = *measured.platform;
  return without_coder(p.phase_at_middle.sd, measured) +
         square((start_time - p.middle_time) * p.angular_frequency.sd);
}

}  // namespace

void add_error(fit::OwnErrors& own, Parameter parameter, double variance) {
  if (!(variance > 0)) return;
  const Eigen::Index i = place_of(own, parameter);
  own.covariance(i, i) += variance;
}

void add_error(fit::OwnErrors& own, Parameter one, Parameter other, double covariance) {
  if (covariance == 0) return;
  const Eigen::Index i = place_of(own, one), j = place_of(own, other);
  own.covariance(i, j) += covariance;
  own.covariance(j, i) += covariance;
}

double sd_of(const fit::OwnErrors& own, Parameter parameter) {
  const auto found = std::find(own.parameters.begin(), own.parameters.end(), parameter);
  if (found == own.parameters.end()) return 0;
  const Eigen::Index i = found - own.parameters.begin();
  return std::sqrt(own.covariance(i, i));
}

fit::OwnErrors without(const fit::OwnErrors& own, const std::vector<Parameter>& parameters) {
  fit::OwnErrors rest;
  const auto kept = [&](std::size_t i) {
    return std::find(parameters.begin(), parameters.end(), own.parameters[i]) == parameters.end();
  };
  for (std::size_t i = 0; i < own.parameters.size(); ++i)
    for (std::size_t j = 0; j <= i; ++j) {
      if (!kept(i) || !kept(j)) continue;
      const double c = own.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      if (i == j)
        add_error(rest, own.parameters[i], c);
      else
        add_error(rest, own.parameters[i], own.parameters[j], c);
    }
  return rest;
}

fit::OwnErrors settle_timing(const CampaignRun& run, RunMeasurement& measured, model::Scenario& scenario) {
  enum { kPhi, kDtau, kStart };
  Eigen::VectorXd values(3);
  values << run.phi, run.dtau, measured.phase_at_start;
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(3, 3);
  const auto note = [&](const char* key, const std::string& why) {
    measured.warnings.push_back(fmt::format("{}: {} is not used: {}", run.name, key, why));
  };

  if (measured.platform) {
    const double start_time = measured.start_time;
    covariance(kStart, kStart) = start_variance(measured, start_time);
    if (run.phase_at_zero && run.phase_at_zero_sd) {
      const double given = *run.phase_at_zero + measured.platform->angular_frequency.value * start_time;
      fit::take_in(values, covariance, kStart, turned_next_to(values(kStart), given, *run.phase_at_zero_sd));
    }
    if (run.start_phase_sd) note("start_phase_rad_sd", "the phase at the start was measured");
  } else if (measured.phase_source == "assumed 0" && run.start_phase) {
    values(kStart) = *run.start_phase;
    covariance(kStart, kStart) = square(run.start_phase_sd.value_or(0));
  } else {
    covariance(kStart, kStart) = square(run.phase_at_zero_sd.value_or(0));
  }

  if (measured.gate) {
    const fit::GateTiming& gate = *measured.gate;
    const bool by_camera = measured.gate_reference == "camera";
    values.head<2>() << gate.phi.value, gate.dtau.value;
    covariance(kPhi, kPhi) = by_camera ? without_coder(gate.phi.sd, measured) : square(gate.phi.sd);
    covariance(kDtau, kDtau) = square(gate.dtau.sd);
    covariance(kPhi, kDtau) = covariance(kDtau, kPhi) = gate.covariance;
    if (by_camera) {  // both hold the error of the platform's phase
      const double of_clock = measured.platform
                                  ? without_coder(measured.platform->phase_at_middle.sd, measured)
                                  : square(run.phase_at_zero_sd.value_or(0));
      if (!measured.platform) covariance(kPhi, kPhi) += of_clock;
      covariance(kPhi, kStart) = covariance(kStart, kPhi) = of_clock;
    }
    if (run.dtau_sd) fit::take_in(values, covariance, kDtau, {run.dtau, *run.dtau_sd});
    if (run.phi_sd && !by_camera)
      fit::take_in(values, covariance, kPhi, turned_next_to(values(kPhi), run.phi, *run.phi_sd));
    if (run.phi_sd && by_camera)
      note("phi_rad_sd",
           "phi was measured in the camera's own phase, the commanded one counts from the sensor");
  } else {
    covariance(kPhi, kPhi) = square(run.phi_sd.value_or(0));
    covariance(kDtau, kDtau) = square(run.dtau_sd.value_or(0));
  }

  scenario.friction.phase = values(kPhi);
  scenario.friction.pulse_width = std::clamp(values(kDtau), 0.0, kTurn);
  scenario.start_phase = values(kStart);
  fit::OwnErrors own;
  const Parameter names[] = {Parameter::phi, Parameter::dtau, Parameter::start_phase};
  for (Eigen::Index i = 0; i < 3; ++i) add_error(own, names[i], covariance(i, i));
  for (Eigen::Index i = 0; i < 3; ++i)
    for (Eigen::Index j = 0; j < i; ++j) add_error(own, names[i], names[j], covariance(i, j));
  return own;
}

fit::OwnErrors timing_as_given(const CampaignRun& run, model::Scenario& scenario) {
  scenario.friction.phase = run.phi;
  scenario.friction.pulse_width = run.dtau;
  scenario.start_phase = run.start_phase.value_or(0);
  fit::OwnErrors own;
  add_error(own, Parameter::phi, square(run.phi_sd.value_or(0)));
  add_error(own, Parameter::dtau, square(run.dtau_sd.value_or(0)));
  add_error(own, Parameter::start_phase, square(run.start_phase_sd.value_or(0)));
  return own;
}

}  // namespace tribotrack::apps
