// What one run alone is known by, and how well.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "fit/conditions.h"
#include "fit/pooling.h"
#include "fit/tools/angles.h"

namespace tribotrack::fit {

using model::Parameter;

namespace {

Eigen::Index index_of(const OwnErrors& own, Parameter parameter) {
  return std::ranges::find(own.parameters, parameter) - own.parameters.begin();
}

Eigen::Index place_of(OwnErrors& own, Parameter parameter) {
  const Eigen::Index place = index_of(own, parameter);
  if (place == static_cast<Eigen::Index>(own.parameters.size())) {
    own.parameters.push_back(parameter);
    own.covariance.conservativeResizeLike(Eigen::MatrixXd::Zero(place + 1, place + 1));
  }
  return place;
}

double square(double x) {
  return x * x;
}

/// The coder's share of a phase's variance is common to all runs and counted there.
double without_coder(double sd, double coder_delay) {
  return std::max(0.0, square(sd) - square(coder_delay));
}

/// The same angle a whole number of turns away, nearest to another.
Estimate turned_next_to(double place, const Estimate& angle) {
  return {place + std::remainder(angle.value - place, internal::turn), angle.sd};
}

}  // namespace

void OwnErrors::add(Parameter parameter, double variance) {
  if (!(variance > 0)) return;
  const Eigen::Index i = place_of(*this, parameter);
  covariance(i, i) += variance;
}

void OwnErrors::add(Parameter one, Parameter other, double both) {
  if (both == 0) return;
  const Eigen::Index i = place_of(*this, one), j = place_of(*this, other);
  covariance(i, j) += both;
  covariance(j, i) += both;
}

double OwnErrors::sd(Parameter parameter) const {
  const Eigen::Index i = index_of(*this, parameter);
  return i == static_cast<Eigen::Index>(parameters.size()) ? 0 : std::sqrt(covariance(i, i));
}

OwnErrors OwnErrors::without(Parameter parameter) const {
  OwnErrors rest;
  for (std::size_t i = 0; i < parameters.size(); ++i)
    for (std::size_t j = 0; j <= i; ++j) {
      if (parameters[i] == parameter || parameters[j] == parameter) continue;
      const double c = covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      if (i == j)
        rest.add(parameters[i], c);
      else
        rest.add(parameters[i], parameters[j], c);
    }
  return rest;
}

Timing settle_timing(const RunEvidence& run) {
  enum { kPhi, kDtau, kStart };
  Eigen::VectorXd values(3);
  values << run.phi.value, run.dtau.value, run.start;
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(3, 3);
  const double zero_sd = run.phase_at_zero ? run.phase_at_zero->sd : 0;

  if (run.seen) {  // by the run's own w: independent of what the other runs show
    const PlatformMotion& seen = *run.seen;
    covariance(kStart, kStart) = without_coder(seen.phase_at_middle.sd, run.coder_delay) +
                                 square((run.start_time - seen.middle_time) * seen.angular_frequency.sd);
    if (zero_sd > 0) {
      const double given = run.phase_at_zero->value + seen.angular_frequency.value * run.start_time;
      take_in(values, covariance, kStart, turned_next_to(values(kStart), {given, zero_sd}));
    }
  } else if (run.start_assumed && run.start_phase) {
    values(kStart) = run.start_phase->value;
    covariance(kStart, kStart) = square(run.start_phase->sd);
  } else {
    covariance(kStart, kStart) = square(zero_sd);
  }

  if (run.gate) {
    const GateTiming& gate = *run.gate;
    values.head<2>() << gate.phi.value, gate.dtau.value;
    covariance(kPhi, kPhi) =
        run.gate_by_camera ? without_coder(gate.phi.sd, run.coder_delay) : square(gate.phi.sd);
    covariance(kDtau, kDtau) = square(gate.dtau.sd);
    covariance(kPhi, kDtau) = covariance(kDtau, kPhi) = gate.covariance;
    if (run.gate_by_camera) {  // both hold the error of the platform's phase
      const double of_clock =
          run.seen ? without_coder(run.seen->phase_at_middle.sd, run.coder_delay) : square(zero_sd);
      if (!run.seen) covariance(kPhi, kPhi) += of_clock;
      covariance(kPhi, kStart) = covariance(kStart, kPhi) = of_clock;
    }
    if (run.dtau.sd > 0) take_in(values, covariance, kDtau, run.dtau);
    if (run.phi.sd > 0 && !run.gate_by_camera)
      take_in(values, covariance, kPhi, turned_next_to(values(kPhi), run.phi));
  } else {
    covariance(kPhi, kPhi) = square(run.phi.sd);
    covariance(kDtau, kDtau) = square(run.dtau.sd);
  }

  Timing timing{values(kPhi), std::clamp(values(kDtau), 0.0, internal::turn), values(kStart), {}};
  const Parameter names[] = {Parameter::phi, Parameter::dtau, Parameter::start_phase};
  for (Eigen::Index i = 0; i < 3; ++i) timing.own.add(names[i], covariance(i, i));
  for (Eigen::Index i = 0; i < 3; ++i)
    for (Eigen::Index j = 0; j < i; ++j) timing.own.add(names[i], names[j], covariance(i, j));
  return timing;
}

}  // namespace tribotrack::fit
