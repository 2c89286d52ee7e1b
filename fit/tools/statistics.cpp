#include "fit/tools/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tribotrack::fit::internal {
namespace {

/// Regularised upper incomplete gamma function Q(a, x).
double gamma_q(double a, double x) {
  if (x <= 0) return 1;
  const double front = std::exp(-x + a * std::log(x) - std::lgamma(a));
  if (x < a + 1) {
    double term = 1 / a, sum = term;
    for (double n = a + 1; std::abs(term) > 1e-17 * std::abs(sum); ++n) sum += term *= x / n;
    return 1 - front * sum;
  }
  const double tiny = 1e-300;  // Lentz's algorithm
  double b = x + 1 - a, c = 1 / tiny, d = 1 / b, h = d;
  for (int i = 1; i < 10000; ++i) {
    const double an = -i * (i - a);
    b += 2;
    d = an * d + b;
    if (std::abs(d) < tiny) d = tiny;
    c = b + an / c;
    if (std::abs(c) < tiny) c = tiny;
    d = 1 / d;
    h *= d * c;
    if (std::abs(d * c - 1) < 1e-15) break;
  }
  return front * h;
}

/// P(|T| < t) by Simpson's rule on theta = atan(t / sqrt(dof)): the density becomes cos^(dof - 1).
double central_probability(double t, double dof) {
  const double end = std::atan(t / std::sqrt(dof));
  const int intervals = 400;
  const double h = end / intervals;
  double sum = 0;
  for (int i = 0; i <= intervals; ++i) {
    const double weight = i == 0 || i == intervals ? 1 : (i % 2 ? 4 : 2);
    sum += weight * std::pow(std::cos(i * h), dof - 1);
  }
  const double norm =
      std::exp(std::lgamma((dof + 1) / 2) - std::lgamma(dof / 2)) / std::sqrt(std::acos(-1.0));
  return 2 * norm * sum * h / 3;
}

}  // namespace

double chi2_survival(double x, double dof) {
  return dof > 0 ? gamma_q(dof / 2, x / 2) : 1;
}

double two_sided_quantile(double probability, double dof) {
  const bool normal = !std::isfinite(dof) || dof > 1e4;
  double low = 0, high = 1;
  const auto below = [&](double t) {
    return (normal ? std::erf(t / std::sqrt(2.0)) : central_probability(t, dof)) < probability;
  };
  while (below(high)) high *= 2;
  for (int i = 0; i < 60; ++i) (below(0.5 * (low + high)) ? low : high) = 0.5 * (low + high);
  return 0.5 * (low + high);
}

double autocorrelation_time(const std::vector<double>& series) {
  const std::size_t n = series.size();
  if (n < 4) return 1;
  double mean = 0;
  for (const double value : series) mean += value / static_cast<double>(n);
  const auto covariance = [&](std::size_t lag) {
    double sum = 0;
    for (std::size_t i = lag; i < n; ++i) sum += (series[i] - mean) * (series[i - lag] - mean);
    return sum / static_cast<double>(n);
  };
  const double variance = covariance(0);
  if (!(variance > 0)) return 1;
  double time = 1;
  for (std::size_t k = 1; k < n / 2 && static_cast<double>(k) < 5 * time; ++k)
    time += 2 * covariance(k) / variance;
  return std::max(1.0, time);
}

double residual_correlation_time(const std::vector<double>& series, double parameters) {
  const double n = static_cast<double>(series.size());
  double square = 0, product = 0;
  for (std::size_t i = 0; i < series.size(); ++i) {
    square += series[i] * series[i];
    if (i > 0) product += series[i] * series[i - 1];
  }
  if (!(square > 0) || n < 4 * parameters + 4) return autocorrelation_time(series);
  const double rho = (product / square + parameters / n) / (1 - (parameters + 2) / n);
  const double first_order = rho > 0 ? (1 + std::min(rho, 0.98)) / (1 - std::min(rho, 0.98)) : 1;
  return std::max(first_order, autocorrelation_time(series));
}

}  // namespace tribotrack::fit::internal
