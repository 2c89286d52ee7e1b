#include "fit/minimum/screen.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "fit/tools/dense.h"
#include "model/parallel.h"
#include "model/trajectory.h"

namespace tribotrack::fit::internal {
namespace {

constexpr std::size_t kRunsLookedAt = 6, kFewRuns = 8;
constexpr std::size_t kMost = 8000, kSlides = 24;
/// Each such point has mu2 = mu1: the valley of pulses without effect is narrow.
constexpr int kNoEffect = 10;
constexpr std::size_t kAtOnce = 100;  ///< points, of which the next ones know the best
constexpr double kTolerance = 1e-4;   ///< of the velocity at each step: 99 of 100 ends to 3e-4
/// Of a displacement: what the tolerance, and the rotation law beside the start from rest, may be off.
constexpr double kAccuracy = 0.01;
constexpr std::size_t kAngles = 64;  ///< of a turn: a polynomial of second order has at most two minima

double between(double low, double high, double u) {
  return low * std::pow(high / low, u);
}

Eigen::VectorXd box_point(const Unknowns& unknowns, const Eigen::VectorXd& guess, int k) {
  constexpr int kBases[] = {2, 3, 5, 7, 11, 13, 17, 19, 23};
  const auto& prior = unknowns.problem().prior;
  Eigen::VectorXd point = guess;
  int dimension = 0;
  const bool driven = k % 3 != 0;  // two of three where parts are driven
  double mu1 = unknowns.value_of(FitParameter::mu1, guess);
  if (const auto i = unknowns.find(FitParameter::mu1); i && unknowns.sliding_threshold()) {
    const double threshold = *unknowns.sliding_threshold(), u = halton(k, kBases[dimension++]);
    point(*i) = mu1 = threshold * (driven ? between(0.15, 1.6, u) : between(0.05, 5, u));
  }
  for (Eigen::Index i = 0; i < unknowns.reported(); ++i) {
    const FitParameter parameter = unknowns.parameter(i);
    if (parameter == FitParameter::mu1 || parameter == FitParameter::lag || parameter == FitParameter::delay)
      continue;
    const double u = halton(k, kBases[dimension++ % 9]);
    if (const auto it = prior.find(parameter); it != prior.end()) {
      point(i) = guess(i) + (2 * u - 1) * 2 * it->second.sd;
      if (unknowns.transform(i).positive()) point(i) = std::max(point(i), 0.1 * std::abs(guess(i)));
      continue;
    }
    if (parameter == FitParameter::mu2)
      point(i) = mu1 * (k % kNoEffect == 1 ? 1 : driven ? between(0.02, 0.8, u) : between(0.002, 1, u));
    else if (parameter == FitParameter::tilt_x || parameter == FitParameter::tilt_y)
      point(i) = (2 * u - 1) * 0.005;
    else
      point(i) = guess(i) * (1 + 0.04 * (u - 0.5));
  }
  return point;
}

/// A displacement to look at.
struct Look {
  model::Scenario scenario;
  bool amplitude_from_track = false;
  Eigen::Vector2d measured;
  Eigen::Matrix2d white;  ///< L^-1
};

bool alike(const model::Scenario& a, const model::Scenario& b) {
  const auto near = [](double x, double y) { return std::abs(x - y) <= 0.02 * std::abs(y); };
  return std::abs(a.friction.pulse_width - b.friction.pulse_width) < 0.05 &&
         near(a.drive.amplitude, b.drive.amplitude) &&
         near(a.drive.angular_frequency, b.drive.angular_frequency);
}

/// As keep_representative() says.
std::vector<std::size_t> representative(const std::vector<const model::Scenario*>& runs, std::size_t most) {
  std::vector<std::size_t> chosen, rest;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const bool seen = std::ranges::any_of(chosen, [&](std::size_t k) { return alike(*runs[i], *runs[k]); });
    (seen || chosen.size() == most ? rest : chosen).push_back(i);
  }
  const std::size_t more = std::min(rest.size(), most - chosen.size());
  for (std::size_t i = 0; i < more; ++i) chosen.push_back(rest[i * rest.size() / more]);
  return chosen;
}

std::vector<Look> looks(const Residuals& residuals) {
  const Problem& problem = residuals.unknowns().problem();
  std::vector<std::size_t> fitted;
  std::vector<const model::Scenario*> scenarios;
  for (std::size_t i = 0; i < problem.summary_runs.size(); ++i) {
    if (problem.summary_runs[i].held_out) continue;
    fitted.push_back(i);
    scenarios.push_back(&problem.summary_runs[i].scenario);
  }
  std::vector<Look> chosen;
  for (const std::size_t k : representative(scenarios, kRunsLookedAt)) {
    const SummaryRun& run = problem.summary_runs[fitted[k]];
    const Eigen::Vector2d& measured = run.measured.vector;
    const Factor2 factor(residuals.covariance(fitted[k]) +
                         kAccuracy * kAccuracy * measured.squaredNorm() * Eigen::Matrix2d::Identity());
    chosen.push_back({run.scenario, run.amplitude_from_track, measured, factor.inverse_lower()});
    if (run.measured.duration > 0) chosen.back().scenario.duration = run.measured.duration;
  }
  return chosen;
}

/// The unknown that turns the pulses, if there is one.
std::optional<Eigen::Index> turning(const Unknowns& unknowns) {
  const auto lag = unknowns.find(FitParameter::lag);
  return lag ? lag : unknowns.find(FitParameter::delay);
}

/// chi^2 of displacements x that are all turned by one angle t: of |W (m - (cos t x + sin t Jx))|^2, J a
/// quarter of a turn.
class Turned {
 public:
  void add(const Eigen::Vector2d& measured, const Eigen::Matrix2d& white, const Eigen::Vector2d& modelled,
           bool clockwise) {
    const Eigen::Vector2d m = white * measured, x = white * modelled,
                          turned(clockwise ? modelled.y() : -modelled.y(),
                                 clockwise ? -modelled.x() : modelled.x());
    const Eigen::Vector2d y = white * turned;
    constant_ += m.squaredNorm();
    linear_ += Eigen::Vector2d(m.dot(x), m.dot(y));
    square_ += (Eigen::Matrix2d() << x.dot(x), x.dot(y), x.dot(y), y.dot(y)).finished();
  }
  double at(double angle) const { return at(direction(angle)); }
  double best_angle() const {
    constexpr double kStep = 2 * std::numbers::pi / kAngles;
    static const std::array<Eigen::Vector2d, kAngles> directions = [] {
      std::array<Eigen::Vector2d, kAngles> all;
      for (std::size_t k = 0; k < kAngles; ++k) all[k] = direction(static_cast<double>(k) * kStep);
      return all;
    }();
    double best = 0, lowest = at(directions[0]), step = kStep;
    for (std::size_t k = 1; k < kAngles; ++k)
      if (const double chi2 = at(directions[k]); chi2 < lowest)
        best = static_cast<double>(k) * kStep, lowest = chi2;
    for (int halvings = 0; halvings < 10; ++halvings) {
      step *= 0.5;
      for (const double angle : {best - step, best + step})
        if (const double chi2 = at(angle); chi2 < lowest) best = angle, lowest = chi2;
    }
    return std::remainder(best, 2 * std::numbers::pi);
  }

