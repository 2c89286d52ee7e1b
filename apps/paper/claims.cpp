// What Kilikevicius et al. 2021 state about the motion (sections 2.2, 3.2 and 4), computed again: where it is
// exactly true, where nearly, where not.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <utility>

#include "apps/paper/paper.h"
#include "apps/simulating/sweep.h"
#include "model/alpha_v.h"
#include "model/steady_orbit.h"
#include "model/trajectory.h"

namespace tribotrack::apps {
namespace {

using model::Scenario;
using model::wrap_angle;
using std::numbers::pi;

using Values = std::vector<double>;

/// What `tribotrack sweep` computes, alpha without its jumps of a whole turn.
struct Curve : SweptModel {
  Values swept;
};

/// Runs the model: `solve(scenario, "dtau_rad", 0, 2 * pi, 64)`.
struct Solver {
  Context context;

  Curve operator()(const Scenario& scenario, const char* parameter, double from, double to, int count) const {
    Values swept;
    for (int k = 0; k < count; ++k) swept.push_back(from + (to - from) * k / std::max(1, count - 1));
    ScenarioFile base;
    base.scenario = scenario;
    base.mu1_over_mu2 = scenario.friction.nominal / scenario.friction.reduced;
    Curve curve{solve(Sweep(base, {SweepAxis(parameter, swept)}), context), swept};
    for (Values* alpha : {&curve.alpha_rad, &curve.steady_alpha_rad})
      for (std::size_t k = 1; k < alpha->size(); ++k)
        (*alpha)[k] = (*alpha)[k - 1] + wrap_angle((*alpha)[k] - (*alpha)[k - 1]);
    return curve;
  }

