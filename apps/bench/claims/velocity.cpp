// What the paper states about the mean velocity v, and what a tilt of the platform does to both.
#include <algorithm>
#include <cstdio>

#include "apps/bench/claims/sweeps.h"

namespace tribotrack::bench {

using namespace model;

namespace {

using std::numbers::pi;

/// v along a sweep of one number, steady.
std::vector<double> steady_v(const std::vector<double>& values, const Scenario& base,
                             const std::function<void(Scenario&, double)>& set) {
  std::vector<Scenario> scenarios(values.size(), base);
  for (std::size_t k = 0; k < values.size(); ++k) set(scenarios[k], values[k]);
  return bench::steady_v(scenarios);
}

/// What is swept, for texts.
struct Swept {
  const char* name;
  std::vector<double> values;
  double unit_factor;  ///< from SI
  const char* unit;    ///< with its blank before it; "": a pure number
};

/// One sweep's figures: v at both ends, and where it first goes the other way. The deepest such step decides.
void add_sweep(PaperClaim& claim, const std::string& others, const Swept& swept, const std::vector<double>& v,
               int sign) {
  const auto range = [&](double from, double to) {
    return swept.name + text_of(" = %.4g to %.4g", swept.unit_factor * from, swept.unit_factor * to) +
           swept.unit;
  };
  const std::string where = others + ", " + range(swept.values.front(), swept.values.back());
  claim.figures.push_back({where, "v at the sweep's start", 1e3 * v.front(), "mm/s"});
  claim.figures.push_back({where, "v at its end", 1e3 * v.back(), "mm/s"});
  const double back = 100 * deepest_step_back(v, sign);
  if (claim.deciding.quantity.empty() || back > claim.deciding.value)
    claim.deciding = {where, sign > 0 ? "deepest fall of steady v" : "highest rise of steady v", back, "%"};
  const Monotony m = monotony(swept.values, v, sign);
  if (m.holds) return;
  claim.verdict = Verdict::holds_in_part;
  const std::string wrong = sign > 0 ? "v falls" : "v rises";
  const std::string unit = *swept.unit ? swept.unit + 1 : "";
  claim.figures.push_back({where, wrong + " from", swept.unit_factor * m.fails_from, unit});
  claim.figures.push_back({where, wrong + " until", swept.unit_factor * m.fails_to, unit});
  claim.finding += (claim.finding.empty() ? "Not for " : "; ") + others + ": " + wrong + " from " +
                   range(m.fails_from, m.fails_to);
}

std::string summed_up(const PaperClaim& claim, const char* if_true) {
  return claim.finding.empty() ? if_true : claim.finding + ".";
}

}  // namespace

PaperClaim v_independent_of_phase(bool quick) {
  PaperClaim claim{.name = "v over phi",
                   .statement = "The modeling revealed that v does not depend on the phase shift phi",
                   .place = "2.2",
                   .figure = 6,
                   .verdict = Verdict::exact};
  double most_steady = 0, most = 0;
  std::string most_at;
  for (const double mu1 : quick ? std::vector{0.1, 0.12} : std::vector{0.05, 0.1, 0.12, 0.122})
    for (const double dtau : {pi / 6, pi / 3, pi}) {
      const Scenario s = paper_conditions(mu1, dtau);
      const double steady = sweep_phase(s, steady_drift, quick ? 12 : 72).v_spread;
      const double rest = sweep_phase(s, drift_from_rest, quick ? 12 : 72).v_spread;
      if (steady > 1e-9) claim.verdict = Verdict::refuted;
      const std::string where = conditions(mu1, dtau);
      most_steady = std::max(most_steady, steady);
      if (rest > most) {
        most = rest;
        most_at = where;
      }
      claim.figures.push_back({where, "spread of v, steady", 100 * steady, "%"});
      claim.figures.push_back({where, "spread of v, 20 cycles from rest", 100 * rest, "%"});
    }
  claim.finding =
      text_of("Steady: exactly (rotation). Over 20 cycles from rest v varies with phi by up to %.0f %% (",
              100 * most) +
      most_at + ").";
  claim.deciding = {"", "spread of steady v over phi, at most", 100 * most_steady, "%"};
  return claim;
}

PaperClaim v_over_width(bool quick) {
  PaperClaim claim{.name = "v over dtau",
                   .statement =
                       "As dtau increases up to 3 pi/2, the mean displacement velocity v also increases "
                       "[...] However, a further increase in dtau results in a decrease in v",
                   .place = "2.2, figure 6a; 4",
                   .figure = 6,
                   .verdict = Verdict::holds};
  constexpr double kOfFigure6 = 8;  // mu1/mu2
  double below = 0;                 // v at 3 pi/2, under the same conditions, %
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
      if (!one_peak) claim.verdict = Verdict::refuted;
      least = std::min(least, widest);
      greatest = std::max(greatest, widest);
      s.friction.pulse_width = widest;
      const std::string where = text_of("mu1 = %g, mu1/mu2 = %g", mu1, ratio);
      claim.figures.push_back({where, "dtau of the greatest v, steady", widest, "rad"});
      if (mu1 == 0.1 && ratio == kOfFigure6) claim.deciding = claim.figures.back();
      const double v = steady_drift(s).v;
      claim.figures.push_back({where, "greatest v, steady", 1e3 * v, "mm/s"});
      s.friction.pulse_width = 1.5 * pi;
      claim.figures.push_back(
          {where, "v at 3 pi/2 below it, steady", 100 * (1 - steady_drift(s).v / v), "%"});
      if (mu1 == 0.1 && ratio == kOfFigure6) below = claim.figures.back().value;
      claim.figures.push_back(
          {where, "dtau of the greatest v, 20 cycles from rest", width_of_greatest_v(s, false), "rad"});
    }
  claim.finding = "One maximum" +
                  text_of(", not at 3 pi/2 = 4.712 rad but at dtau = %.3f to %.3f rad", least, greatest) +
                  ", set mostly by mu1/mu2" +
                  text_of(": at %.3f rad for mu1 = 0.1, mu1/mu2 = %.0f", claim.deciding.value, kOfFigure6) +
                  text_of(", where v at 3 pi/2 is %.1f %% below it.", below);
  if (claim.verdict == Verdict::refuted) claim.finding = "More than one maximum somewhere: see the figures.";
  if (claim.verdict == Verdict::holds && std::max(greatest - 1.5 * pi, 1.5 * pi - least) > 0.1)
    claim.verdict = Verdict::holds_in_part;
  return claim;
}