 private:
  static Eigen::Vector2d direction(double angle) { return {std::cos(angle), std::sin(angle)}; }
  double at(const Eigen::Vector2d& u) const { return constant_ - 2 * linear_.dot(u) + u.dot(square_ * u); }

  double constant_ = 0;
  Eigen::Vector2d linear_ = Eigen::Vector2d::Zero();
  Eigen::Matrix2d square_ = Eigen::Matrix2d::Zero();
};

/// Where the motion ends; nothing where the model does not follow it.
std::optional<Eigen::Vector2d> end_of(const model::Scenario& scenario) try {
  model::IntegrationOptions options;
  options.dense = false;
  options.tolerance = kTolerance;
  return model::integrate(scenario, options).end().position;
} catch (const std::exception&) {
  return std::nullopt;
}

/// chi^2 at `values`, about. With the lag (or delay) free `values` get the one that turns the modelled
/// displacements best onto the measured ones: one simulation a run. Runs only add to chi^2: once it is above
/// `enough` the others are left out.
double judge(const Unknowns& unknowns, const std::vector<Look>& looks, double enough,
             Eigen::VectorXd& values) {
  const auto turns = turning(unknowns);
  if (turns) values(*turns) = 0;
  Turned turned;
  double angle = 0, chi2 = 0;
  for (const Look& look : looks) {
    const auto applied = unknowns.apply(values, look.scenario, look.amplitude_from_track, false);
    const auto end = end_of(applied.scenario);
    if (!end) return std::numeric_limits<double>::infinity();
    // epsilon = +pi/2 circles clockwise: a later pulse turns the drift by -lag.
    const bool clockwise = std::sin(look.scenario.drive.phase_shift) >= 0;
    turned.add(look.measured, look.white, *end / applied.scale, clockwise);
    if (turns) angle = turned.best_angle();
    if (chi2 = turned.at(angle); chi2 > enough) break;
  }
  if (turns)
    values(*turns) =
        unknowns.parameter(*turns) == FitParameter::lag ? angle : angle / unknowns.reference_frequency();
  return chi2;
}

/// Where points lie in their sample: from 0 to 1 along each axis. The lag was computed from the others: it is
/// no axis. mu2 counts by its ratio to mu1.
class Box {
 public:
  Box(const Unknowns& unknowns, const std::vector<ScreenedPoint>& points) : unknowns_(unknowns) {
    for (Eigen::Index i = 0; i < unknowns.reported(); ++i)
      if (unknowns.parameter(i) != FitParameter::lag && unknowns.parameter(i) != FitParameter::delay)
        axes_.push_back(i);
    low_.setConstant(dimension(), std::numeric_limits<double>::infinity());
    high_ = -low_;
    for (const ScreenedPoint& point : points) {
      low_ = low_.cwiseMin(coordinates(point));
      high_ = high_.cwiseMax(coordinates(point));
    }
  }
  Eigen::Index dimension() const { return static_cast<Eigen::Index>(axes_.size()); }
  Eigen::VectorXd place(const ScreenedPoint& point) const {
    return (coordinates(point) - low_).cwiseQuotient((high_ - low_).cwiseMax(1e-12));
  }
  /// Of multi-level single linkage, with so many points.
  double critical_distance(std::size_t points) const {
    const auto n = static_cast<double>(points), d = static_cast<double>(dimension());
    return std::pow(std::tgamma(1 + d / 2) * 4 * std::log(n) / n, 1 / d) / std::sqrt(std::numbers::pi);
  }
  bool sticks(const ScreenedPoint& point) const {
    return unknowns_.value_of(FitParameter::mu1, unknowns_.values(point.z)) >
           unknowns_.sliding_threshold().value_or(HUGE_VAL);
  }

