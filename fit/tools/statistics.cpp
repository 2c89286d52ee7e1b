#include "fit/tools/statistics.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>

namespace tribotrack::fit::internal {

double chi2_survival(double x, double dof) {
  if (!(dof > 0) || x <= 0) return 1;
  if (!std::isfinite(x)) return std::isnan(x) ? x : 0;
  // Chernoff: all but exp(-0.318 dof) of the distribution lies above, where Boost 1.74 overflows.
  if (dof > 150 && x < dof / 4) return 1;
  return boost::math::cdf(boost::math::complement(boost::math::chi_squared(dof), x));
}

double chi2_survival(double x, double dof, double noise_dof) {
  constexpr double kAsGoodAsKnown = 1e6, kFewest = 4;
  if (!(dof > 0) || !(noise_dof < kAsGoodAsKnown) || !std::isfinite(x) || x <= 0)
    return chi2_survival(x, dof);
  noise_dof = std::max(noise_dof, kFewest);
  return boost::math::cdf(
      boost::math::complement(boost::math::fisher_f(dof, noise_dof), x / dof * noise_dof / (noise_dof - 2)));
}

double chi2_quantile(double probability, double dof) {
  return boost::math::quantile(boost::math::chi_squared(dof), probability);
}

double two_sided_quantile(double probability, double dof) {
  const double upper_tail = 0.5 * (1 - probability);
  if (!std::isfinite(dof) || dof > 1e4)
    return boost::math::quantile(boost::math::complement(boost::math::normal(), upper_tail));
  return boost::math::quantile(boost::math::complement(boost::math::students_t(dof), upper_tail));
}

double student_widening(double dof) {
  constexpr double kLevel = 0.95;
  return two_sided_quantile(kLevel, dof) /
         two_sided_quantile(kLevel, std::numeric_limits<double>::infinity());
}

double falls_to(const std::function<double(double)>& f, double level, double far) {
  if (!(f(0) > level)) return 0;
  double low = 0, high = far;
  while (f(high) > level) high *= 2;
  while (high - low > 1e-12 * high) {
    const double middle = 0.5 * (low + high);
    if (!(middle > low && middle < high)) break;
    (f(middle) > level ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double upper_median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
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