PaperClaim v_over_ratio(bool quick) {
  PaperClaim claim{.name = "v over mu1/mu2",
                   .statement = "As mu1/mu2 increases, the displacement velocity v increases as well",
                   .place = "2.2, figure 6b",
                   .figure = 6,
                   .verdict = Verdict::holds};
  const std::vector<double> ratios = grid(1, 20, quick ? 11 : 77);
  for (const double mu1 : {0.08, 0.1, 0.12})
    for (const double dtau : {pi / 6, pi, 3 * pi / 2, 5.8}) {
      const auto v = steady_v(ratios, paper_conditions(mu1, dtau), [](Scenario& s, double ratio) {
        s.friction.reduced = s.friction.nominal / ratio;
      });
      add_sweep(claim, conditions(mu1, dtau), {"mu1/mu2", ratios, 1, ""}, v, 1);
    }
  claim.finding = summed_up(claim, "Rises throughout, by less and less.");
  return claim;
}

PaperClaim v_over_amplitude(bool quick) {
  PaperClaim claim{.name = "v over A_e",
                   .statement = "The mean displacement velocity v increases as A_e increases",
                   .place = "2.2, figure 6c",
                   .figure = 6,
                   .verdict = Verdict::holds};
  const std::vector<double> amplitudes = grid(0.1e-3, 2e-3, quick ? 12 : 96);
  for (const double dtau : {pi / 6, 2 * pi / 3, 3 * pi / 2}) {
    const auto v =
        steady_v(amplitudes, paper_conditions(0.1, dtau, pi / 2),
                 [](Scenario& s, double amplitude) { s.drive.amplitude = s.drive.amplitude_y = amplitude; });
    add_sweep(claim, conditions(0.1, dtau), {"A_e", amplitudes, 1e3, " mm"}, v, 1);
  }
  claim.finding = summed_up(claim, "Rises throughout.");
  return claim;
}

PaperClaim v_over_frequency(bool quick) {
  PaperClaim claim{.name = "v over omega",
                   .statement = "Similarly, as omega increases, v increases as well",
                   .place = "2.2, figure 6d",
                   .figure = 6,
                   .verdict = Verdict::holds};
  const std::vector<double> frequencies = grid(40, 160, quick ? 13 : 61);
  for (const double mu1 : {0.08, 0.1, 0.12})
    for (const double dtau : {pi / 6, 2 * pi / 3, 3 * pi / 2}) {
      const auto v = steady_v(frequencies, paper_conditions(mu1, dtau, pi / 2),
                              [](Scenario& s, double w) { s.drive.angular_frequency = w; });
      add_sweep(claim, conditions(mu1, dtau), {"omega", frequencies, 1, " rad/s"}, v, 1);
    }
  claim.finding = summed_up(claim, "Rises throughout.");
  return claim;
}

PaperClaim v_over_friction(bool quick) {
  PaperClaim claim{.name = "v over mu1",
                   .statement = "Also, higher v values were observed at lower mu1 values",
                   .place = "2.2, figures 6b and 6d",
                   .figure = 6,
                   .verdict = Verdict::holds};
  const std::vector<double> friction = grid(0.01, 0.2, quick ? 20 : 96);
  for (const double dtau : {pi / 6, pi / 3, 2 * pi / 3, pi, 3 * pi / 2}) {
    const auto v = steady_v(friction, paper_conditions(0.1, dtau), [](Scenario& s, double mu1) {
      s.friction.nominal = mu1;
      s.friction.reduced = mu1 / 8;
    });
    add_sweep(claim, text_of("dtau = %.3f rad", dtau), {"mu1", friction, 1, ""}, v, -1);
  }
  claim.finding = summed_up(claim, "Falls throughout.");
  return claim;
}

PaperClaim effect_of_tilt(bool quick) {
  PaperClaim claim{
      .name = "tilt",
      .statement =
          "The manipulation system consists of a horizontal platform excited in two perpendicular directions",
      .place = "2.1",
      .figure = 9,
      .verdict = Verdict::holds_in_part};
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
        const std::string where = conditions(mu1, dtau),
                          which = steady ? ", steady" : ", 20 cycles from rest";
        claim.figures.push_back(
            {where, "0.1 deg of tilt turns alpha by up to" + which, degrees(turned), "deg"});
        claim.figures.push_back({where, "and changes v by up to" + which, 100 * changed, "%"});
        most_alpha = std::max(most_alpha, degrees(turned));
        most_v = std::max(most_v, 100 * changed);
      }
    }
  claim.deciding = {"0.1 deg of tilt", "alpha turned, at most", most_alpha, "deg"};
  claim.finding = text_of("0.1 deg of tilt turns alpha by up to %.0f deg and changes v by up to %.0f %%, ",
                          most_alpha, most_v) +
                  "most at narrow pulses: the model holds as far as the platform is level, and a fit to "
                  "recordings has to carry the tilt.";
  return claim;
}

}  // namespace tribotrack::bench
