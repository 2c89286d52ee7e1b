// What the paper states about the end state and the direction alpha.
#include <algorithm>
#include <cstdio>

#include "apps/bench/claims/sweeps.h"
#include "model/steady_orbit.h"
#include "model/trajectory.h"

namespace tribotrack::bench {

using namespace model;

namespace {

using std::numbers::pi;

/// alpha along a sweep, without its jumps of a whole turn.
std::vector<double> continuous_alpha(const std::vector<Drift>& drifts) {
  std::vector<double> alpha;
  for (const Drift& d : drifts)
    alpha.push_back(alpha.empty() ? d.alpha : alpha.back() + turn_between(alpha.back(), d.alpha));
  return alpha;
}

double spread(const std::vector<double>& values) {
  return max_of(values) - *std::min_element(values.begin(), values.end());
}

}  // namespace

PaperClaim circular_end_state(bool quick) {
  PaperClaim claim{
      .name = "circular end state",
      .statement =
          "eventually the part starts to oscillate around the point of equilibrium in a circular trajectory",
      .place = "2.2, figure 3",
      .figure = 3,
      .verdict = Verdict::exact,
      .finding =
          "The periodic motion at constant mu < a/g (a = A_e omega^2) is the circle of the closed form and "
          "goes nowhere; at higher mu the part rests."};
  double worst = 0;
  for (const double mu1 : quick ? std::vector{0.05, 0.1} : std::vector{0.02, 0.05, 0.08, 0.1, 0.11}) {
    Scenario s = paper_conditions(mu1, 0);
    const auto orbit = steady_orbit(s);
    const double w = s.drive.angular_frequency, a = s.drive.amplitude * w * w, m = mu1 * s.drive.gravity;
    const double radius = std::sqrt((a - m) * (a + m)) / (w * w);
    const double off = std::fabs(orbit->velocity.norm() / w - radius) / radius;
    const double drift = orbit->drift.norm() / s.drive.amplitude;
    worst = std::max({worst, off, drift});
    claim.figures.push_back({mu1_is(mu1), "radius", 1e3 * radius, "mm"});
    claim.figures.push_back({mu1_is(mu1), "radius off its closed form, relative", off, ""});
    claim.figures.push_back({mu1_is(mu1), "drift per cycle over A", drift, ""});
    claim.figures.push_back({mu1_is(mu1), "disturbance left after a cycle", orbit->contraction, ""});
  }
  if (worst > 1e-11) claim.verdict = Verdict::refuted;
  claim.deciding = {"mu1 below a/g", "radius and drift off the closed form, at most", worst, ""};
  return claim;
}

PaperClaim full_circle(bool quick) {
  PaperClaim claim{.name = "full circle",
                   .statement =
                       "The angle of displacement alpha can be controlled in a full range from 0 to 2 pi by "
                       "changing the phase shift phi",
                   .place = "2.2, figures 5 and 7a; 4",
                   .figure = 5,
                   .verdict = Verdict::holds,
                   .finding = "Over one turn of phi alpha turns once the other way, from rest as well."};
  const int count = quick ? 24 : 72;
  for (const double dtau : {pi / 6, pi / 3, pi}) {
    Scenario s = paper_conditions(0.1, dtau);
    std::vector<Drift> drifts;
    for (int i = 0; i <= count; ++i) {
      s.friction.phase = 2 * pi * i / count;
      drifts.push_back(drift_from_rest(s));
    }
    const std::vector<double> alpha = continuous_alpha(drifts);
    const double turns = (alpha.back() - alpha.front()) / (2 * pi);
    if (std::lround(turns) != -1) claim.verdict = Verdict::refuted;
    claim.figures.push_back(
        {conditions(0.1, dtau), "turns of alpha per turn of phi, 20 cycles from rest", turns, ""});
    claim.deciding = claim.figures.back();
  }
  return claim;
}

PaperClaim linear_in_phase(bool quick) {
  PaperClaim claim{.name = "alpha linear in phi",
                   .statement = "A linear relation between alpha and phi was observed",
                   .place = "2.2, figure 7a",
                   .figure = 7,
                   .verdict = Verdict::exact};
  double most_steady = 0, most = 0;
  std::string most_at;
  const int count = quick ? 12 : 72;
  for (const double mu1 : quick ? std::vector{0.1, 0.12} : std::vector{0.02, 0.05, 0.08, 0.1, 0.12, 0.122})
    for (const double dtau : {pi / 6, pi / 3, pi / 2, pi}) {
      const Scenario s = paper_conditions(mu1, dtau);
      const double steady = sweep_phase(s, steady_drift, count).off_line;
      const double rest = sweep_phase(s, drift_from_rest, count).off_line;
      if (steady > 1e-9) claim.verdict = Verdict::refuted;
      most_steady = std::max(most_steady, steady);
      if (rest > most) {
        most = rest;
        most_at = conditions(mu1, dtau);
      }
      claim.figures.push_back({conditions(mu1, dtau), "alpha off slope -1, steady", degrees(steady), "deg"});
      claim.figures.push_back(
          {conditions(mu1, dtau), "alpha off slope -1, 20 cycles from rest", degrees(rest), "deg"});
    }
  claim.finding = text_of(
                      "Steady: slope exactly -1 (rotation). Over 20 cycles from rest alpha leaves the line "
                      "by up to %.1f deg (",
                      degrees(most)) +
                  most_at + "), since the transient does not turn with phi.";
  claim.deciding = {"", "alpha off slope -1, steady, at most", degrees(most_steady), "deg"};
  return claim;
}

PaperClaim alpha_over_width(bool quick) {
  PaperClaim claim{.name = "alpha over dtau",
                   .statement = "As dtau increases, alpha slowly decreases",
                   .place = "2.2, figure 7b",
                   .figure = 7,
                   .verdict = Verdict::holds};
  double steepest = 0;
  std::string falls, rises;  // mu1 for which alpha only falls, also rises
  for (const double mu1 :
       quick ? std::vector{0.08, 0.12} : std::vector{0.02, 0.05, 0.08, 0.1, 0.11, 0.12, 0.122}) {
    const std::vector<double> width = grid(0.1, 6.2, quick ? 16 : 62);
    for (const bool steady : {true, false}) {
      std::vector<Drift> drifts;
      for (const double dtau : width) {
        const Scenario s = paper_conditions(mu1, dtau);
        drifts.push_back(steady ? steady_drift(s) : drift_from_rest(s));
      }
      const std::vector<double> alpha = continuous_alpha(drifts);
      const std::string which = steady ? ", steady" : ", 20 cycles from rest";
      const double mean = (alpha.back() - alpha.front()) / (width.back() - width.front());
      double largest = -HUGE_VAL, least = HUGE_VAL;
      for (size_t i = 1; i < alpha.size(); ++i) {
        const double slope = (alpha[i] - alpha[i - 1]) / (width[i] - width[i - 1]);
        largest = std::max(largest, slope);
        least = std::min(least, slope);
      }
      claim.figures.push_back({mu1_is(mu1), "mean slope of alpha over dtau" + which, mean, "rad/rad"});
      claim.figures.push_back({mu1_is(mu1), "least slope" + which, least, "rad/rad"});
      claim.figures.push_back({mu1_is(mu1), "greatest slope" + which, largest, "rad/rad"});
      if (!steady) continue;
      std::string& list = largest > 1e-9 ? rises : falls;
      list += (list.empty() ? "" : ", ") + mu1_is(mu1).substr(6);
      if (largest > 1e-9) claim.verdict = Verdict::holds_in_part;
      if (mean < steepest)
        claim.deciding = {mu1_is(mu1), "steepest mean slope of alpha, steady", mean, "rad/rad"};
      steepest = std::min(steepest, mean);
    }
  }
  char text[240];
  std::snprintf(text, sizeof text,
                "Steady alpha falls throughout for mu1 = %s, also rises for mu1 = %s. Not slowly: by up to "
                "%.2f rad per rad on the average (a weak pulse: 1/2, its middle moves).",
                falls.c_str(), rises.empty() ? "none" : rises.c_str(), -steepest);
  claim.finding = text;
  return claim;
}

PaperClaim alpha_over_ratio(bool quick) {
  PaperClaim claim{
      .name = "alpha over mu1/mu2",
      .statement = "The ratio mu1/mu2 does not have a high influence on the displacement angle alpha",
      .place = "2.2",
      .figure = 7,
      .verdict = Verdict::holds};
  double most = 0;
  for (const double dtau : {pi / 6, 2 * pi / 3, pi}) {
    std::vector<Drift> drifts;
    for (const double ratio : grid(2, 20, quick ? 7 : 37)) {
      Scenario s = paper_conditions(0.1, dtau);
      s.friction.reduced = s.friction.nominal / ratio;
      drifts.push_back(steady_drift(s));
    }
    const double range = spread(continuous_alpha(drifts));
    most = std::max(most, range);
    claim.figures.push_back(
        {conditions(0.1, dtau), "range of steady alpha for mu1/mu2 = 2 to 20", degrees(range), "deg"});
  }
  if (degrees(most) > 10) claim.verdict = Verdict::holds_in_part;
  claim.deciding = {"mu1/mu2 = 2 to 20", "range of steady alpha, at most", degrees(most), "deg"};
  char text[120];
  std::snprintf(text, sizeof text, "It moves alpha by up to %.1f deg for mu1/mu2 between 2 and 20.",
                degrees(most));
  claim.finding = text;
  return claim;
}

PaperClaim alpha_over_amplitude(bool quick) {
  PaperClaim claim{.name = "alpha over A_e",
                   .statement =
                       "At higher amplitudes (higher than 1 mm), a negligible influence of A_e on the "
                       "displacement angle alpha was observed",
                   .place = "2.2, figure 7c",
                   .figure = 7,
                   .verdict = Verdict::holds};
  const double dtau = 2 * pi / 3;
  double most = 0;
  for (const bool steady : {true, false})
    for (const auto& [from, to] : {std::pair{0.3e-3, 1e-3}, {1e-3, 2e-3}, {2e-3, 5e-3}, {5e-3, 50e-3}}) {
      std::vector<Drift> drifts;
      for (const double amplitude : grid(from, to, quick ? 6 : 40)) {
        Scenario s = paper_conditions(0.1, dtau, pi / 2);
        s.drive.amplitude = s.drive.amplitude_y = amplitude;
        drifts.push_back(steady ? steady_drift(s) : drift_from_rest(s));
      }
      const double range = spread(continuous_alpha(drifts));
      if (from >= 1e-3 && steady) most = std::max(most, range);
      char text[120];
      std::snprintf(text, sizeof text, "A_e = %g to %g mm, dtau = 2 pi/3", 1e3 * from, 1e3 * to);
      claim.figures.push_back({text,
                               steady ? "range of alpha, steady" : "range of alpha, 20 cycles from rest",
                               degrees(range), "deg"});
    }
  if (degrees(most) > 5) claim.verdict = Verdict::holds_in_part;
  claim.deciding = {"A_e above 1 mm", "range of steady alpha, at most", degrees(most), "deg"};
  char text[160];
  std::snprintf(text, sizeof text,
                "Steady alpha moves by at most %.2f deg within each range above 1 mm; from rest more, as 20 "
                "cycles are then only part of the transient.",
                degrees(most));
  claim.finding = text;
  return claim;
}

}  // namespace tribotrack::bench
