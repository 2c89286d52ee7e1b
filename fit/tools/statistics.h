// The few distributions a fit's verdict needs.
#pragma once

#include <vector>

namespace tribotrack::fit::internal {

/// P(chi^2 with `dof` degrees of freedom > x); 1 for dof = 0. Incomplete gamma function, series and
/// continued fraction (Abramowitz & Stegun 6.5.29, 6.5.31).
double chi2_survival(double x, double dof);

/// t with P(|T| < t) = `probability` for Student's T with `dof` degrees of freedom; the normal quantile for
/// dof = infinity.
double two_sided_quantile(double probability, double dof);

/// Integrated autocorrelation time 1 + 2 sum rho_k of an even series, >= 1: the factor by which the number of
/// independent points is smaller than the number of points. Summed over five times itself (Sokal's window).
double autocorrelation_time(const std::vector<double>& series);

/// The same for the residuals of a fit with `parameters` smooth columns, which has taken slow parts of the
/// noise away: at least that of a first-order process with the lag-1 correlation corrected for the loss,
/// E(r1) = rho - ((1 + rho) p + 2 rho)/n (Kendall's bias for p columns).
double residual_correlation_time(const std::vector<double>& series, double parameters);

}  // namespace tribotrack::fit::internal