 private:
  Eigen::VectorXd coordinates(const ScreenedPoint& point) const {
    const Eigen::VectorXd values = unknowns_.values(point.z);
    Eigen::VectorXd result(dimension());
    for (Eigen::Index k = 0; k < dimension(); ++k) {
      const Eigen::Index i = axes_[static_cast<std::size_t>(k)];
      const FitParameter parameter = unknowns_.parameter(i);
      result(k) = parameter == FitParameter::mu1 ? std::log(values(i))
                  : parameter == FitParameter::mu2
                      ? std::log(values(i) / unknowns_.value_of(FitParameter::mu1, values))
                      : values(i);
    }
    return result;
  }

  const Unknowns& unknowns_;
  std::vector<Eigen::Index> axes_;
  Eigen::VectorXd low_, high_;
};

}  // namespace

void keep_representative(std::vector<SummaryRun>& runs, std::size_t most) {
  if (runs.size() <= most) return;
  std::vector<const model::Scenario*> scenarios;
  for (const SummaryRun& run : runs) scenarios.push_back(&run.scenario);
  std::vector<SummaryRun> kept;
  for (const std::size_t i : representative(scenarios, most)) kept.push_back(runs[i]);
  runs = std::move(kept);
}

double halton(int k, int base) {
  double value = 0, digit = 1;
  for (; k > 0; k /= base) {
    digit /= base;
    value += digit * (k % base);
  }
  return value;
}

