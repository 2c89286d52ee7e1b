#include "fit/internal/multi_start.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

#include "fit/internal/parallel.h"
#include "model/displacement_angle.h"

namespace tribotrack::fit::internal {
namespace {

/// The k-th number of van der Corput's sequence.
double halton(int k, int base) {
  double value = 0, digit = 1;
  for (; k > 0; k /= base) {
    digit /= base;
    value += digit * (k % base);
  }
  return value;
}

Eigen::VectorXd box_point(const Unknowns& unknowns, const Eigen::VectorXd& guess, int k) {
  constexpr int kBases[] = {2, 3, 5, 7, 11, 13, 17, 19, 23};
  const auto& prior = unknowns.problem().prior;
  Eigen::VectorXd point = guess;
  const auto between = [](double low, double high, double u) { return low * std::pow(high / low, u); };
  int dimension = 0;
  double mu1 = unknowns.value_of(FitParameter::mu1, guess);
  if (const auto i = unknowns.find(FitParameter::mu1); i && unknowns.sliding_threshold()) {
    const double threshold = *unknowns.sliding_threshold();
    point(*i) = mu1 = between(0.15 * threshold, 1.6 * threshold, halton(k, kBases[dimension++]));
  }
  for (Eigen::Index i = 0; i < unknowns.common(); ++i) {
    const FitParameter parameter = unknowns.parameter(i);
    if (parameter == FitParameter::mu1 || parameter == FitParameter::lag || parameter == FitParameter::delay)
      continue;
    const double u = halton(k, kBases[dimension++ % 9]);
    if (const auto it = prior.find(parameter); it != prior.end()) {
      point(i) = guess(i) + (2 * u - 1) * 2 * it->second.sd;
      if (unknowns.transform(i).positive()) point(i) = std::max(point(i), 0.1 * std::abs(guess(i)));
      continue;
    }
    switch (parameter) {
      case FitParameter::mu2:
        point(i) = mu1 * between(0.02, 0.8, u);
        break;
      case FitParameter::tilt_x:
      case FitParameter::tilt_y:
        point(i) = (2 * u - 1) * 0.005;
        break;
      default:
        point(i) = guess(i) * (1 + 0.04 * (u - 0.5));
    }
  }
  return point;
}

using Complex = std::complex<double>;
Complex complex(const Eigen::Vector2d& v) {
  return {v.x(), v.y()};
}

/// chi^2 at `values`, about. With a free lag (or delay) `values` get the one that turns the modelled
/// displacements onto the measured ones, and the turned displacements are judged: one simulation a run.
double screen(const Residuals& residuals, Eigen::VectorXd& values) {
  const auto& unknowns = residuals.unknowns();
  const auto& problem = unknowns.problem();
  const bool by_lag = unknowns.find(FitParameter::lag).has_value();
  const auto index = by_lag ? unknowns.find(FitParameter::lag) : unknowns.find(FitParameter::delay);
  if (!index || problem.summary_runs.empty() || !problem.trajectory_runs.empty())
    return residuals.chi2(values);
  values(*index) = 0;
  // epsilon = +pi/2 circles clockwise: a later pulse turns the drift by -lag. Conjugates where it is the
  // other way round.
  std::vector<Complex> measured, modelled;
  std::vector<double> weight;
  Complex sum = 0;
  for (std::size_t run = 0; run < problem.summary_runs.size(); ++run) {
    const auto& data = problem.summary_runs[run];
    const bool clockwise = std::sin(data.scenario.drive.phase_shift) >= 0;
    Complex m = complex(data.measured.vector), x;
    try {
      x = complex(residuals.modelled(values, run));
    } catch (const std::exception&) {
      return std::numeric_limits<double>::infinity();
    }
    measured.push_back(clockwise ? std::conj(m) : m);
    modelled.push_back(clockwise ? std::conj(x) : x);
    weight.push_back(2 / data.measured.covariance.trace());
    sum += weight.back() * measured.back() * std::conj(modelled.back());
  }
  const double lag = std::arg(sum);
  values(*index) = by_lag ? lag : lag / unknowns.reference_frequency();
  double chi2 = 0;
  for (std::size_t run = 0; run < weight.size(); ++run)
    chi2 += weight[run] * std::norm(measured[run] - modelled[run] * std::polar(1.0, lag));
  return chi2;
}

/// Within half a standard deviation; standard deviations as wide as the residuals ask for (`spread` =
/// chi^2/dof).
bool same(const Unknowns& unknowns, const KnownMinimum& a, const Minimum& b, double spread) {
  Eigen::VectorXd distance = b.z - a.minimum.z;
  if (const auto lag = unknowns.find(FitParameter::lag)) distance(*lag) = model::wrap_angle(distance(*lag));
  return distance.dot(a.curvature * distance) < 0.25 * spread &&
         std::abs(b.chi2 - a.minimum.chi2) < 0.5 * spread;
}

}  // namespace

Eigen::VectorXd fold_lag(const Unknowns& unknowns, Eigen::VectorXd z) {
  if (const auto lag = unknowns.find(FitParameter::lag)) z(*lag) = model::wrap_angle(z(*lag));
  return z;
}

Search multi_start(const Residuals& residuals, const FitOptions& options) {
  const auto& unknowns = residuals.unknowns();
  Residuals rough = residuals;
  rough.set_tolerance(1e-7);
  const Eigen::VectorXd guess = unknowns.first_guess();
  const int wanted = std::max(1, options.multi_starts);

  // Start 0, then the best screened points that are not each other's neighbours.
  std::vector<Eigen::VectorXd> starts{unknowns.z(guess)};
  if (wanted > 1) {
    const int screened = 3 * wanted;
    std::vector<std::pair<double, Eigen::VectorXd>> points(static_cast<std::size_t>(screened));
    parallel_for(points.size(), options.threads, [&](std::size_t k) {
      Eigen::VectorXd values = k == 0 ? guess : box_point(unknowns, guess, static_cast<int>(k));
      const double chi2 = screen(rough, values);
      points[k] = {chi2, unknowns.z(values)};
    });
    std::stable_sort(points.begin(), points.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    for (const auto& [chi2, z] : points) {
      if (!std::isfinite(chi2) || static_cast<int>(starts.size()) >= wanted) continue;
      const bool near = std::any_of(starts.begin(), starts.end(), [&](const Eigen::VectorXd& other) {
        return (z - other).head(unknowns.common()).lpNorm<Eigen::Infinity>() < 0.1;
      });
      if (!near) starts.push_back(z);
    }
  }

  Search search;
  std::vector<int> hits;
  const auto keep = [&](const Minimum& minimum) {
    ++search.starts;
    if (!std::isfinite(minimum.chi2)) return;
    for (std::size_t i = 0; i < search.minima.size(); ++i)
      if (same(unknowns, search.minima[i], minimum, residuals.excess(search.minima[i].minimum.chi2))) {
        ++hits[i];
        if (minimum.chi2 < search.minima[i].minimum.chi2 && !minimum.joined)
          search.minima[i] = with_curvature(rough, minimum);
        return;
      }
    search.minima.push_back(with_curvature(rough, minimum));
    hits.push_back(1);
  };
  // The most promising start finds the minimum that most others then join early.
  std::size_t first = starts.size() > 1 ? 1 : 0;
  keep(minimise(rough, starts[first], {.held = {}, .function_tolerance = 1e-8}));
  std::vector<Eigen::VectorXd> others;
  for (std::size_t i = 0; i < starts.size(); ++i)
    if (i != first) others.push_back(starts[i]);
  std::vector<Minimum> found(others.size());
  const std::vector<KnownMinimum> known = search.minima;
  std::atomic<int> done{1};
  parallel_for(others.size(), options.threads, [&](std::size_t i) {
    MinimiseOptions descent;
    descent.known = &known;
    descent.function_tolerance = 1e-8;
    found[i] = minimise(rough, others[i], descent);
    if (options.progress && options.threads <= 1) options.progress(++done, static_cast<int>(starts.size()));
  });
  for (const Minimum& minimum : found) keep(minimum);

  std::vector<std::size_t> order(search.minima.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return search.minima[a].minimum.chi2 < search.minima[b].minimum.chi2;
  });
  Search sorted;
  sorted.starts = search.starts;
  for (const std::size_t i : order) sorted.minima.push_back(search.minima[i]);
  if (!order.empty()) sorted.at_best = hits[order.front()];
  return sorted;
}

}  // namespace tribotrack::fit::internal
