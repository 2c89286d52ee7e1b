// The distributions, medians, straight lines and correlation times that a fit needs.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

namespace tribotrack::fit::internal {

/// P(chi^2 with `dof` degrees of freedom > x); 1 for dof <= 0.
double chi2_survival(double x, double dof);

/// P(F with `dof` and `noise_dof` degrees of freedom, over its mean > x / dof): of chi^2 = x whose variances
/// were estimated with so many; chi2_survival(x, dof) where they are infinitely many.
double chi2_survival(double x, double dof, double noise_dof);

/// x with P(chi^2 with `dof` degrees of freedom < x) = `probability`.
double chi2_quantile(double probability, double dof);

/// t with P(|T| < t) = `probability` for Student's T with `dof` degrees of freedom; the normal quantile above
/// 10^4 degrees of freedom.
double two_sided_quantile(double probability, double dof);

/// By which an sd that was estimated with `dof` degrees of freedom is too small for its 95 % interval to be
/// -+ 1.96 of it: Student's 95 % quantile over the normal one.
double student_widening(double dof);

/// x >= 0 at which a falling f comes down to `level`; 0 where it begins below. `far`: a first guess of where
/// it lies below.
double falls_to(const std::function<double(double)>& f, double level, double far);

/// The value in the middle; of an even number the upper of the two.
double upper_median(std::vector<double> values);

/// A straight line by least squares: y = middle + slope (x - mean), y numbers or vectors. The slope is 0
/// where all x are alike.
template <class Value>
struct Line {
  double mean = 0;    ///< of x
  double square = 0;  ///< sum (x - mean)^2
  Value middle, slope;
  Value at(double x) const { return middle + (x - mean) * slope; }
};

/// Through one point at least.
template <class Value>
Line<Value> line_through(std::span<const double> x, std::span<const Value> y) {
  const auto n = static_cast<double>(x.size());
  const Value zero = 0.0 * y.front();
  Line<Value> line{0, 0, zero, zero};
  for (std::size_t i = 0; i < x.size(); ++i) {
    line.mean += x[i] / n;
    line.middle += y[i] / n;
  }
  for (std::size_t i = 0; i < x.size(); ++i) {
    line.square += (x[i] - line.mean) * (x[i] - line.mean);
    line.slope += (x[i] - line.mean) * (y[i] - line.middle);
  }
  if (line.square > 0) line.slope /= line.square;
  return line;
}

/// From the median absolute deviation of normal values to their standard deviation.
inline constexpr double kSdPerMad = 1.4826;
/// The median length of a vector whose two components are standard normal (Rayleigh): sqrt(2 ln 2).
inline constexpr double kRayleighMedian = 1.1774;

/// Integrated autocorrelation time 1 + 2 sum rho_k of an even series, >= 1: the factor by which the number of
/// independent points is smaller than the number of points. Summed over five times itself (Sokal's window).
double autocorrelation_time(const std::vector<double>& series);

/// The same for the residuals of a fit with `parameters` smooth columns, which has removed slow parts of the
/// noise: at least that of a first-order process with the lag-1 correlation corrected for the loss,
/// E(r1) = rho - ((1 + rho) p + 2 rho)/n (Kendall's bias for p columns).
double residual_correlation_time(const std::vector<double>& series, double parameters);

}  // namespace tribotrack::fit::internal
