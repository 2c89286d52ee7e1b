// Sweeps of alpha and v for the table of claims.h.
#pragma once

#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "apps/bench/claims/claims.h"

namespace tribotrack::bench {

/// Direction and mean velocity of the displacement; NaN where there is no unique steady motion.
struct Drift {
  double alpha = NAN;  ///< rad
  double v = NAN;      ///< m/s
};

Drift steady_drift(const model::Scenario& scenario);
/// Over the scenario's cycles, from rest: as the paper counts them.
Drift drift_from_rest(const model::Scenario& scenario);

/// v of many scenarios, side by side (model/batch.h); NaN where there is none.
std::vector<double> steady_v(const std::vector<model::Scenario>& scenarios);
std::vector<double> v_from_rest(const std::vector<model::Scenario>& scenarios);

using DriftOf = std::function<Drift(const model::Scenario&)>;

std::vector<double> grid(double from, double to, int count);
/// The difference of two angles in (-pi, pi].
double turn_between(double from, double to);
double degrees(double radians);
double max_of(const std::vector<double>& values);

/// How far alpha is from a line of slope -1 in phi over a whole turn: largest distance from their mean, rad.
/// And the spread of v, (largest - least)/mean.
struct PhaseSweep {
  double off_line = 0, v_spread = 0;
};
PhaseSweep sweep_phase(model::Scenario scenario, const DriftOf& drift, int count);

/// Values along a sweep: does v only grow (sign = 1) or only fall (-1)? Where does it first not?
struct Monotony {
  bool holds = true;
  double fails_from = NAN, fails_to = NAN;  ///< first stretch against the sign, by the swept value
};
Monotony monotony(const std::vector<double>& swept, const std::vector<double>& v, int sign);

/// The deepest step against the sign, not only between neighbours, relative to what it goes back from. 0
/// where there is none.
double deepest_step_back(const std::vector<double>& v, int sign);

/// "mu1 = 0.1, dtau = 0.524 rad"
std::string conditions(double mu1, double dtau);
/// "mu1 = 0.1"
std::string mu1_is(double mu1);
/// With printf's format, for one or two numbers.
std::string text_of(const char* format, double a);
std::string text_of(const char* format, double a, double b);

// The claims, by what they are about.
PaperClaim circular_end_state(bool quick);
PaperClaim full_circle(bool quick);
PaperClaim linear_in_phase(bool quick);
PaperClaim alpha_over_width(bool quick);
PaperClaim alpha_over_ratio(bool quick);
PaperClaim alpha_over_amplitude(bool quick);
PaperClaim v_independent_of_phase(bool quick);
PaperClaim v_over_width(bool quick);
PaperClaim v_over_ratio(bool quick);
PaperClaim v_over_amplitude(bool quick);
PaperClaim v_over_frequency(bool quick);
PaperClaim v_over_friction(bool quick);
PaperClaim effect_of_tilt(bool quick);
PaperClaim keeps_moving(bool quick);
PaperClaim displacement_over_width(bool quick);
PaperClaim alpha_by_phase(bool quick);
PaperClaim less_stretched(bool quick);
PaperClaim alpha_over_frequency(bool quick);
PaperClaim v_in_experiment(bool quick);
PaperClaim further_in_experiment(bool quick);

}  // namespace tribotrack::bench
