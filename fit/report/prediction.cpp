#include "fit/prediction.h"

#include "fit/residuals/end_point.h"

namespace tribotrack::fit {
namespace {

constexpr double kTolerance = 1e-8;  // of the path: a line in a figure

/// d(model's parameter)/d(fitted parameter) for a scenario at the fitted values.
struct Link {
  model::Parameter parameter;
  double derivative;
};

std::vector<Link> links(const model::Scenario& s, FitParameter parameter, double estimate) {
  const double w = s.drive.angular_frequency;
  switch (parameter) {
    case FitParameter::mu1:
      return {{model::Parameter::mu1, 1}};
    case FitParameter::mu2:
      return {{model::Parameter::mu2, 1}};
    case FitParameter::lag:
    case FitParameter::phase_reference:
      return {{model::Parameter::lag, 1}};
    case FitParameter::delay:
      return {{model::Parameter::lag, w}};
    case FitParameter::amplitude:
      return {{model::Parameter::amplitude, s.drive.amplitude / estimate},
              {model::Parameter::amplitude_y, s.drive.amplitude_y / estimate}};
    case FitParameter::angular_frequency:
      return {{model::Parameter::angular_frequency, w / estimate}};
    case FitParameter::amplitude_ratio:
      return {{model::Parameter::amplitude, -0.5 * s.drive.amplitude / estimate},
              {model::Parameter::amplitude_y, 0.5 * s.drive.amplitude_y / estimate}};
    case FitParameter::phase_shift:
      return {{model::Parameter::phase_shift, 1}};
    case FitParameter::gravity:
      return {{model::Parameter::gravity, 1}};
    case FitParameter::tilt_x:
      return {{model::Parameter::tilt_x, 1}};
    case FitParameter::tilt_y:
      return {{model::Parameter::tilt_y, 1}};
    case FitParameter::scale:
    case FitParameter::slope:
      return {};
  }
  return {};
}

}  // namespace

Eigen::Vector2d modelled_displacement(const model::Scenario& scenario) {
  return internal::end_point(scenario, {}, model::IntegrationOptions{}.tolerance).position;
}

Displacement predicted_displacement(const model::Scenario& fitted, const FittedParameters& known,
                                    long max_steps) {
  std::vector<model::Parameter> wanted;
  Eigen::MatrixXd chain(0, static_cast<Eigen::Index>(known.parameters.size()));
  for (std::size_t k = 0; k < known.parameters.size(); ++k)
    for (const Link& link :
         links(fitted, known.parameters[k], known.estimates(static_cast<Eigen::Index>(k)))) {
      const bool pulsed = link.parameter == model::Parameter::mu2 || link.parameter == model::Parameter::lag;
      if (pulsed && !(fitted.friction.pulse_width > 0)) continue;
      wanted.push_back(link.parameter);
      chain.conservativeResize(chain.rows() + 1, Eigen::NoChange);
      chain.row(chain.rows() - 1).setZero();
      chain(chain.rows() - 1, static_cast<Eigen::Index>(k)) = link.derivative;
    }
  const internal::EndPoint end = internal::end_point(fitted, wanted, kTolerance, max_steps);
  Displacement displacement;
  displacement.vector = end.position;
  displacement.duration = fitted.end_time();
  displacement.cycles = static_cast<int>(fitted.cycles);
  if (!wanted.empty()) {
    const Eigen::MatrixXd by_fitted = end.jacobian * chain;
    displacement.covariance = by_fitted * known.covariance * by_fitted.transpose();
  }
  derive_alpha_and_v(displacement);
  return displacement;
}

}  // namespace tribotrack::fit
