#include "fit/internal/forecast.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fit/internal/settled_end.h"

namespace tribotrack::fit::internal {
Forecaster::Forecaster(const Residuals& residuals, const Eigen::VectorXd& values)
    : residuals_(residuals), values_(values), units_(residuals.unknowns().natural_units(values)) {
  const auto& runs = residuals.unknowns().problem().summary_runs;
  base_ = runs.front();
  clockwise_ = std::sin(base_.scenario.drive.phase_shift) >= 0;
  // ln sd = ln sd_ + power ln(length/length_), a straight line through the runs.
  double mean_x = 0, mean_y = 0, square = 0, product = 0;
  std::vector<double> x, y;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    x.push_back(std::log(std::max(runs[i].measured.vector.norm(), 1e-9)));
    y.push_back(0.5 * std::log(0.5 * residuals.covariance(i).trace()));
    mean_x += x.back() / static_cast<double>(runs.size());
    mean_y += y.back() / static_cast<double>(runs.size());
  }
  for (std::size_t i = 0; i < runs.size(); ++i) {
    square += (x[i] - mean_x) * (x[i] - mean_x);
    product += (x[i] - mean_x) * (y[i] - mean_y);
  }
  power_ = square > 1e-6 ? std::clamp(product / square, 0.0, 1.0) : 0;
  sd_ = std::exp(mean_y);
  length_ = std::exp(mean_x);
}

Candidate Forecaster::drive_so_far() const {
  return {base_.scenario.friction.phase, base_.scenario.friction.pulse_width, base_.scenario.drive.amplitude,
          base_.scenario.drive.angular_frequency};
}

double Forecaster::variance(const Eigen::Vector2d& displacement) const {
  const double sd = sd_ * std::pow(std::max(displacement.norm(), 0.1 * length_) / length_, power_);
  return sd * sd;
}

std::optional<Forecast> Forecaster::forecast(const Candidate& candidate, double tolerance) const {
  const Unknowns& unknowns = residuals_.unknowns();
  model::Scenario scenario = base_.scenario;
  scenario.friction.phase = candidate.phi;
  scenario.friction.pulse_width = candidate.dtau;
  const double cycles = scenario.end_time() * scenario.drive.angular_frequency / (2 * std::numbers::pi);
  scenario.duration = std::round(cycles) * 2 * std::numbers::pi / candidate.angular_frequency;
  scenario.drive.amplitude_y *= candidate.amplitude / scenario.drive.amplitude;
  scenario.drive.amplitude = candidate.amplitude;
  scenario.drive.angular_frequency = candidate.angular_frequency;
  const auto applied = unknowns.apply(values_, scenario, base_.amplitude_from_track, true);
  if (applied.wanted.empty()) return std::nullopt;
  model::IntegrationOptions options;
  options.derivatives = applied.wanted;
  options.tolerance = tolerance;
  Forecast forecast;
  forecast.candidate = candidate;
  try {
    const EndPoint end = settled_end(applied.scenario, options);
    forecast.displacement = end.position / applied.scale;
    forecast.rows = end.jacobian * applied.chain / applied.scale;
  } catch (const std::exception&) {
    return std::nullopt;
  }
  if (const auto scale = unknowns.find(FitParameter::scale))
    forecast.rows.col(*scale) -= forecast.displacement / applied.scale;
  forecast.rows = (forecast.rows * units_.asDiagonal()).eval() / std::sqrt(variance(forecast.displacement));
  if (!forecast.rows.allFinite()) return std::nullopt;
  return forecast;
}

Forecast Forecaster::turned(const Forecast& forecast, double phi) const {
  const double angle = (phi - forecast.candidate.phi) * (clockwise_ ? -1 : 1);
  Eigen::Matrix2d rotation;
  rotation << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  Forecast result{forecast.candidate, rotation * forecast.rows, rotation * forecast.displacement};
  result.candidate.phi = phi;
  return result;
}

}  // namespace tribotrack::fit::internal
