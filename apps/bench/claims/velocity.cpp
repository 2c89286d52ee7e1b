// What the paper states about the mean velocity v, and what a tilt of the platform does to both.
#include <algorithm>
#include <cstdio>

#include "apps/bench/claims/sweeps.h"

namespace tribotrack::bench {

using namespace model;

namespace {

using std::numbers::pi;

std::string text_of(const char* format, double a, double b = 0) {
  char text[120];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

constexpr const char* kMuAndWidth = "mu1 = %g, dtau = %.3f rad";

/// v along a sweep of one number, steady.
std::vector<double> steady_v(const std::vector<double>& values, const Scenario& base,
                             const std::function<void(Scenario&, double)>& set) {
  std::vector<double> v;
  for (const double value : values) {
    Scenario s = base;
    set(s, value);
    v.push_back(steady_drift(s).v);
  }
  return v;
}

/// One sweep's figures: v at both ends, and where it first goes the other way.
void add_sweep(PaperClaim& claim, const std::string& conditions, const std::vector<double>& swept,
               const std::vector<double>& v, int sign, double unit_factor, const std::string& unit) {
  const Monotony m = monotony(swept, v, sign);
  claim.figures.push_back({conditions, "v at the sweep's start", 1e3 * v.front(), "mm/s"});
  claim.figures.push_back({conditions, "v at its end", 1e3 * v.back(), "mm/s"});
  if (m.holds) return;
  claim.verdict = Verdict::holds_in_part;
  const std::string wrong = sign > 0 ? "v falls" : "v rises";
  claim.figures.push_back({conditions, wrong + " from", unit_factor * m.fails_from, unit});
  claim.figures.push_back({conditions, wrong + " until", unit_factor * m.fails_to, unit});
  claim.finding += (claim.finding.empty() ? "Not for " : "; ") + conditions + ": " + wrong +
                   text_of(" from %.4g to %.4g", unit_factor * m.fails_from, unit_factor * m.fails_to) +
                   (unit.empty() ? "" : " " + unit);
}

std::string summed_up(const PaperClaim& claim, const char* if_true) {
  return claim.finding.empty() ? if_true : claim.finding + ".";
}

}  // namespace

PaperClaim v_independent_of_phase(bool quick) {
  PaperClaim claim{"v over phi",
                   "v does not depend on phi",
                   "2.2",
                   Verdict::exact,
                   "Steady: exactly (rotation). Over 20 cycles from rest it does, by the spread below.",
                   {}};
  for (const double mu1 : quick ? std::vector{0.1, 0.12} : std::vector{0.05, 0.1, 0.12, 0.122})
    for (const double dtau : {pi / 6, pi / 3, pi}) {
      const Scenario s = paper_conditions(mu1, dtau);
      const double steady = sweep_phase(s, steady_drift, quick ? 12 : 72).v_spread;
      const double rest = sweep_phase(s, drift_from_rest, quick ? 12 : 72).v_spread;
      if (steady > 1e-9) claim.verdict = Verdict::fails;
      const std::string where = text_of(kMuAndWidth, mu1, dtau);
      claim.figures.push_back({where, "spread of v, steady", 100 * steady, "%"});
      claim.figures.push_back({where, "spread of v, 20 cycles from rest", 100 * rest, "%"});
    }
  return claim;
}

PaperClaim v_over_width(bool quick) {
  PaperClaim claim{"v over dtau",
                   "v rises with dtau up to 3 pi/2 (4.712 rad) and falls after",
                   "2.2, figure 6a; 4",
                   Verdict::holds,
                   "",
                   {}};
  double least = HUGE_VAL, greatest = 0;
  for (const double mu1 :
       quick ? std::vector{0.1, 0.12} : std::vector{0.02, 0.05, 0.08, 0.1, 0.11, 0.12, 0.122})
    for (const double ratio : quick ? std::vector{8.0} : std::vector{2.0, 4.0, 8.0, 16.0, 50.0}) {
      Scenario s = paper_conditions(mu1, 0);
      s.friction.reduced = mu1 / ratio;
      const double widest = width_of_greatest_v(s);
      const auto set = [](Scenario& x, double dtau) { x.friction.pulse_width = dtau; };
      const std::vector<double> before = grid(0, widest, quick ? 10 : 40),
                                after = grid(widest, 2 * pi, quick ? 6 : 20);
      const bool one_peak = monotony(before, steady_v(before, s, set), 1).holds &&
                            monotony(after, steady_v(after, s, set), -1).holds;
      if (!one_peak) claim.verdict = Verdict::fails;
      least = std::min(least, widest);
      greatest = std::max(greatest, widest);
      s.friction.pulse_width = widest;
      const std::string where = text_of("mu1 = %g, mu1/mu2 = %g", mu1, ratio);
      claim.figures.push_back({where, "dtau of the greatest v, steady", widest, "rad"});
      const double v = steady_drift(s).v;
      claim.figures.push_back({where, "greatest v, steady", 1e3 * v, "mm/s"});
      s.friction.pulse_width = 1.5 * pi;
      claim.figures.push_back(
          {where, "v at 3 pi/2 below it, steady", 100 * (1 - steady_drift(s).v / v), "%"});
      claim.figures.push_back(
          {where, "dtau of the greatest v, 20 cycles from rest", width_of_greatest_v(s, false), "rad"});
    }
  claim.finding = "One maximum" + text_of(", at dtau = %.3f to %.3f rad", least, greatest) +
                  " depending on mu1 and mu1/mu2.";
  if (claim.verdict == Verdict::fails) claim.finding = "More than one maximum somewhere: see the figures.";
  if (claim.verdict == Verdict::holds && std::max(greatest - 1.5 * pi, 1.5 * pi - least) > 0.1)
    claim.verdict = Verdict::holds_in_part;
  return claim;
}

PaperClaim v_over_ratio(bool quick) {
  PaperClaim claim{"v over mu1/mu2", "v rises with mu1/mu2", "2.2, figure 6b", Verdict::holds, "", {}};
  const std::vector<double> ratios = grid(1, 20, quick ? 11 : 77);
  for (const double mu1 : {0.08, 0.1, 0.12})
    for (const double dtau : {pi / 6, pi, 3 * pi / 2, 5.8}) {
      const auto v = steady_v(ratios, paper_conditions(mu1, dtau), [](Scenario& s, double ratio) {
        s.friction.reduced = s.friction.nominal / ratio;
      });
      add_sweep(claim, text_of(kMuAndWidth, mu1, dtau) + ", mu1/mu2 = 1 to 20", ratios, v, 1, 1, "");
    }
  claim.finding = summed_up(claim, "Rises throughout, by less and less.");
  return claim;
}

PaperClaim v_over_amplitude(bool quick) {
  PaperClaim claim{"v over A", "v rises with A", "2.2, figure 6c", Verdict::holds, "", {}};
  const std::vector<double> amplitudes = grid(0.1e-3, 2e-3, quick ? 12 : 96);
  for (const double dtau : {pi / 6, 2 * pi / 3, 3 * pi / 2}) {
    const auto v =
        steady_v(amplitudes, paper_conditions(0.1, dtau, pi / 2),
                 [](Scenario& s, double amplitude) { s.drive.amplitude = s.drive.amplitude_y = amplitude; });
    add_sweep(claim, text_of(kMuAndWidth, 0.1, dtau) + ", A = 0.1 to 2 mm", amplitudes, v, 1, 1e3, "mm");
  }
  claim.finding = summed_up(claim, "Rises throughout.");
  return claim;
}

PaperClaim v_over_frequency(bool quick) {
  PaperClaim claim{"v over w", "v rises with w", "2.2, figure 6d", Verdict::holds, "", {}};
  const std::vector<double> frequencies = grid(40, 160, quick ? 13 : 61);
  for (const double mu1 : {0.08, 0.1, 0.12})
    for (const double dtau : {pi / 6, 2 * pi / 3, 3 * pi / 2}) {
      const auto v = steady_v(frequencies, paper_conditions(mu1, dtau, pi / 2),
                              [](Scenario& s, double w) { s.drive.angular_frequency = w; });
      add_sweep(claim, text_of(kMuAndWidth, mu1, dtau) + ", w = 40 to 160 rad/s", frequencies, v, 1, 1,
                "rad/s");
    }
  claim.finding = summed_up(claim, "Rises throughout.");
  return claim;
}

PaperClaim v_over_friction(bool quick) {
  PaperClaim claim{
      "v over mu1", "v falls with mu1 (mu2 = mu1/8)", "2.2, figures 6b and 6d", Verdict::holds, "", {}};
  const std::vector<double> friction = grid(0.01, 0.2, quick ? 20 : 96);
  for (const double dtau : {pi / 6, pi / 3, 2 * pi / 3, pi, 3 * pi / 2}) {
    const auto v = steady_v(friction, paper_conditions(0.1, dtau), [](Scenario& s, double mu1) {
      s.friction.nominal = mu1;
      s.friction.reduced = mu1 / 8;
    });
    add_sweep(claim, text_of("dtau = %.3f rad, mu1 = 0.01 to 0.2", dtau), friction, v, -1, 1, "");
  }
  claim.finding = summed_up(claim, "Falls throughout.");
  return claim;
}

PaperClaim effect_of_tilt(bool quick) {
  PaperClaim claim{
      "tilt", "the platform is horizontal (a tilt is left out)", "2.1", Verdict::holds_in_part, "", {}};
  const double tilt = 0.1 * pi / 180;
  double most_alpha = 0, most_v = 0;
  for (const double mu1 : quick ? std::vector{0.1} : std::vector{0.05, 0.1, 0.12})
    for (const double dtau : {pi / 6, pi / 3, pi / 2, 2 * pi / 3, pi, 3 * pi / 2}) {
      Scenario s = paper_conditions(mu1, dtau);
      for (const bool steady : {true, false}) {
        const auto drift = steady ? steady_drift : drift_from_rest;
        const Drift level = drift(s);
        double turned = 0, changed = 0;
        const int directions = quick ? 8 : 24;
        for (int i = 0; i < directions; ++i) {
          Scenario tilted = s;
          tilted.drive.tilt_x = tilt * std::cos(2 * pi * i / directions);
          tilted.drive.tilt_y = tilt * std::sin(2 * pi * i / directions);
          const Drift d = drift(tilted);
          turned = std::max(turned, std::fabs(turn_between(level.alpha, d.alpha)));
          changed = std::max(changed, std::fabs(d.v / level.v - 1));
        }
        const std::string where = text_of(kMuAndWidth, mu1, dtau),
                          which = steady ? ", steady" : ", 20 cycles from rest";
        claim.figures.push_back(
            {where, "0.1 deg of tilt turns alpha by up to" + which, degrees(turned), "deg"});
        claim.figures.push_back({where, "and changes v by up to" + which, 100 * changed, "%"});
        most_alpha = std::max(most_alpha, degrees(turned));
        most_v = std::max(most_v, 100 * changed);
      }
    }
  claim.finding = text_of("0.1 deg of tilt turns alpha by up to %.0f deg and changes v by up to %.0f %%, ",
                          most_alpha, most_v) +
                  "most at narrow pulses: a fit to recordings has to carry it.";
  return claim;
}

}  // namespace tribotrack::bench