double refinable(const Residuals& residuals) {
  constexpr double kOff = 0.25;
  double sum = 0;
  for (const Look& look : looks(residuals)) sum += (look.white * look.measured).squaredNorm();
  return kOff * kOff * sum;
}

std::vector<ScreenedPoint> screen(const Residuals& residuals, int threads, std::size_t first) {
  const Unknowns& unknowns = residuals.unknowns();
  const Eigen::VectorXd guess = unknowns.first_guess();
  const std::vector<Look> seen = looks(residuals);
  const double near = refinable(residuals);
  double lowest = std::numeric_limits<double>::infinity();
  const auto judged = [&](std::vector<ScreenedPoint>& points, std::size_t count) {
    while (points.size() < count) {
      const std::size_t before = points.size();
      points.resize(std::min(count, before + kAtOnce));
      parallel_for(points.size() - before, threads, [&](std::size_t i) {
        const std::size_t k = before + i;
        Eigen::VectorXd values = k == 0 ? guess : box_point(unknowns, guess, static_cast<int>(k));
        points[k].chi2 = seen.empty() ? residuals.chi2(values) : judge(unknowns, seen, lowest + near, values);
        points[k].z = unknowns.z(values);
      });
      for (std::size_t k = before; k < points.size(); ++k) lowest = std::min(lowest, points[k].chi2);
    }
  };
  std::vector<ScreenedPoint> points;
  if (seen.empty()) {  // slides: one basin
    judged(points, kSlides);
    return points;
  }
  judged(points, first);
  // Few runs leave more valleys, and narrower ones.
  const std::size_t runs = unknowns.problem().trajectory_runs.size() + unknowns.problem().summary_runs.size();
  const int quiet = seen.size() < kRunsLookedAt || runs <= kFewRuns ? 2 : 1;
  int since = 0;
  for (auto known = basins(unknowns, points, near); points.size() < kMost;) {
    const std::size_t before = points.size();
    judged(points, 2 * before);
    auto now = basins(unknowns, points, near);
    const Box all(unknowns, points);
    const double critical = all.dimension() > 0 ? all.critical_distance(before) : 1;
    if (std::ranges::all_of(now, [&](const ScreenedPoint& bottom) {
          return std::ranges::any_of(known, [&](const ScreenedPoint& other) {
            return all.sticks(bottom) == all.sticks(other) &&
                   (all.place(bottom) - all.place(other)).norm() < critical;
          });
        })) {
      if (++since == quiet) break;
    } else {
      since = 0;
    }
    known = std::move(now);
  }
  return points;
}

std::vector<ScreenedPoint> basins(const Unknowns& unknowns, std::vector<ScreenedPoint> points, double near) {
  std::erase_if(points, [](const ScreenedPoint& point) { return !std::isfinite(point.chi2); });
  std::ranges::stable_sort(points, {}, &ScreenedPoint::chi2);
  const Box box(unknowns, points);
  if (box.dimension() == 0 || points.size() < 3) return points;
  const double critical = box.critical_distance(points.size());
  std::vector<Eigen::VectorXd> places;
  for (const ScreenedPoint& point : points) places.push_back(box.place(point));
  std::vector<ScreenedPoint> bottoms;
  for (std::size_t k = 0; k < points.size() && !(points[k].chi2 > points[0].chi2 + near); ++k) {
    bool near_a_better_one = false;  // found soon, where points lie densely
    for (std::size_t other = 0; other < k && !near_a_better_one; ++other)
      near_a_better_one = (places[k] - places[other]).squaredNorm() < critical * critical &&
                          box.sticks(points[k]) == box.sticks(points[other]);
    if (!near_a_better_one) bottoms.push_back(points[k]);
  }
  return bottoms;
}

}  // namespace tribotrack::fit::internal
