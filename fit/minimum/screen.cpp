#include "fit/minimum/screen.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

#include "fit/tools/parallel.h"
#include "model/batch.h"

namespace tribotrack::fit::internal {
namespace {

using Complex = std::complex<double>;

constexpr std::size_t kRunsLookedAt = 6, kFewestRuns = 4;
constexpr double kTolerance = 1e-4;  ///< of the velocity at each step: ends to better than 1 %

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

/// A displacement to look at.
struct Look {
  model::Scenario scenario;
  bool amplitude_from_track = false;
  Complex measured;
  double variance = 0;  ///< per axis
};

Complex complex(const Eigen::Vector2d& v) {
  return {v.x(), v.y()};
}

/// A trajectory's displacement over its whole cycles, in which the platform's own motion cancels.
std::optional<Look> look_at(const TrajectoryRun& run) {
  if (run.free_slide) return std::nullopt;
  const auto& track = run.track;
  const double period = 2 * std::numbers::pi / run.scenario.drive.angular_frequency;
  const double cycles = std::floor((track.time.back() - track.time.front()) / period + 1e-6);
  if (cycles < 1) return std::nullopt;
  const double end = track.time.front() + cycles * period;
  const auto after = std::lower_bound(track.time.begin(), track.time.end(), end - 1e-9);
  const auto k = static_cast<std::size_t>(std::min(after, track.time.end() - 1) - track.time.begin());
  Look look{run.scenario, run.amplitude_from_track, {}, 0};
  const Eigen::Vector2d moved = track.position[k] - track.position.front();
  look.measured = complex(moved);
  look.scenario.duration = track.time[k] - track.time.front();
  look.variance = 1e-4 * moved.squaredNorm() + track.covariance[k].trace();
  return look;
}

bool alike(const model::Scenario& a, const model::Scenario& b) {
  const auto near = [](double x, double y) { return std::abs(x - y) <= 0.02 * std::abs(y); };
  return std::abs(a.friction.pulse_width - b.friction.pulse_width) < 0.05 &&
         near(a.drive.amplitude, b.drive.amplitude) &&
         near(a.drive.angular_frequency, b.drive.angular_frequency);
}

std::vector<Look> looks(const Problem& problem) {
  std::vector<Look> all;
  for (const auto& run : problem.summary_runs) {
    Look look{run.scenario, run.amplitude_from_track, complex(run.measured.vector),
              0.5 * run.measured.covariance.trace()};
    if (run.measured.duration > 0) look.scenario.duration = run.measured.duration;
    all.push_back(look);
  }
  for (const auto& run : problem.trajectory_runs)
    if (const auto look = look_at(run)) all.push_back(*look);
  std::vector<Look> chosen, rest;
  for (const Look& look : all) {
    const bool seen = std::any_of(chosen.begin(), chosen.end(),
                                  [&](const Look& other) { return alike(look.scenario, other.scenario); });
    (seen || chosen.size() == kRunsLookedAt ? rest : chosen).push_back(look);
  }
  for (std::size_t i = 0; i < rest.size() && chosen.size() < kFewestRuns; ++i)
    chosen.push_back(rest[i * rest.size() / kFewestRuns]);
  return chosen;
}

/// The unknown that turns the pulses, if there is one.
std::optional<Eigen::Index> turning(const Unknowns& unknowns) {
  const auto lag = unknowns.find(FitParameter::lag);
  return lag ? lag : unknowns.find(FitParameter::delay);
}

/// chi^2 at `values`, about, from where the looks' motions end there, the lag (or delay) being 0. With it
/// free `values` get the one that turns the modelled displacements onto the measured ones, and the turned
/// displacements are judged: one simulation a run.
double judge(const Unknowns& unknowns, const std::vector<Look>& looks, const model::BatchEnd* ends,
             Eigen::VectorXd& values) {
  std::vector<Complex> measured, modelled;
  Complex sum = 0;
  for (std::size_t i = 0; i < looks.size(); ++i) {
    const Look& look = looks[i];
    if (ends[i].status != model::BatchStatus::done) return std::numeric_limits<double>::infinity();
    // epsilon = +pi/2 circles clockwise: a later pulse turns the drift by -lag. Conjugates where it is the
    // other way round.
    const bool clockwise = std::sin(look.scenario.drive.phase_shift) >= 0;
    const double scale = unknowns.apply(values, look.scenario, look.amplitude_from_track, false).scale;
    const Complex x = complex(ends[i].position / scale);
    measured.push_back(clockwise ? std::conj(look.measured) : look.measured);
    modelled.push_back(clockwise ? std::conj(x) : x);
    sum += measured.back() * std::conj(modelled.back()) / look.variance;
  }
  const auto turns = turning(unknowns);
  const double angle = turns ? std::arg(sum) : 0;
  if (turns)
    values(*turns) =
        unknowns.parameter(*turns) == FitParameter::lag ? angle : angle / unknowns.reference_frequency();
  double chi2 = 0;
  for (std::size_t i = 0; i < looks.size(); ++i)
    chi2 += std::norm(measured[i] - modelled[i] * std::polar(1.0, angle)) / looks[i].variance;
  return chi2;
}

}  // namespace

std::vector<ScreenedPoint> screen(const Residuals& residuals, int count, int threads) {
  const Unknowns& unknowns = residuals.unknowns();
  const Eigen::VectorXd guess = unknowns.first_guess();
  const std::vector<Look> seen = looks(unknowns.problem());
  std::vector<ScreenedPoint> points(static_cast<std::size_t>(count));
  std::vector<Eigen::VectorXd> values;
  for (int k = 0; k < count; ++k) values.push_back(k == 0 ? guess : box_point(unknowns, guess, k));
  if (seen.empty()) {
    parallel_for(points.size(), threads, [&](std::size_t k) { points[k].chi2 = residuals.chi2(values[k]); });
  } else {
    // All motions together: what differs between them does not matter to the lanes they travel in.
    if (const auto turns = turning(unknowns))
      for (auto& point : values) point(*turns) = 0;
    model::BatchOptions batch;
    batch.threads = threads;
    batch.tolerance = kTolerance;
    const auto scenario_at = [&](std::size_t index) {
      const Look& look = seen[index % seen.size()];
      return unknowns.apply(values[index / seen.size()], look.scenario, look.amplitude_from_track, false)
          .scenario;
    };
    const model::BatchOutcome outcome = model::solve_batch(points.size() * seen.size(), scenario_at, batch);
    for (std::size_t k = 0; k < points.size(); ++k)
      points[k].chi2 = judge(unknowns, seen, &outcome.ends[k * seen.size()], values[k]);
  }
  for (std::size_t k = 0; k < points.size(); ++k) points[k].z = unknowns.z(values[k]);
  return points;
}

std::vector<ScreenedPoint> worth_a_descent(const Unknowns& unknowns, std::vector<ScreenedPoint> points) {
  std::erase_if(points, [](const ScreenedPoint& point) { return !std::isfinite(point.chi2); });
  std::stable_sort(points.begin(), points.end(),
                   [](const ScreenedPoint& a, const ScreenedPoint& b) { return a.chi2 < b.chi2; });
  // The lag was computed from the others: it is no dimension of the sample.
  std::vector<Eigen::Index> axes;
  for (Eigen::Index i = 0; i < unknowns.common(); ++i)
    if (unknowns.parameter(i) != FitParameter::lag && unknowns.parameter(i) != FitParameter::delay)
      axes.push_back(i);
  if (axes.empty() || points.size() < 3) return points;
  const double d = static_cast<double>(axes.size()), n = static_cast<double>(points.size());
  const double critical =
      std::pow(std::tgamma(1 + d / 2) * 4 * std::log(n) / n, 1 / d) / std::sqrt(std::numbers::pi);
  Eigen::VectorXd low = points.front().z, high = low;
  for (const auto& point : points) low = low.cwiseMin(point.z), high = high.cwiseMax(point.z);
  const auto sticks = [&](const ScreenedPoint& point) {
    return unknowns.value_of(FitParameter::mu1, unknowns.values(point.z)) >
           unknowns.sliding_threshold().value_or(HUGE_VAL);
  };
  const auto linked = [&](const ScreenedPoint& a, const ScreenedPoint& b) {
    double square = 0;
    for (const Eigen::Index i : axes)
      square += std::pow((a.z(i) - b.z(i)) / std::max(high(i) - low(i), 1e-12), 2);
    return sticks(a) == sticks(b) && square < critical * critical;
  };
  std::vector<ScreenedPoint> worth, rest;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const bool near_a_better_one =
        std::any_of(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(k),
                    [&](const ScreenedPoint& better) { return linked(points[k], better); });
    points[k].worth_a_descent = !near_a_better_one;
    (near_a_better_one ? rest : worth).push_back(points[k]);
  }
  worth.insert(worth.end(), rest.begin(), rest.end());
  return worth;
}

}  // namespace tribotrack::fit::internal
