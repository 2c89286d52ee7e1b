// What the paper states about trajectories, simulated (figures 3 to 5, 7d) and of the experiment (10, 11).
#include <algorithm>

#include "apps/bench/claims/sweeps.h"
#include "model/steady_orbit.h"
#include "model/trajectory.h"

namespace tribotrack::bench {

using namespace model;

namespace {

using std::numbers::pi;

/// Figures 3 and 4: 3 cycles from rest.
Scenario three_cycles(double amplitude, double dtau, double phi = 0) {
  constexpr double kMu1 = 0.122;
  Scenario s = paper_conditions(kMu1, dtau, phi);
  s.drive.amplitude = s.drive.amplitude_y = amplitude;
  s.cycles = 3;
  return s;
}

constexpr double kAmplitudes[] = {0.28e-3, 0.31e-3, 0.32e-3};  // of figure 4, m

std::string amplitude_is(double amplitude) {
  return text_of("mu1 = 0.122, A_e = %g mm", 1e3 * amplitude);
}

double displacement(const Scenario& scenario) {
  return drift_from_rest(scenario).v * scenario.end_time();
}

/// Displacement over length of the path: 1 for a straight walk, 0 for a closed circle.
double stretch(const Scenario& scenario) {
  constexpr int kChordsPerCycle = 200;  // shorter than their arcs by some 1e-4
  const Trajectory run = integrate(scenario);
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

}  // namespace

PaperClaim keeps_moving(bool) {
  PaperClaim claim{.name = "keeps moving",
                   .statement = "In this case, the part continues to be moving",
                   .place = "2.2, figure 3 (mu not constant)",
                   .figure = 3,
                   .verdict = Verdict::holds};
  const Scenario s = three_cycles(0.31e-3, pi / 4);
  const double steady = 1e3 * steady_drift(s).v, first = 1e3 * drift_from_rest(s).v;
  const std::string where = "mu1 = 0.122, A_e = 0.31 mm, dtau = pi/4";
  if (!(steady > 0)) claim.verdict = Verdict::refuted;
  claim.deciding = {where, "v of the steady motion", steady, "mm/s"};
  claim.figures = {claim.deciding, {where, "v over the first 3 cycles", first, "mm/s"}};
  claim.finding = text_of("It goes on at v = %.3f mm/s for ever, after %.3f mm/s over the first 3 cycles.",
                          steady, first);
  return claim;
}

PaperClaim displacement_over_width(bool quick) {
  PaperClaim claim{.name = "displacement over dtau",
                   .statement =
                       "When dtau increases, a higher system asymmetry is created, and due this reason the "
                       "displacement of the part increases at the same number of circular oscillation cycles",
                   .place = "2.2, figures 4a and 4b; 4",
                   .figure = 4,
                   .verdict = Verdict::holds};
  double least = HUGE_VAL, greatest = 0, first_peak = HUGE_VAL, last_peak = 0;
  for (const double amplitude : kAmplitudes) {
    const std::string where = amplitude_is(amplitude);
    const double narrow = displacement(three_cycles(amplitude, pi / 10)),
                 wide = displacement(three_cycles(amplitude, pi / 4));
    least = std::min(least, wide / narrow);
    greatest = std::max(greatest, wide / narrow);
    const double peak = width_of_greatest_v(three_cycles(amplitude, 0), false);
    first_peak = std::min(first_peak, peak);
    last_peak = std::max(last_peak, peak);
    std::vector<double> v;
    for (const double dtau : grid(pi / 10, peak, quick ? 10 : 60))
      v.push_back(displacement(three_cycles(amplitude, dtau)));
    claim.figures.push_back({where, "displacement at dtau = pi/10", 1e3 * narrow, "mm"});
    claim.figures.push_back({where, "displacement at dtau = pi/4", 1e3 * wide, "mm"});
    claim.figures.push_back({where, "dtau of the greatest displacement", peak, "rad"});
    claim.figures.push_back(
        {where, "deepest step back from pi/10 to there", 100 * deepest_step_back(v, 1), "%"});
    if (deepest_step_back(v, 1) > 0) claim.verdict = Verdict::refuted;
  }
  claim.deciding = {"dtau = pi/10 to pi/4", "displacement grows at least", least, "times"};
  if (least <= 1) claim.verdict = Verdict::refuted;
  if (claim.verdict == Verdict::holds && last_peak < 2 * pi) claim.verdict = Verdict::holds_in_part;
  claim.finding =
      text_of("From pi/10 to pi/4 the displacement over 3 cycles grows %.1f to %.1f times; ", least,
              greatest) +
      text_of("it grows up to dtau = %.2f to %.2f rad only and falls after.", first_peak, last_peak);
  return claim;
}

PaperClaim alpha_by_phase(bool) {
  PaperClaim claim{.name = "alpha mostly by phi",
                   .statement = "The angle of displacement mainly depends on the phase shift phi",
                   .place = "2.2, figures 4c and 4d",
                   .figure = 4,
                   .verdict = Verdict::holds};
  const double c = 11 * pi / 9, d = 17 * pi / 9;
  double by_phi = HUGE_VAL, by_width = 0, by_amplitude = 0;
  const double reference = drift_from_rest(three_cycles(kAmplitudes[0], pi / 4)).alpha;
  for (const double amplitude : kAmplitudes) {
    const auto alpha = [&](double dtau, double phi) {
      return drift_from_rest(three_cycles(amplitude, dtau, phi)).alpha;
    };
    by_phi = std::min(by_phi, degrees(std::fabs(turn_between(alpha(pi / 4, c), alpha(pi / 4, d)))));
    by_width = std::max(by_width, degrees(std::fabs(turn_between(alpha(pi / 10, 0), alpha(pi / 4, 0)))));
    by_amplitude = std::max(by_amplitude, degrees(std::fabs(turn_between(reference, alpha(pi / 4, 0)))));
  }
  claim.figures = {
      {"phi = 11 pi/9 to 17 pi/9, dtau = pi/4", "alpha turned at least", by_phi, "deg"},
      {"dtau = pi/10 to pi/4, phi = 0", "alpha turned at most", by_width, "deg"},
      {"A_e = 0.28 to 0.32 mm, phi = 0, dtau = pi/4", "alpha turned at most", by_amplitude, "deg"}};
  claim.deciding = claim.figures.front();
  if (by_phi < std::max(by_width, by_amplitude)) claim.verdict = Verdict::refuted;
  claim.finding =
      text_of("120 deg more of phi turn alpha by at least %.0f deg; ", by_phi) +
      text_of("dtau from pi/10 to pi/4 turns it by at most %.0f deg, A_e from 0.28 to 0.32 mm by %.0f deg.",
              by_width, by_amplitude);
  return claim;
}

PaperClaim less_stretched(bool quick) {
  PaperClaim claim{.name = "less stretched",
                   .statement = "the trajectories at the higher value of dtau are less stretched",
                   .place = "2.2, figure 5",
                   .figure = 5,
                   .verdict = Verdict::refuted};
  const int phases = quick ? 2 : 8;
  double narrow_most = 0, wide_least = HUGE_VAL;
  for (int i = 0; i < phases; ++i) {
    const double phi = 2 * pi * i / phases;
    const double narrow = stretch(paper_conditions(0.12, pi / 6, phi)),
                 wide = stretch(paper_conditions(0.12, pi, phi));
    const std::string where = text_of("mu1 = 0.12, phi = %.3f rad", phi);
    claim.figures.push_back({where, "displacement over path, dtau = pi/6", narrow, ""});
    claim.figures.push_back({where, "displacement over path, dtau = pi", wide, ""});
    narrow_most = std::max(narrow_most, narrow);
    wide_least = std::min(wide_least, wide);
  }
  if (wide_least <= narrow_most) claim.verdict = Verdict::holds_in_part;
  claim.deciding = {"dtau = pi", "displacement over path, at least", wide_least, ""};
  claim.finding = text_of(
                      "More stretched: the displacement is at least %.2f of the path at dtau = pi, at most "
                      "%.2f at pi/6. ",
                      wide_least, narrow_most) +
                  "The paper's own sentence on figure 4 says so too.";
  return claim;
}

PaperClaim alpha_over_frequency(bool quick) {
  PaperClaim claim{
      .name = "alpha over omega",
      .statement =
          "Similar processes were observed as the angular frequency of the circular excitation was varying",
      .place = "2.2, figure 7d",
      .figure = 7,
      .verdict = Verdict::exact};
  const double dtau = 2 * pi / 3;
  const Scenario s = paper_conditions(0.1, dtau, pi / 2);
  const double w = s.drive.angular_frequency, amplitude = s.drive.amplitude;
  double off = 0, range = 0;
  const double same_as_1_mm = w * std::sqrt(1e-3 / amplitude);
  const double first = [&] {
    Scenario fast = s;
    fast.drive.angular_frequency = same_as_1_mm;
    return steady_drift(fast).alpha;
  }();
  for (const double frequency : grid(45, 160, quick ? 8 : 47)) {
    Scenario fast = s, wide = s;
    fast.drive.angular_frequency = frequency;
    wide.drive.amplitude = wide.drive.amplitude_y = amplitude * frequency * frequency / (w * w);
    const double alpha = steady_drift(fast).alpha;
    off = std::max(off, std::fabs(turn_between(alpha, steady_drift(wide).alpha)));
    if (frequency > same_as_1_mm) range = std::max(range, std::fabs(turn_between(first, alpha)));
  }
  if (off > 1e-9) claim.verdict = Verdict::refuted;
  const std::string where = "mu1 = 0.1, dtau = 2 pi/3, omega = 45 to 160 rad/s";
  claim.deciding = {where, "alpha off that at the same A_e omega^2, at most", degrees(off), "deg"};
  claim.figures = {claim.deciding,
                   {"A_e = 0.28 mm", "omega with the steady alpha of 1 mm", same_as_1_mm, "rad/s"},
                   {where, "range of steady alpha above it", degrees(range), "deg"}};
  claim.finding = "Exactly alike: steady alpha depends on A_e omega^2 alone, " +
                  text_of(
                      "so that 1 mm at 62.8 rad/s is %.0f rad/s at 0.28 mm; from there to 160 rad/s it moves "
                      "by %.1f deg.",
                      same_as_1_mm, degrees(range));
  return claim;
}

PaperClaim v_in_experiment(bool quick) {
  PaperClaim claim{.name = "v over dtau, measured",
                   .statement =
                       "In the analyzed range, an increase in the mean displacement velocity v was observed "
                       "as dtau was increasing",
                   .place = "3.2, figure 10",
                   .figure = 10,
                   .verdict = Verdict::holds};
  std::vector<double> v;
  for (const double dtau : grid(pi / 12, pi, quick ? 12 : 45))
    v.push_back(1e3 * drift_from_rest(paper_conditions(0.1, dtau)).v);
  const std::string where = "mu1 = 0.1, dtau = pi/12 to pi";
  const double back = 100 * deepest_step_back(v, 1);
  if (back > 0) claim.verdict = Verdict::holds_in_part;
  claim.figures = {{where, "v at dtau = pi/12", v.front(), "mm/s"},
                   {where, "v at dtau = pi", v.back(), "mm/s"},
                   {where, "deepest fall of v", back, "%"}};
  claim.deciding = claim.figures.back();
  claim.finding = text_of("The model's v over 20 cycles from rest rises throughout, from %.2f to %.2f mm/s.",
                          v.front(), v.back());
  if (back > 0) claim.finding = "The model's v does not rise throughout: see the figures.";
  return claim;
}

PaperClaim further_in_experiment(bool quick) {
  PaperClaim claim{.name = "further at wider dtau",
                   .statement =
                       "the part is displaced further under higher dtau values, after the same number of "
                       "circular oscillation cycles",
                   .place = "3.2, figure 11",
                   .figure = 11,
                   .verdict = Verdict::holds};
  const int phases = quick ? 2 : 8;
  double least = HUGE_VAL;
  for (int i = 0; i < phases; ++i) {
    const double phi = 2 * pi * i / phases;
    double last = 0;
    for (const double dtau : {pi / 6, pi / 3, pi / 2, 2 * pi / 3, pi}) {
      const double here = displacement(paper_conditions(0.1, dtau, phi));
      if (last > 0) least = std::min(least, here / last);
      last = here;
      claim.figures.push_back(
          {conditions(0.1, dtau) + text_of(", phi = %.3f rad", phi), "displacement", 1e3 * here, "mm"});
    }
  }
  if (least <= 1) claim.verdict = Verdict::holds_in_part;
  claim.deciding = {"dtau = pi/6, pi/3, pi/2, 2 pi/3, pi", "displacement grows from one to the next at least",
                    least, "times"};
  claim.finding = text_of(
      "In the model, at every phi: over 20 cycles from rest each of pi/6, pi/3, pi/2, 2 pi/3, pi takes it at "
      "least %.2f times as far as the one before.",
      least);
  return claim;
}

}  // namespace tribotrack::bench