  Curve operator()(const Scenario& scenario) const {
    return (*this)(scenario, "phi_rad", scenario.friction.phase, scenario.friction.phase, 1);
  }
};

/// mu2 = mu1/8, g = 9.81 m/s^2, A = 0.28 mm, w = 62.8 rad/s, epsilon = pi/2, 20 cycles from rest.
Scenario paper_conditions(double mu1, double dtau, double phi = 0) {
  Scenario s;
  s.friction = {mu1, mu1 / 8, phi, dtau, 0};
  return s;
}

/// Figures 3 and 4: 3 cycles from rest.
Scenario three_cycles(double amplitude, double dtau, double phi = 0) {
  Scenario s = paper_conditions(0.122, dtau, phi);
  s.drive.amplitude = s.drive.amplitude_y = amplitude;
  s.cycles = 3;
  return s;
}

constexpr double kAmplitudes[] = {0.28e-3, 0.31e-3, 0.32e-3};  // of figure 4, m
constexpr double kRounding = 1e-7;                             // deg, %: below it a law is exact

using Cases = std::vector<std::pair<std::string, Scenario>>;

/// By their conditions: "mu1 = 0.1, dtau = 0.524 rad".
Cases cases_of(std::initializer_list<double> friction, std::initializer_list<double> widths, double phi = 0) {
  Cases cases;
  for (const double mu1 : friction)
    for (const double dtau : widths)
      cases.emplace_back(fmt::format("mu1 = {:g}, dtau = {:.3f} rad", mu1, dtau),
                         paper_conditions(mu1, dtau, phi));
  return cases;
}

double degrees(double radians) {
  return radians * 180 / pi;
}

double degrees_between(double from, double to) {
  return degrees(std::abs(wrap_angle(to - from)));
}

double spread(const Values& values) {
  const auto [low, high] = std::ranges::minmax(values);
  return high - low;
}

double mean(const Values& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// The deepest step against the sign, not only between neighbours, % of what it goes back from.
double deepest_step_back(const Values& v, int sign) {
  double from = v.front(), deepest = 0;
  for (const double here : v) {
    if (sign * (here - from) >= 0) from = here;
    if (from != 0) deepest = std::max(deepest, 100 * std::abs((here - from) / from));
  }
  return deepest;
}

/// The first stretch of a sweep on which v goes against the sign, by places; {0, 0} where there is none.
std::pair<std::size_t, std::size_t> stretch_back(const Values& v, int sign) {
  const double rounding = 1e-9 * std::ranges::max(v);
  const auto against = [&](std::size_t k) { return k < v.size() && sign * (v[k] - v[k - 1]) < -rounding; };
  std::size_t first = 1;
  while (first < v.size() && !against(first)) ++first;
  if (first == v.size()) return {0, 0};
  std::size_t last = first;
  while (against(last + 1)) ++last;
  return {first - 1, last};
}

/// Where v, which has one maximum over dtau (rad), is greatest: found to 1e-6.
double width_of_greatest_v(const Solver& solve, const Scenario& scenario, Values SweptModel::*v) {
  constexpr int kSteps = 64;
  double low = 0, high = 2 * pi;
  while (high - low > 1e-6) {
    const double step = (high - low) / kSteps;
    const Curve curve = solve(scenario, "dtau_rad", low + step, high - step, kSteps - 1);
    const auto best = std::ranges::max_element(curve.*v) - (curve.*v).begin();
    low = curve.swept[static_cast<std::size_t>(best)] - step;
    high = low + 2 * step;
  }
  return (low + high) / 2;
}

double displacement_mm(const Scenario& scenario) {
  return 1e3 * model::integrate(scenario).end().position.norm();
}

/// Displacement over length of the path: 1 for a straight walk, 0 for a closed circle.
double stretch(const Scenario& scenario) {
  constexpr int kChordsPerCycle = 200;  // shorter than their arcs by some 1e-4
  const model::Trajectory run = model::integrate(scenario);
  const int count = static_cast<int>(kChordsPerCycle * scenario.cycles);
  double length = 0;
  Eigen::Vector2d last = run.at(0).position;
  for (int i = 1; i <= count; ++i) {
    const Eigen::Vector2d here = run.at(run.end_time() * i / count).position;
    length += (here - last).norm();
    last = here;
  }
  return last.norm() / length;
}

Answer circular_end_state(const Solver&) {
  double worst = 0;
  for (const double mu1 : {0.02, 0.05, 0.08, 0.1, 0.11}) {
    const Scenario s = paper_conditions(mu1, 0);
    const auto orbit = model::steady_orbit(s);
    const double w = s.drive.angular_frequency, a = s.drive.amplitude * w * w, m = mu1 * s.drive.gravity;
    const double radius = std::sqrt((a - m) * (a + m)) / (w * w);
    worst = std::max({worst, std::abs(orbit->velocity.norm() / w - radius) / radius,
                      orbit->drift.norm() / s.drive.amplitude});
  }
  return {worst > 1e-11 ? Verdict::refuted : Verdict::exact, worst,
          "The periodic motion at constant mu < a/g (a = A_e omega^2) is the circle of the closed form and "
          "goes nowhere; at higher mu the part rests."};
}

Answer keeps_moving(const Solver& solve) {
  const Curve run = solve(three_cycles(0.31e-3, pi / 4));
  const double steady = run.steady_v_mm_s[0];
  return {steady > 0 ? Verdict::holds : Verdict::refuted, steady,
          fmt::format("It goes on at v = {:.3f} mm/s for ever, after {:.3f} mm/s over the first 3 cycles.",
                      steady, run.v_mm_s[0])};
}

Answer displacement_over_width(const Solver& solve) {
  Values growth, peaks;
  bool falls = false;  // before its greatest
  for (const double amplitude : kAmplitudes) {
    const Scenario s = three_cycles(amplitude, 0);
    peaks.push_back(width_of_greatest_v(solve, s, &SweptModel::v_mm_s));
    growth.push_back(displacement_mm(three_cycles(amplitude, pi / 4)) /
                     displacement_mm(three_cycles(amplitude, pi / 10)));
    falls = falls || deepest_step_back(solve(s, "dtau_rad", pi / 10, peaks.back(), 60).v_mm_s, 1) > 0;
  }
  const auto [least, most] = std::ranges::minmax(growth);
  const auto [first, last] = std::ranges::minmax(peaks);
  return {falls || least <= 1 ? Verdict::refuted
          : last < 2 * pi     ? Verdict::holds_in_part
                              : Verdict::holds,
          least,
          fmt::format("From pi/10 to pi/4 the displacement over 3 cycles grows {:.1f} to {:.1f} times; it "
                      "grows up to dtau = {:.2f} to {:.2f} rad only and falls after.",
                      least, most, first, last)};
}

Answer alpha_by_phase(const Solver& solve) {
  const auto alpha = [&](double amplitude, double dtau, double phi) {
    return solve(three_cycles(amplitude, dtau, phi)).alpha_rad[0];
  };
  const double reference = alpha(kAmplitudes[0], pi / 4, 0);
  double by_phi = HUGE_VAL, by_width = 0, by_amplitude = 0;
  for (const double a : kAmplitudes) {
    const double wide = alpha(a, pi / 4, 0);
    by_phi = std::min(by_phi, degrees_between(alpha(a, pi / 4, 11 * pi / 9), alpha(a, pi / 4, 17 * pi / 9)));
    by_width = std::max(by_width, degrees_between(alpha(a, pi / 10, 0), wide));
    by_amplitude = std::max(by_amplitude, degrees_between(reference, wide));
  }
  return {by_phi < std::max(by_width, by_amplitude) ? Verdict::refuted : Verdict::holds, by_phi,
          fmt::format("120 deg more of phi turn alpha by at least {:.0f} deg; dtau from pi/10 to pi/4 turns "
                      "it by at most {:.0f} deg, A_e from 0.28 to 0.32 mm by {:.0f} deg.",
                      by_phi, by_width, by_amplitude)};
}

Answer full_circle(const Solver& solve) {
  Answer answer{Verdict::holds, 0, "Over one turn of phi alpha turns once the other way, from rest as well."};
  for (const auto& [conditions, scenario] : cases_of({0.1}, {pi / 6, pi / 3, pi})) {
    const Values alpha = solve(scenario, "phi_rad", 0, 2 * pi, 73).alpha_rad;
    answer.value = (alpha.back() - alpha.front()) / (2 * pi);
    answer.conditions = conditions;
    if (std::lround(answer.value) != -1) answer.verdict = Verdict::refuted;
  }
  return answer;
}

Answer less_stretched(const Solver&) {
  double narrow = 0, wide = HUGE_VAL;
  for (int i = 0; i < 8; ++i) {
    narrow = std::max(narrow, stretch(paper_conditions(0.12, pi / 6, 2 * pi * i / 8)));
    wide = std::min(wide, stretch(paper_conditions(0.12, pi, 2 * pi * i / 8)));
  }
  return {wide > narrow ? Verdict::refuted : Verdict::holds_in_part, wide,
          fmt::format("More stretched: the displacement is at least {:.2f} of the path at dtau = pi, at most "
                      "{:.2f} at pi/6. The paper's own sentence on figure 4 says so too.",
                      wide, narrow)};
}

Answer v_over_width(const Solver& solve) {
  double least = HUGE_VAL, greatest = 0, in_figure = 0, below = 0;
  for (const double mu1 : {0.02, 0.05, 0.08, 0.1, 0.11, 0.12, 0.122})
    for (const double ratio : {2.0, 4.0, 8.0, 16.0, 50.0}) {
      Scenario s = paper_conditions(mu1, 0);
      s.friction.reduced = mu1 / ratio;
      const double widest = width_of_greatest_v(solve, s, &SweptModel::steady_v_mm_s);
      const Values before = solve(s, "dtau_rad", 0, widest, 40).steady_v_mm_s,
                   after = solve(s, "dtau_rad", widest, 2 * pi, 20).steady_v_mm_s;
      if (stretch_back(before, 1).second > 0 || stretch_back(after, -1).second > 0)
        return {Verdict::refuted, widest, "Here v has more than one maximum.",
                fmt::format("mu1 = {:g}, mu1/mu2 = {:g}", mu1, ratio)};
      least = std::min(least, widest);
      greatest = std::max(greatest, widest);
      if (mu1 != 0.1 || ratio != 8) continue;  // figure 6
      in_figure = widest;
      s.friction.pulse_width = 1.5 * pi;
      below = 100 * (1 - solve(s).steady_v_mm_s[0] / after.front());
    }
  const bool far = std::max(greatest - 1.5 * pi, 1.5 * pi - least) > 0.1;
  return {far ? Verdict::holds_in_part : Verdict::holds, in_figure,
          fmt::format(
              "One maximum, not at 3 pi/2 = 4.712 rad but at dtau = {:.3f} to {:.3f} rad, set mostly by "
              "mu1/mu2: at {:.3f} rad for mu1 = 0.1, mu1/mu2 = 8, where v at 3 pi/2 is {:.1f} % below it.",
              least, greatest, in_figure, below)};
}

/// A parameter swept from `from` to `to`, in the unit of its name.
struct Swept {
  const char *parameter, *name, *unit;  ///< of texts; the unit with its blank before it
  double from, to;
  int count;
};

/// Steady v along a sweep, under several conditions: the deepest step against the sign, and where each first
/// takes one.
Answer v_along(const Solver& solve, const Swept& swept, int sign, const Cases& cases,
               const char* throughout) {
  const auto range = [&](double from, double to) {
    return fmt::format("{} = {:.4g} to {:.4g}{}", swept.name, from, to, swept.unit);
  };
  Answer answer{Verdict::holds, -1};
  for (const auto& [conditions, scenario] : cases) {
    const Curve curve = solve(scenario, swept.parameter, swept.from, swept.to, swept.count);
    const double back = deepest_step_back(curve.steady_v_mm_s, sign);
    if (back > answer.value) answer.conditions = conditions + ", " + range(swept.from, swept.to);
    answer.value = std::max(answer.value, back);
    const auto [first, last] = stretch_back(curve.steady_v_mm_s, sign);
    if (last == 0) continue;
    answer.finding +=
        fmt::format("{}{}: {} from {}", answer.finding.empty() ? "Not for " : "; ", conditions,
                    sign > 0 ? "v falls" : "v rises", range(curve.swept[first], curve.swept[last]));
    answer.verdict = Verdict::holds_in_part;
  }
  answer.finding = answer.finding.empty() ? throughout : answer.finding + ".";
  return answer;
}

/// The law of the steady motion over a turn of phi, and how far from it 20 cycles from rest are: `off` says
/// how far a motion is. {steady, from rest, where the latter}.
template <class Off>
std::tuple<double, double, std::string> over_phase(const Solver& solve, const Cases& cases, const Off& off) {
  double steady = 0, rest = 0;
  std::string where;
  for (const auto& [conditions, scenario] : cases) {
    const Curve curve = solve(scenario, "phi_rad", 0, 2 * pi * 71 / 72, 72);
    steady = std::max(steady, off(curve, curve.steady_alpha_rad, curve.steady_v_mm_s));
    const double here = off(curve, curve.alpha_rad, curve.v_mm_s);
    if (here > rest) where = conditions;
    rest = std::max(rest, here);
  }
  return {steady, rest, where};
}

Answer v_over_phase(const Solver& solve) {
  const auto [steady, rest, where] =
      over_phase(solve, cases_of({0.05, 0.1, 0.12, 0.122}, {pi / 6, pi / 3, pi}),
                 [](const Curve&, const Values&, const Values& v) { return 100 * spread(v) / mean(v); });
  return {
      steady > kRounding ? Verdict::refuted : Verdict::exact, steady,
      fmt::format(
          "Steady: exactly (rotation). Over 20 cycles from rest v varies with phi by up to {:.0f} % ({}).",
          rest, where)};
}

Answer alpha_over_phase(const Solver& solve) {
  const auto [steady, rest, where] =
      over_phase(solve, cases_of({0.02, 0.05, 0.08, 0.1, 0.12, 0.122}, {pi / 6, pi / 3, pi / 2, pi}),
                 [](const Curve& curve, Values sums, const Values&) {  // alpha + phi: constant on the line
                   for (std::size_t k = 0; k < sums.size(); ++k) sums[k] += curve.swept[k];
                   const double middle = mean(sums);
                   return degrees(std::max(std::ranges::max(sums) - middle, middle - std::ranges::min(sums)));
                 });
  return {steady > kRounding ? Verdict::refuted : Verdict::exact, steady,
          fmt::format("Steady: slope exactly -1 (rotation). Over 20 cycles from rest alpha leaves the line "
                      "by up to {:.1f} deg ({}), since the transient does not turn with phi.",
                      rest, where)};
}

Answer alpha_over_width(const Solver& solve) {
  Answer answer{Verdict::holds, 0};
  std::string falls, rises;  // mu1 for which alpha only falls, also rises
  for (const double mu1 : {0.02, 0.05, 0.08, 0.1, 0.11, 0.12, 0.122}) {
    const Curve curve = solve(paper_conditions(mu1, 0), "dtau_rad", 0.1, 6.2, 62);
    const Values& alpha = curve.steady_alpha_rad;
    const double slope = (alpha.back() - alpha.front()) / (curve.swept.back() - curve.swept.front());
    if (slope < answer.value) answer.conditions = fmt::format("mu1 = {:g}", mu1);
    answer.value = std::min(answer.value, slope);
    std::string& list = std::ranges::is_sorted(alpha, std::greater()) ? falls : rises;
    list += fmt::format("{}{:g}", list.empty() ? "" : ", ", mu1);
  }
  if (!rises.empty()) answer.verdict = Verdict::holds_in_part;
  answer.finding = fmt::format(
      "Steady alpha falls throughout for mu1 = {}, also rises for mu1 = {}. Not slowly: by up to {:.2f} rad "
      "per rad on the average (a weak pulse: 1/2, its middle moves).",
      falls, rises.empty() ? "none" : rises, -answer.value);
  return answer;
}

Answer alpha_over_amplitude(const Solver& solve) {
  double most = 0;
  for (const auto& [from, to] : {std::pair{1.0, 2.0}, {2.0, 5.0}, {5.0, 50.0}})
    most = std::max(
        most, degrees(spread(solve(paper_conditions(0.1, 2 * pi / 3, pi / 2), "amplitude_mm", from, to, 40)
                                 .steady_alpha_rad)));
  return {most > 5 ? Verdict::holds_in_part : Verdict::holds, most,
          fmt::format("Steady alpha moves by at most {:.2f} deg within each range above 1 mm; from rest "
                      "more, as 20 cycles are then only part of the transient.",
                      most)};
}

Answer alpha_over_frequency(const Solver& solve) {
  Scenario s = paper_conditions(0.1, 2 * pi / 3, pi / 2);
  const double w = s.drive.angular_frequency, amplitude = s.drive.amplitude;
  const double same_as_1_mm = w * std::sqrt(1e-3 / amplitude);
  const double first = solve(s, "omega_rad_s", same_as_1_mm, same_as_1_mm, 1).steady_alpha_rad[0];
  const Curve curve = solve(s, "omega_rad_s", 45, 160, 47);
  double off = 0, range = 0;
  for (std::size_t k = 0; k < curve.swept.size(); ++k) {
    const double alpha = curve.steady_alpha_rad[k];
    s.drive.amplitude = s.drive.amplitude_y = amplitude * curve.swept[k] * curve.swept[k] / (w * w);
    off = std::max(off, degrees_between(alpha, solve(s).steady_alpha_rad[0]));
    if (curve.swept[k] > same_as_1_mm) range = std::max(range, degrees_between(first, alpha));
  }
  return {off > kRounding ? Verdict::refuted : Verdict::exact, off,
          fmt::format("Exactly alike: steady alpha depends on A_e omega^2 alone, so that 1 mm at 62.8 rad/s "
                      "is {:.0f} rad/s at 0.28 mm; from there to 160 rad/s it moves by {:.1f} deg.",
                      same_as_1_mm, range)};
}

Answer alpha_over_ratio(const Solver& solve) {
  double most = 0;
  for (const auto& [conditions, scenario] : cases_of({0.1}, {pi / 6, 2 * pi / 3, pi}))
    most = std::max(most, degrees(spread(solve(scenario, "mu1_over_mu2", 2, 20, 37).steady_alpha_rad)));
  return {most > 10 ? Verdict::holds_in_part : Verdict::holds, most,
          fmt::format("It moves alpha by up to {:.1f} deg for mu1/mu2 between 2 and 20.", most)};
}

Answer effect_of_tilt(const Solver& solve) {
  constexpr double kTilt = 0.1 * pi / 180;
  double turned = 0, changed = 0;
  for (const auto& [conditions, scenario] :
       cases_of({0.05, 0.1, 0.12}, {pi / 6, pi / 3, pi / 2, 2 * pi / 3, pi, 3 * pi / 2})) {
    const Curve level = solve(scenario);
    for (int i = 0; i < 24; ++i) {
      Scenario tilted = scenario;
      tilted.drive.tilt_x = kTilt * std::cos(2 * pi * i / 24);
      tilted.drive.tilt_y = kTilt * std::sin(2 * pi * i / 24);
      const Curve here = solve(tilted);
      turned = std::max({turned, degrees_between(level.alpha_rad[0], here.alpha_rad[0]),
                         degrees_between(level.steady_alpha_rad[0], here.steady_alpha_rad[0])});
      changed = std::max({changed, 100 * std::abs(here.v_mm_s[0] / level.v_mm_s[0] - 1),
                          100 * std::abs(here.steady_v_mm_s[0] / level.steady_v_mm_s[0] - 1)});
    }
  }
  return {Verdict::holds_in_part, turned,
          fmt::format("0.1 deg of tilt turns alpha by up to {:.0f} deg and changes v by up to {:.0f} %, most "
                      "at narrow pulses: the model holds as far as the platform is level, and a fit to "
                      "recordings has to carry the tilt.",
                      turned, changed)};
}

Answer v_in_experiment(const Solver& solve) {
  const Values v = solve(paper_conditions(0.1, 0), "dtau_rad", pi / 12, pi, 45).v_mm_s;
  const double back = deepest_step_back(v, 1);
  return {back > 0 ? Verdict::holds_in_part : Verdict::holds, back,
          fmt::format("The model's v over 20 cycles from rest rises{}, from {:.2f} to {:.2f} mm/s.",
                      back > 0 ? ", though not throughout" : " throughout", v.front(), v.back())};
}

Answer further_in_experiment(const Solver&) {
  double least = HUGE_VAL;
  for (int i = 0; i < 8; ++i) {
    double last = 0;
    for (const double dtau : {pi / 6, pi / 3, pi / 2, 2 * pi / 3, pi}) {
      const double here = displacement_mm(paper_conditions(0.1, dtau, 2 * pi * i / 8));
      if (last > 0) least = std::min(least, here / last);
      last = here;
    }
  }
  return {least > 1 ? Verdict::holds : Verdict::holds_in_part, least,
          fmt::format("In the model, at every phi: over 20 cycles from rest each of pi/6, pi/3, pi/2, 2 "
                      "pi/3, pi takes it at least {:.2f} times as far as the one before.",
                      least)};
}

struct Stated {
  Statement statement;
  const char* conditions;  ///< of the number that decides; "": the answer's own
  Answer (*compute)(const Solver&);
};

constexpr Stated kStated[] = {
    {{3, "circular end state", "2.2, figure 3",
      "eventually the part starts to oscillate around the point of equilibrium in a circular trajectory",
      "radius and drift off the closed form, at most", ""},
     "mu1 below a/g",
     circular_end_state},
    {{3, "keeps moving", "2.2, figure 3 (mu not constant)", "In this case, the part continues to be moving",
      "v of the steady motion", "mm/s"},
     "mu1 = 0.122, A_e = 0.31 mm, dtau = pi/4",
     keeps_moving},
    {{4, "displacement over dtau", "2.2, figures 4a and 4b; 4",
      "When dtau increases, a higher system asymmetry is created, and due this reason the displacement of "
      "the part increases at the same number of circular oscillation cycles",
      "displacement grows at least", "times"},
     "dtau = pi/10 to pi/4",
     displacement_over_width},
    {{4, "alpha mostly by phi", "2.2, figures 4c and 4d",
      "The angle of displacement mainly depends on the phase shift phi", "alpha turned at least", "deg"},
     "phi = 11 pi/9 to 17 pi/9, dtau = pi/4",
     alpha_by_phase},
    {{5, "full circle", "2.2, figures 5 and 7a; 4",
      "The angle of displacement alpha can be controlled in a full range from 0 to 2 pi by changing the "
      "phase shift phi",
      "turns of alpha per turn of phi, 20 cycles from rest", ""},
     "",
     full_circle},
    {{5, "less stretched", "2.2, figure 5", "the trajectories at the higher value of dtau are less stretched",
      "displacement over path, at least", ""},
     "dtau = pi",
     less_stretched},
    {{6, "v over dtau", "2.2, figure 6a; 4",
      "As dtau increases up to 3 pi/2, the mean displacement velocity v also increases [...] However, a "
      "further increase in dtau results in a decrease in v",
      "dtau of the greatest v, steady", "rad"},
     "mu1 = 0.1, mu1/mu2 = 8",
     v_over_width},
    {{6, "v over mu1/mu2", "2.2, figure 6b",
      "As mu1/mu2 increases, the displacement velocity v increases as well", "deepest fall of steady v", "%"},
     "",
     [](const Solver& solve) {
       return v_along(solve, {"mu1_over_mu2", "mu1/mu2", "", 1, 20, 77}, 1,
                      cases_of({0.08, 0.1, 0.12}, {pi / 6, pi, 3 * pi / 2, 5.8}),
                      "Rises throughout, by less and less.");
     }},
    {{6, "v over A_e", "2.2, figure 6c", "The mean displacement velocity v increases as A_e increases",
      "deepest fall of steady v", "%"},
     "",
     [](const Solver& solve) {
       return v_along(solve, {"amplitude_mm", "A_e", " mm", 0.1, 2, 96}, 1,
                      cases_of({0.1}, {pi / 6, 2 * pi / 3, 3 * pi / 2}, pi / 2), "Rises throughout.");
     }},
    {{6, "v over omega", "2.2, figure 6d", "Similarly, as omega increases, v increases as well",
      "deepest fall of steady v", "%"},
     "",
     [](const Solver& solve) {
       return v_along(solve, {"omega_rad_s", "omega", " rad/s", 40, 160, 61}, 1,
                      cases_of({0.08, 0.1, 0.12}, {pi / 6, 2 * pi / 3, 3 * pi / 2}, pi / 2),
                      "Rises throughout.");
     }},
    {{6, "v over mu1", "2.2, figures 6b and 6d", "Also, higher v values were observed at lower mu1 values",
      "highest rise of steady v", "%"},
     "",
     [](const Solver& solve) {
       Cases cases = cases_of({0.1}, {pi / 6, pi / 3, 2 * pi / 3, pi, 3 * pi / 2});
       for (auto& [conditions, scenario] : cases) conditions.erase(0, conditions.find("dtau"));
       return v_along(solve, {"mu1", "mu1", "", 0.01, 0.2, 96}, -1, cases, "Falls throughout.");
     }},
    {{6, "v over phi", "2.2", "The modeling revealed that v does not depend on the phase shift phi",
      "spread of steady v over phi, at most", "%"},
     "",
     v_over_phase},
    {{7, "alpha linear in phi", "2.2, figure 7a", "A linear relation between alpha and phi was observed",
      "alpha off slope -1, steady, at most", "deg"},
     "",
     alpha_over_phase},
    {{7, "alpha over dtau", "2.2, figure 7b", "As dtau increases, alpha slowly decreases",
      "steepest mean slope of alpha, steady", "rad/rad"},
     "",
     alpha_over_width},
    {{7, "alpha over A_e", "2.2, figure 7c",
      "At higher amplitudes (higher than 1 mm), a negligible influence of A_e on the displacement angle "
      "alpha was observed",
      "range of steady alpha, at most", "deg"},
     "A_e above 1 mm",
     alpha_over_amplitude},
    {{7, "alpha over omega", "2.2, figure 7d",
      "Similar processes were observed as the angular frequency of the circular excitation was varying",
      "alpha off that at the same A_e omega^2, at most", "deg"},
     "mu1 = 0.1, dtau = 2 pi/3, omega = 45 to 160 rad/s",
     alpha_over_frequency},
    {{7, "alpha over mu1/mu2", "2.2",
      "The ratio mu1/mu2 does not have a high influence on the displacement angle alpha",
      "range of steady alpha, at most", "deg"},
     "mu1/mu2 = 2 to 20",
     alpha_over_ratio},
    {{9, "tilt", "2.1",
      "The manipulation system consists of a horizontal platform excited in two perpendicular directions",
      "alpha turned, at most", "deg"},
     "0.1 deg of tilt",
     effect_of_tilt},
    {{10, "v over dtau, measured", "3.2, figure 10",
      "In the analyzed range, an increase in the mean displacement velocity v was observed as dtau was "
      "increasing",
      "deepest fall of v", "%"},
     "mu1 = 0.1, dtau = pi/12 to pi",
     v_in_experiment},
    {{11, "further at wider dtau", "3.2, figure 11",
      "the part is displaced further under higher dtau values, after the same number of circular oscillation "
      "cycles",
      "displacement grows from one to the next at least", "times"},
     "dtau = pi/6, pi/3, pi/2, 2 pi/3, pi",
     further_in_experiment},
};

}  // namespace

std::vector<Claim> paper_claims(const Context& context, const std::function<void(int, int)>& progress) {
  Solver solver{context};
  solver.context.quiet = true;
  std::vector<Claim> claims;
  for (const Stated& stated : kStated) {
    claims.push_back({stated.statement, stated.compute(solver)});
    if (claims.back().conditions.empty()) claims.back().conditions = stated.conditions;
    if (progress) progress(static_cast<int>(claims.size()), static_cast<int>(std::size(kStated)));
  }
  return claims;
}

const char* to_string(Verdict verdict) {
  constexpr const char* kNames[] = {"exact", "holds", "holds in part", "refuted"};
  return kNames[static_cast<int>(verdict)];
}

}  // namespace tribotrack::apps
